#include "proxy/command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/text.h"
#include "model/point.h"
#include "proxy/tuple_text.h"
#include "rubicon/key.hpp"
#include "rubicon/summary.hpp"

namespace rubicon::proxy {

namespace {

constexpr std::size_t kMaxName = 60;

/// A text of a foreign summary, printable and cut after a character.
std::string shown_text(std::string_view text) {
  std::size_t end = 0;
  while (end < text.size()) {
    const auto length = base::first_character(text.substr(end)).size();
    if (end + length > kMaxName) break;
    end += length;
  }
  return base::printable(text.substr(0, end));
}

std::string island_name(std::string name, OwnerId id) {
  return name.empty() ? fmt::format("island {}", number(id)) : fmt::format("{} (island {})", name, number(id));
}

}  // namespace

std::string commander_name(const TupleSpace& space, const ProxyConfig& config, OwnerId id) {
  if (id == space.self()) return island_name(config.island_name, id);
  const auto text = space.summary(id);
  const auto summary = text.empty() ? model::Summary{} : model::summary_from_json(text).value_or(model::Summary{});
  const auto name = shown_text(summary.name);
  // A component without a summary has just appeared: its id is all that is known.
  if (model::is_island(id) && (text.empty() || !summary.prefix.empty())) return island_name(name, id);
  if (name.empty()) return fmt::format("component {}", number(id));
  const bool elsewhere = !summary.host.empty() && summary.host != config.host;
  const auto program = summary.program.empty() ? fmt::format("component {}", number(id)) : shown_text(summary.program);
  return fmt::format("{} ({}{}{})", name, program, elsewhere ? " on " : "", elsewhere ? shown_text(summary.host) : "");
}

namespace {

constexpr std::size_t kMaxCommand = 4096;

std::optional<double> as_number(const Value& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
  if (const auto* real = std::get_if<double>(&value)) return *real;
  return std::nullopt;
}

/// The value of a point without a type of the catalogue: a number if the text is one, else the text.
Value untyped(std::string_view text) {
  if (const auto whole = base::parse_number<std::int64_t>(text)) return *whole;
  if (const auto real = base::parse_number<double>(text); real && std::isfinite(*real)) return *real;
  return std::string(text);
}

/// The type with the bounds and the unit of the point, by which its commands are checked.
model::Type bounded(const Point& point) {
  const auto& own = *point.details->capability;
  model::Type type;
  type.name = point.details->id();
  type.unit = "1";
  if (point.type) type = *point.type;
  type.minimum = std::max(type.minimum, own.minimum.value_or(type.minimum));
  type.maximum = std::min(type.maximum, own.maximum.value_or(type.maximum));
  if (!own.unit.empty()) type.unit = own.unit;
  return type;
}

/// Checks numbers; other values have no range.
Result<Value> in_range(const model::Type& type, Value value) {
  if (!as_number(value)) return value;
  if (auto fits = TypeCatalogue::check(type, value); !fits) return fail(fits.error());
  return value;
}

/// A peer may declare words for a point of any type; they count only where there is a use for them.
bool has_own_words(const Point& point) {
  const auto data = point.type->data;
  const bool takes =
      data == model::DataType::kEnumeration || (data == model::DataType::kJson && point.type->words.empty());
  return takes && !point.details->capability->words.empty();
}

std::string words_text(const Point& point) {
  const auto& own = point.details->capability->words;
  std::string list;
  for (const auto& word : own.empty() ? model::words_in(point.type->words) : own)
    list += (list.empty() ? "" : ", ") + word.text;
  return list;
}

/// A number that has no word: only where the bounds of the point say which numbers there are.
Result<Value> number_without_word(const model::Type& type, const Point& point, std::int64_t number) {
  const auto& own = *point.details->capability;
  if (own.minimum && own.maximum) return in_range(type, Value(number));
  return fail(ErrorCode::kInvalid, fmt::format("{}: '{}' is not one of {}", type.name, number, words_text(point)));
}

Result<Value> parse_enumeration(const model::Type& type, const Point& point, std::string_view text) {
  auto value = has_own_words(point) ? model::parse_words(type, point.details->capability->words, text)
                                    : TypeCatalogue::parse(type, text);
  const auto* number = value ? std::get_if<std::int64_t>(&*value) : nullptr;
  const bool has_words = has_own_words(point) || !type.words.empty();
  if (number && has_words) return number_without_word(type, point, *number);
  const auto given = value || !has_words ? std::nullopt : base::parse_number<std::int64_t>(text);
  return given ? number_without_word(type, point, *given) : value;
}

}  // namespace

std::string_view to_string(CommandState state) {
  switch (state) {
    case CommandState::kQueued: return "queued";
    case CommandState::kSent: return "sent";
    case CommandState::kConfirmed: return "confirmed";
    case CommandState::kAssumed: return "assumed";
    case CommandState::kRefused: return "refused";
    case CommandState::kFailed: return "failed";
    case CommandState::kTimedOut: return "timed-out";
    case CommandState::kExpired: return "expired";
    case CommandState::kSuperseded: return "superseded";
  }
  return "queued";
}

std::string command_text(const Command& command) {
  return model::command_status_to_json({std::string(to_string(command.state)),
                                        {command.creator, command.commander, command.creator_request},
                                        command.text,
                                        command.since,
                                        command.until,
                                        command.reason,
                                        command.by});
}

Result<Value> parse_command(const Point& point, std::string_view text) {
  if (text.size() > kMaxCommand) {
    return fail(ErrorCode::kOutOfRange, fmt::format("{}: a command may have {} bytes, this one has {}",
                                                    point.details->id(), kMaxCommand, text.size()));
  }
  const auto type = bounded(point);
  if (!point.type) return in_range(type, untyped(text));
  if (type.data == model::DataType::kEnumeration) return parse_enumeration(type, point, text);
  if (!has_own_words(point)) return TypeCatalogue::parse(type, text);
  auto value = model::parse_words(type, point.details->capability->words, text);
  return value ? in_range(type, std::move(*value)) : value;
}

bool confirms(const Value& reported, const Value& commanded) {
  const auto is = as_number(reported);
  const auto wanted = as_number(commanded);
  if (!is || !wanted) return to_text(reported) == to_text(commanded);
  const bool whole = std::holds_alternative<std::int64_t>(commanded) && std::holds_alternative<std::int64_t>(reported);
  return whole ? reported == commanded : std::abs(*is - *wanted) <= std::abs(*wanted) * 1e-3;
}

namespace {

/// In bytes of JSON, about.
std::size_t cost(const model::CommandOutcome& outcome) {
  constexpr std::size_t kNames = 80;
  return kNames + outcome.state.size() + outcome.reason.size();
}

}  // namespace

void KeptOutcomes::shown(const Command& command, bool is_final) {
  const Place place{command.device, command.point};
  auto& of = points_[place];
  auto& current = of.current;
  const bool is_other =
      current.outcome.creator != command.creator || current.outcome.request != command.creator_request;
  const bool replaces = is_other && of.is_final;
  if (replaces) keep(of);
  current = {{command.creator, command.creator_request, std::string(to_string(command.state)),
              command.reason.substr(0, kMaxReason)},
             scheduler_.now()};
  of.is_final = is_final;
  if (is_final) next_.advance_to(current.since + kKept);
  if (replaces) tell(place, of);
}

void KeptOutcomes::drop_oldest(OfPoint& of) {
  of.bytes -= cost(of.ended.front().outcome);
  of.ended.pop_front();
  --count_;
}

void KeptOutcomes::keep(OfPoint& of) {
  const auto bytes = cost(of.current.outcome);
  while (!of.ended.empty() && (of.ended.size() >= kMaxPerPoint || of.bytes + bytes > kMaxBytes)) drop_oldest(of);
  if (count_ >= kMaxInAll) return;
  of.ended.push_back(std::move(of.current));
  of.bytes += bytes;
  ++count_;
}

void KeptOutcomes::tell(const Place& place, const OfPoint& of) const {
  std::vector<model::CommandOutcome> outcomes;
  for (const auto& one : of.ended) outcomes.push_back(one.outcome);
  changed_(place, outcomes.empty() ? std::string() : model::command_outcomes_to_json(outcomes));
}

void KeptOutcomes::prune() {
  const auto now = scheduler_.now();
  for (auto at = points_.begin(); at != points_.end();) {
    auto& [place, of] = *at;
    const auto before = of.ended.size();
    while (!of.ended.empty() && of.ended.front().since + kKept <= now) drop_oldest(of);
    if (before != of.ended.size()) tell(place, of);
    const bool is_over = of.ended.empty() && of.is_final && of.current.since + kKept <= now;
    if (!is_over && !of.ended.empty()) next_.advance_to(of.ended.front().since + kKept);
    if (!is_over && of.ended.empty() && of.is_final) next_.advance_to(of.current.since + kKept);
    at = is_over ? points_.erase(at) : std::next(at);
  }
}

void KeptOutcomes::forget(const Place& place) {
  const auto found = points_.find(place);
  if (found == points_.end()) return;
  count_ -= found->second.ended.size();
  points_.erase(found);
}

void KeptOutcomes::forget(DeviceNumber device) {
  for (auto at = points_.lower_bound({device, 0}); at != points_.end() && at->first.first == device;) {
    count_ -= at->second.ended.size();
    at = points_.erase(at);
  }
}

void CommandLog::ended(const Command& command, std::string_view how, std::string_view why) {
  const auto now = context_.clock.now().steady;
  if (begun_ == SteadyTime::min() || now - begun_ >= kWindow) {
    log_omitted();
    begun_ = now;
    logged_ = 0;
  }
  if (logged_ >= kLines) {
    ++omitted_[std::string(how)];
    if (!end_.pending()) end_ = context_.scheduler.at(begun_ + kWindow, [this] { log_omitted(); });
    return;
  }
  ++logged_;
  const std::chrono::duration<double> took = now - command.accepted;
  context_.commands.info(fmt::format("{} = {} by {}, id {}: {} after {:.2f} s{}{}", command.key,
                                     model::quoted(command.text), command.commander, number(command.creator), how,
                                     took.count(), why.empty() ? "" : ": ", why));
}

void CommandLog::log_omitted() {
  end_.cancel();
  if (omitted_.empty()) return;
  std::uint64_t all = 0;
  std::string parts;
  for (const auto& [how, count] : omitted_) {
    all += count;
    parts += fmt::format("{}{} {}", parts.empty() ? "" : ", ", count, how);
  }
  omitted_.clear();
  context_.commands.info(fmt::format("{} more commands ended within {} s: {}", all,
                                     std::chrono::duration_cast<std::chrono::seconds>(kWindow).count(), parts));
}

}  // namespace rubicon::proxy
