#include "apps/simulators/zigbee/script.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "apps/simulators/script.h"
#include "apps/simulators/zigbee/device_model.h"
#include "base/config_reader.h"
#include "base/text.h"
#include "model/json_text.h"

namespace rubicon::zigbee_simulator {

namespace {

using Words = std::vector<std::string_view>;
using Kind = Step::Kind;

constexpr auto kMinSpanTime = std::chrono::milliseconds(1);
/// More devices than this are no house of ours.
constexpr std::size_t kMaxDevices = 5000;
constexpr int kMaxBurst = 1000;

constexpr std::string_view kDeviceForm = "'device MODEL NAME [every SPAN]'";
constexpr std::string_view kGroupForm = "'group ID NAME MEMBER...'";

constexpr simulation::Form<Step> kForms[] = {
    {Kind::kSet, "at SPAN set NAME PROPERTY VALUE"},
    {Kind::kAction, "at SPAN action NAME VALUE"},
    {Kind::kReport, "at SPAN report NAME"},
    {Kind::kFault, "at SPAN fault NAME FAULT"},
    {Kind::kDelay, "at SPAN delay NAME SPAN"},
    {Kind::kUnknown, "at SPAN unknown NAME PROPERTY"},
    {Kind::kPermit, "at SPAN permit SPAN"},
    {Kind::kJoin, "at SPAN join MODEL"},
    {Kind::kFail, "at SPAN fail MODEL"},
    {Kind::kBurst, "at SPAN burst COUNT"},
    {Kind::kRename, "at SPAN rename NAME TO"},
    {Kind::kLeave, "at SPAN leave NAME"},
    {Kind::kAnnounce, "at SPAN announce NAME"},
    {Kind::kShorten, "at SPAN shorten NAME"},
    {Kind::kSay, "at SPAN say TOPIC PAYLOAD"},
    {Kind::kStop, "at SPAN stop SPAN"},
    {Kind::kRepeat, "at SPAN repeat"},
};

/// A word of a line: `%20` is a blank.
std::string plain(std::string_view word) {
  std::string text(word);
  for (auto at = text.find("%20"); at != text.npos; at = text.find("%20", at)) text.replace(at, 3, " ");
  return text;
}

bool is_model(std::string_view word) {
  const auto names = model_names();
  return word == "random" || std::ranges::find(names, word) != names.end();
}

bool is_fault(std::string_view word) {
  constexpr std::array<std::string_view, 5> kFaults{"ignore", "refuse", "silent", "echo-first", "none"};
  return std::ranges::find(kFaults, word) != kFaults.end();
}

bool take(Step& step, std::string_view wanted, std::string_view word, bool first_span) {
  if (wanted == "SPAN") {
    const auto span = base::parse_duration(word);
    if (span) (first_span ? step.at : step.span) = *span;
    return span.has_value();
  }
  if (wanted == "COUNT") {
    const auto count = base::parse_number<int>(word);
    step.count = count.value_or(0);
    return count.has_value();
  }
  if (wanted == "NAME") {
    step.name = plain(word);
  } else if (wanted == "VALUE" || wanted == "PAYLOAD") {
    step.text = plain(word);
  } else if (wanted == "PROPERTY" || wanted == "TO" || wanted == "TOPIC") {
    step.word = plain(word);
  } else if (wanted == "MODEL" || wanted == "FAULT") {
    step.word = word;
    return wanted == "MODEL" ? is_model(word) : is_fault(word);
  } else {
    return wanted == word;
  }
  return true;
}

/// A step that takes no time would block the loop.
std::string_view invalid_reason(const Step& step) {
  const bool lasts = step.kind == Kind::kStop || step.kind == Kind::kPermit;
  if (lasts && step.span < kMinSpanTime) return "expected a SPAN of at least 1ms";
  if (step.kind == Kind::kRepeat && step.at < kMinSpanTime) return "expected to repeat after at least 1ms";
  if (step.kind == Kind::kBurst && (step.count < 1 || step.count > kMaxBurst)) return "expected a COUNT from 1 to 1000";
  return {};
}

Result<void> read_device(Script& script, const Words& words) {
  const bool periodic = words.size() == 5 && words[3] == "every";
  const auto span = periodic ? base::parse_duration(words[4]) : std::optional(Duration{});
  if ((words.size() != 3 && !periodic) || !span || (periodic && *span < kMinSpanTime))
    return fail(ErrorCode::kInvalid, fmt::format("expected {}", kDeviceForm));
  if (!is_model(words[1]))
    return fail(ErrorCode::kInvalid, fmt::format("{}: expected random or one of {}", model::quoted(words[1]),
                                                 fmt::join(model_names(), ", ")));
  if (script.devices.size() == kMaxDevices)
    return fail(ErrorCode::kInvalid, fmt::format("expected at most {} devices", kMaxDevices));
  script.devices.push_back({std::string(words[1]), plain(words[2]), *span});
  return {};
}

Result<void> read_group(Script& script, const Words& words) {
  const auto id = words.size() > 2 ? base::parse_number<int>(words[1]) : std::nullopt;
  if (!id || *id < 1) return fail(ErrorCode::kInvalid, fmt::format("expected {}", kGroupForm));
  GroupLine group{*id, plain(words[2]), {}};
  for (std::size_t i = 3; i < words.size(); ++i) group.members.push_back(plain(words[i]));
  script.groups.push_back(std::move(group));
  return {};
}

/// Names that a step may use: those of the lines and of renames, and addresses.
Result<void> check_names(const Script& script) {
  std::set<std::string> known;
  for (const auto& device : script.devices) known.insert(device.name);
  for (const auto& step : script.steps) {
    if (step.kind == Kind::kRename) known.insert(step.word);
  }
  for (const auto& step : script.steps) {
    if (!step.name.empty() && !step.name.starts_with("0x") && !known.contains(step.name))
      return fail(ErrorCode::kInvalid, fmt::format("line {}: {}: expected a device that has a line {}", step.line,
                                                   model::quoted(step.name), kDeviceForm));
  }
  for (const auto& group : script.groups) {
    for (const auto& member : group.members) {
      if (!known.contains(member))
        return fail(ErrorCode::kInvalid, fmt::format("group {}: {}: expected a device that has a line {}", group.name,
                                                     model::quoted(member), kDeviceForm));
    }
  }
  return {};
}

}  // namespace

nlohmann::json value_of_word(std::string_view word) {
  auto value = model::parse_json(word);
  return value.is_discarded() ? nlohmann::json(std::string(word)) : value;
}

Result<Script> parse_script(std::string_view text) {
  Script script;
  std::string steps;  // the other lines are empty there, so that line numbers hold
  for (int line = 1; !text.empty(); ++line) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto words = simulation::words_of(text.substr(0, end));
    const bool device = !words.empty() && words[0] == "device";
    const bool group = !words.empty() && words[0] == "group";
    const auto read = device ? read_device(script, words) : group ? read_group(script, words) : Result<void>();
    if (!read) return fail(ErrorCode::kInvalid, fmt::format("line {}: {}", line, read.error().text));
    if (!device && !group) steps += text.substr(0, end);
    steps += '\n';
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  auto timed = simulation::read_script(simulation::Grammar<Step>{kForms, take, invalid_reason}, steps);
  if (!timed) return fail(timed.error());
  script.steps = std::move(*timed);
  if (const auto checked = check_names(script); !checked) return fail(checked.error());
  return script;
}

}  // namespace rubicon::zigbee_simulator
