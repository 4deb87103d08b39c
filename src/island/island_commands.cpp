#include "island/island_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

#include "base/log.h"
#include "base/text.h"
#include "island/network_types.h"
#include "model/json_members.h"
#include "model/type_catalogue.h"
#include "proxy/command.h"
#include "rubicon/key.hpp"
#include "rubicon/summary.hpp"
#include "tuples/peer_policy.h"

namespace rubicon::island {

namespace {

constexpr tuples::SetOptions kJson{"application/json", {}, {}};

/// A status shows what a command began with: it may be a whole file.
std::string beginning_of(std::string text) {
  constexpr std::size_t kMaxShown = 200;
  if (text.size() <= kMaxShown) return text;
  text.resize(kMaxShown);
  text.resize(base::utf8_prefix(text));
  return text + "...";
}

}  // namespace

CommandKey::CommandKey(Place place, model::PointKey key, Callbacks calls)
    : place_(place),
      key_(std::move(key)),
      callbacks_(std::move(calls)),
      next_(place_.scheduler, [this] { run_next(); }) {
  std::ignore = place_.space.declare(key_.command());
  policy_ = place_.space.add_policy({place_.space.self(), key_.command()},
                                    [this](const tuples::RemoteSet& set) { return decide(set); });
}

CommandKey::~CommandKey() {
  for (const auto& key : {key_.command(), key_.status(), key_.description()}) std::ignore = place_.space.erase(key);
}

void CommandKey::describe(const model::PointDescription& description) {
  std::ignore = place_.space.set(key_.description(), model::point_description_to_json(description), kJson);
}

void CommandKey::show() {
  auto text = model::dump(callbacks_.status ? callbacks_.status() : nlohmann::ordered_json::object());
  if (last_) {
    text.pop_back();
    text += fmt::format("{}\"command\":{}}}", text.size() > 1 ? "," : "", model::command_status_to_json(*last_));
  }
  if (text == shown_) return;
  shown_ = std::move(text);
  std::ignore = place_.space.set(key_.status(), shown_, kJson);
}

/// A command that takes time runs alone, so the outcome of the last command is the outcome of the running one.
tuples::SetDecision CommandKey::decide(const tuples::RemoteSet& set) {
  if (callbacks_.begin && (is_under_way_ || !waiting_.empty()))
    return tuples::SetDecision::refused({ErrorCode::kBusy, "the same command is under way, wait for its outcome"});
  if (waiting_.size() >= kMaxWaitingCount)
    return tuples::SetDecision::refused({ErrorCode::kBusy, "too many commands wait to be carried out"});
  if (auto good = callbacks_.admit ? callbacks_.admit(set) : Result<void>(); !good)
    return tuples::SetDecision::refused(std::move(good.error()));
  if (auto good = callbacks_.check(set.value); !good) return tuples::SetDecision::refused(std::move(good.error()));
  waiting_.push_back(
      {{set.from, proxy::commander_name(place_.space, place_.config, set.from), set.request}, set.value});
  next_.request();
  return tuples::SetDecision::applied();
}

void CommandKey::run_next() {
  auto now = std::move(waiting_.front());
  waiting_.pop_front();
  if (!waiting_.empty()) next_.request();
  ++begun_;
  const auto done = callbacks_.begin ? begin(now.text) : callbacks_.run(now.text);
  last_ = {{}, std::move(now.commander), beginning_of(std::move(now.text)), {}, {}, {}, {}};
  if (!done || !callbacks_.begin) return end(done);
  is_under_way_ = true;
  patience_ = place_.scheduler.after(callbacks_.longest, [this] {
    is_under_way_ = false;
    set_state("timed-out", "there is no outcome yet");
  });
  set_state("sent", {}, callbacks_.longest);
}

Result<void> CommandKey::begin(const std::string& text) {
  return callbacks_.begin(text, lifetime_.guard([this, number = begun_](const Result<void>& outcome) {
    if (is_under_way_ && number == begun_) end(outcome);
  }));
}

void CommandKey::end(const Result<void>& outcome) {
  is_under_way_ = false;
  patience_.cancel();
  if (outcome) return set_state("confirmed", {});
  set_state(outcome.error().code == ErrorCode::kIo ? "failed" : "refused", outcome.error().text);
}

void CommandKey::set_state(std::string_view state, std::string reason, Duration longest) {
  last_->state = state;
  last_->reason = std::move(reason);
  last_->since = place_.scheduler.wall_now();
  last_->until =
      longest > Duration::zero() ? last_->since + std::chrono::ceil<std::chrono::microseconds>(longest) : WallTime{};
  show();
}

namespace {

constexpr std::string_view kReopen = "reopen";
/// Longer than any network takes to open its line.
constexpr Duration kMaxReopening = std::chrono::seconds(30);

model::PointDescription line_description() {
  model::PointDescription about;
  about.type = "line";
  about.data_type = "enumeration";
  about.words = {{0, std::string(kReopen)}};
  about.access = to_string(model::Access::kWrite);
  about.report = "state";
  return about;
}

}  // namespace

void NetworkControls::refresh() {
  std::set<std::string> there;
  const model::IslandKey island{place_.config.prefix};
  for (const auto& id : networks_.ids()) {
    there.insert(island.network(id).line().text);
    add_line(id);
    for (const auto& control : networks_.find(id)->controls()) {
      there.insert(island.network(id).control(control.name).text);
      add(id, control);
    }
  }
  std::erase_if(all_, [&](const auto& entry) { return !there.contains(entry.first); });
}

void NetworkControls::add_line(const std::string& network) {
  CommandKey::Callbacks calls;
  calls.check = [](const std::string& text) -> Result<void> {
    if (text == kReopen) return {};
    return fail(ErrorCode::kInvalid, fmt::format("{}, expected {}", model::quoted(text), kReopen));
  };
  calls.begin = [this, network](const std::string&, CommandKey::Ended ended) {
    return networks_.reopen(network, std::move(ended));
  };
  calls.longest = kMaxReopening;
  add(model::IslandKey{place_.config.prefix}.network(network).line(), line_description(), std::move(calls));
}

void NetworkControls::add(const std::string& network, const network::Control& control) {
  CommandKey::Callbacks calls;
  calls.check = [](const std::string&) { return Result<void>(); };
  calls.run = [this, network, name = control.name](const std::string& text) {
    return networks_.control(network, name, text);
  };
  add(model::IslandKey{place_.config.prefix}.network(network).control(control.name), control.description,
      std::move(calls));
}

void NetworkControls::add(const model::PointKey& key, const model::PointDescription& description,
                          CommandKey::Callbacks calls) {
  auto& command = all_[key.text];
  if (command) return;
  command = std::make_unique<CommandKey>(place_, key, std::move(calls));
  command->describe(description);
  command->show();
}

namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    if (end > 0) lines.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

/// `home.yaml:3:7: what` in its parts. A line without a place is all text.
Json error_of(std::string_view line) {
  for (auto colon = line.find(':'); colon != line.npos; colon = line.find(':', colon + 1)) {
    const auto second = line.find(':', colon + 1);
    const auto third = second == line.npos ? line.npos : line.find(": ", second + 1);
    if (third == line.npos) break;
    const auto row = base::parse_number<unsigned>(line.substr(colon + 1, second - colon - 1));
    const auto column = base::parse_number<unsigned>(line.substr(second + 1, third - second - 1));
    if (!row || !column) continue;
    return {{"file", line.substr(0, colon)},
            {"line", *row},
            {"column", *column},
            {"text", base::masked(line.substr(third + 2))}};
  }
  return {{"line", 0}, {"column", 0}, {"text", base::masked(line)}};
}

std::string more_lines(std::size_t count) {
  return fmt::format("... and {} more", count);
}

/// What `item` makes of each line; the last one counts those that are too many.
template <class Lines, class Item>
Json listed(const Lines& lines, Item item) {
  auto all = Json::array();
  for (const auto& line : lines) {
    const bool full = all.size() == SettingsTuples::kMaxLineCount;
    all.push_back(full ? item(more_lines(lines.size() - all.size())) : item(line));
    if (full) break;
  }
  return all;
}

}  // namespace

SettingsTuples::SettingsTuples(CommandKey::Place place)
    : place_(place),
      command_(place, model::IslandKey{place.config.prefix}.settings(),
               {[this](const std::string& text) { return check(text); },
                [this](const std::string& text) { return run(text); },
                [this] { return status(); },
                {},
                {},
                [this](const tuples::RemoteSet& set) { return admit(set); }}) {}

void SettingsTuples::start() {
  model::PointDescription about;
  about.type = "settings";
  about.data_type = "enumeration";
  about.words = {{0, "try"}, {1, "reload"}, {2, "undo"}};
  about.access = to_string(model::Access::kWrite);
  about.report = "event";
  command_.describe(about);
  command_.show();
  show_networks();
}

/// The samples of all types, of which a page makes its forms.
void SettingsTuples::show_networks() {
  auto types = Json::array();
  for (const auto& type : network_types())
    types.push_back({{"type", type.name}, {"summary", type.summary}, {"sample", type.sample_config}});
  std::ignore = place_.space.set(command_.key().text + ".networks", model::dump(types), kJson);
}

void SettingsTuples::show_text(const std::string& text) {
  const auto key = command_.key().value();
  const auto before = place_.space.get(place_.space.self(), key);
  if (before && before->value == text) return;
  std::ignore = place_.space.set(key, text, {"application/yaml", {}, {}});
}

/// Where nothing is known of who asks, the file is for programs of this host, as `tuples.trust_lan` has it for all
/// sets.
Result<void> SettingsTuples::admit(const tuples::RemoteSet& set) const {
  if (!is_config_change(set.value) || tuples::SpaceRights::judge(place_.space)) return {};
  const auto text = place_.space.summary(set.from);
  const auto summary = text.empty() ? model::Summary{} : model::summary_from_json(text).value_or(model::Summary{});
  if (summary.host.empty() || summary.host == place_.config.host) return {};
  return fail(ErrorCode::kRefused,
              fmt::format("without rights the file of the configuration is changed from its own host only, not from {}",
                          model::quoted(summary.host)));
}

Result<void> SettingsTuples::check(const std::string& text) const {
  if (is_config_change(text)) {
    if (const auto change = read_config_change(text); !change) return fail(change.error());
    return desk_ ? Result<void>() : fail(ErrorCode::kUnsupported, "this program cannot change its configuration");
  }
  if (text != "try" && text != "reload")
    return fail(ErrorCode::kInvalid, fmt::format("{}, expected try, reload, undo or a change", model::quoted(text)));
  if (!reload_) return fail(ErrorCode::kUnsupported, "this program cannot read its configuration again");
  return {};
}

Result<void> SettingsTuples::run(const std::string& text) {
  if (is_config_change(text)) {
    const auto change = read_config_change(text);
    return change ? end(std::string(change->word()), change->try_only, desk_->carry_out(*change))
                  : fail(change.error());
  }
  return end(text, false, reload_(text == "try"));
}

Result<void> SettingsTuples::end(std::string what, bool tried, const Outcome& outcome) {
  what_ = std::move(what);
  tried_ = tried;
  refused_ = !outcome.has_value();
  at_ = place_.scheduler.wall_now();
  changes_ = errors_ = Json::array();
  if (outcome) {
    changes_ = listed(*outcome, [](std::string_view line) { return Json(base::masked(line)); });
  } else {
    errors_ = listed(lines_of(outcome.error().text), error_of);
  }
  command_.show();
  if (outcome) return {};
  const auto lines = lines_of(outcome.error().text);
  const auto first = lines.empty() ? std::string() : base::masked(lines.front());
  return fail(ErrorCode::kRefused,
              lines.size() < 2 ? first : fmt::format("{} {}", first, more_lines(lines.size() - 1)));
}

void SettingsTuples::show_outcome(bool try_only, const Outcome& outcome) {
  std::ignore = end(try_only ? "try" : "reload", false, outcome);
}

nlohmann::ordered_json SettingsTuples::status() const {
  const auto* state = what_.empty() ? "idle" : refused_ ? "refused" : "ok";
  Json status{
      {"state", state}, {"what", what_}, {"at", model::seconds_json(at_)}, {"changes", changes_}, {"errors", errors_}};
  if (tried_) status["tried"] = true;
  if (desk_) {
    const auto file = desk_->facts();
    status["file"] = {{"name", file.name}, {"fixed", file.fixed}, {"previous", file.previous}, {"patch", file.patch}};
  }
  return status;
}

}  // namespace rubicon::island
