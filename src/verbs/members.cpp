#include "verbs/members.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "base/bytes.h"
#include "base/compare_text.h"
#include "base/config_reader.h"
#include "base/text.h"
#include "model/json_members.h"

namespace rubicon::verbs {

namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxDepth = 8;
constexpr std::string_view kTuple = "OWNER:KEY, such as 6541:proxy.island";
constexpr std::string_view kPattern = "OWNER:KEY or *:KEY, such as 6541:proxy.*.*.status or *:proxy.**";

/// The text itself; of what is no text, its JSON.
std::string text_of_member(const Json& member) {
  return member.is_string() ? member.get<std::string>() : model::dump(member);
}

}  // namespace

Result<Json> parse_object(std::string_view text) {
  if (base::is_nested_deeper(text, kMaxDepth))
    return fail(ErrorCode::kInvalid, fmt::format("JSON: nested deeper than {} levels", kMaxDepth));
  auto tree = model::parse_json(text);
  if (tree.is_object()) return tree;
  return fail(ErrorCode::kInvalid, fmt::format("expected a JSON object, got {}", model::quoted(text)));
}

Members::Members(const std::vector<std::pair<std::string, std::string>>& texts) : tree_(Json::object()) {
  for (const auto& [name, text] : texts) {
    auto& member = tree_[name];
    if (member.is_string()) member = Json::array({member});
    if (member.is_array()) {
      member.push_back(text);
    } else {
      member = text;
    }
  }
}

void Members::add(std::string_view name, Json value) {
  if (!tree_.emplace(name, std::move(value)).second) fault(fmt::format("{} is given twice", model::quoted(name)));
}

void Members::fault(std::string text, ErrorCode code) {
  if (!fault_) fault_ = Error{code, std::move(text)};
}

void Members::wrong(const char* name, std::string_view got, std::string_view expected) {
  fault(fmt::format("{} is {}; expected {}", name, model::quoted(got), expected));
}

void Members::missing(const char* name, std::string_view expected) {
  fault(fmt::format("{} is missing; expected {}", name, expected));
}

const Json* Members::find(const char* name) {
  known_.emplace_back(name);
  const auto found = tree_.find(name);
  return found == tree_.end() ? nullptr : &*found;
}

std::string Members::peek(const char* name) const {
  const auto found = tree_.find(name);
  return found == tree_.end() || !found->is_string() ? std::string() : found->get<std::string>();
}

void Members::resolve(const char* name, std::string key) {
  tree_[name] = std::move(key);
  is_resolved_ = true;
}

std::optional<std::string> Members::shown(const char* name) {
  const auto* got = find(name);
  if (got == nullptr) return std::nullopt;
  return text_of_member(*got);
}

std::string Members::text(const char* name, std::string_view expected) {
  const auto* got = find(name);
  if (got == nullptr) return missing(name, expected), std::string();
  if (!got->is_string()) return wrong(name, text_of_member(*got), expected), std::string();
  return got->get<std::string>();
}

std::string Members::text_or(const char* name, std::string otherwise) {
  return has(name) ? text(name, "a text") : otherwise;
}

std::vector<std::string> Members::texts(const char* name, std::string_view expected, std::size_t most) {
  const auto* got = find(name);
  if (got == nullptr) return {};
  std::vector<std::string> list;
  const auto add_text = [&list](const Json& one) {
    if (one.is_string() && !one.get_ref<const std::string&>().empty()) list.push_back(one.get<std::string>());
  };
  if (!got->is_array()) add_text(*got);
  if (got->is_array() && got->size() <= most) std::for_each(got->begin(), got->end(), add_text);
  if (!list.empty() && list.size() == (got->is_array() ? got->size() : 1)) return list;
  wrong(name, text_of_member(*got), fmt::format("{}, or a list of 1 to {} of them", expected, most));
  return {};
}

double Members::number_or(const char* name, double otherwise, double least, double most) {
  const auto got = shown(name);
  if (!got) return otherwise;
  const auto number = base::parse_number<double>(*got);
  if (number && *number >= least && *number <= most) return *number;
  wrong(name, *got, fmt::format("a number from {} to {}", least, most));
  return otherwise;
}

std::optional<std::uint64_t> Members::count(const char* name, std::uint64_t least, std::uint64_t most) {
  const auto got = shown(name);
  if (!got) return std::nullopt;
  const auto number = base::parse_number<std::uint64_t>(*got);
  if (number && *number >= least && *number <= most) return number;
  wrong(name, *got, fmt::format("a whole number from {} to {}", least, most));
  return std::nullopt;
}

Duration Members::span_or(const char* name, Duration otherwise, Duration unit, Duration longest) {
  const auto got = shown(name);
  if (!got) return otherwise;
  const auto most = std::chrono::duration<double>(longest) / std::chrono::duration<double>(unit);
  const auto number = base::parse_number<double>(*got);
  if (number && *number >= 0 && *number <= most) return std::chrono::duration_cast<Duration>(*number * unit);
  const auto span = base::parse_duration(*got);
  if (span && *span <= longest) return *span;
  wrong(name, *got,
        fmt::format("{} from 0 to {}, or a time such as 250ms, 5s or 2min",
                    unit == std::chrono::seconds(1) ? "seconds" : "milliseconds", most));
  return otherwise;
}

WallTime Members::time_or(const char* name, WallTime otherwise, WallTime now) {
  const auto got = shown(name);
  if (!got) return otherwise;
  if (const auto seconds = base::parse_number<double>(*got)) {
    const auto time = model::time_from_seconds(*seconds);
    if (time != WallTime{} || *seconds == 0) return time;
  } else {
    const bool is_ago = got->starts_with('-');
    const auto span = base::parse_duration(std::string_view(*got).substr(is_ago ? 1 : 0));
    if (span) return now + std::chrono::duration_cast<std::chrono::microseconds>(is_ago ? -*span : *span);
  }
  wrong(name, *got, "seconds since 1970, or a time from now such as -1h or 5min");
  return otherwise;
}

bool Members::flag(const char* name) {
  const auto got = shown(name);
  if (!got || *got == "false" || *got == "0") return false;
  if (!got->empty() && *got != "true" && *got != "1") wrong(name, *got, "true or false");
  return true;
}

Pattern Members::pattern(const char* name) {
  const auto given = text(name, kPattern);
  if (fault_) return {};
  auto pattern = Pattern::parse(given);
  if (pattern) return std::move(*pattern);
  fault(fmt::format("{}: {}", name, pattern.error().text));
  return {};
}

Pattern Members::tuple(const char* name) {
  const auto given = text(name, kTuple);
  if (fault_) return {};
  auto tuple = Pattern::parse(given);
  if (tuple && tuple->owner && tuple->exact()) return std::move(*tuple);
  fault(tuple ? fmt::format("{} is {}; expected {}", name, model::quoted(given), kTuple)
              : fmt::format("{}: {}; expected {}", name, tuple.error().text, kTuple));
  return {};
}

std::string Members::value() {
  if (!has("b64")) return text("value", "a text, or bytes as b64");
  if (has("value")) fault("value and b64 exclude each other");
  auto bytes = base::from_base64(text("b64", "bytes in base 64"));
  if (bytes) return std::move(*bytes);
  fault("b64: " + bytes.error().text);
  return {};
}

Result<void> Members::end() const {
  if (fault_) return fail(*fault_);
  for (const auto& [name, unused] : tree_.items()) {
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
    const auto near = base::did_you_mean(name, known_);
    return fail(ErrorCode::kInvalid,
                fmt::format("unknown member {}{}{}", model::quoted(name), near.empty() ? "" : "; ", near));
  }
  return {};
}

}  // namespace rubicon::verbs
