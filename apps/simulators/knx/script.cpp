#include "apps/simulators/knx/script.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/simulators/script.h"
#include "base/config_reader.h"
#include "base/text.h"

namespace rubicon::knx_simulator {

namespace {

using namespace networks::knx::wire;
using networks::knx::dpt::Dpt;
using Words = std::vector<std::string_view>;

constexpr auto kMinTime = std::chrono::milliseconds(1);
/// More group addresses than this are no bus of ours.
constexpr std::size_t kMaxGroups = 10000;

constexpr std::string_view kGroupForm =
    "'group GROUP DPT VALUE [state GROUP] [every SPAN] [noise BY] [wave LOW HIGH over SPAN] [write-only]'";

using Form = simulation::Form<Step>;
constexpr Form kForms[] = {
    {Step::Kind::kWrite, "at SPAN write GROUP VALUE"}, {Step::Kind::kSet, "at SPAN set GROUP VALUE"},
    {Step::Kind::kRead, "at SPAN read GROUP"},         {Step::Kind::kRamp, "at SPAN ramp GROUP FROM TO over SPAN"},
    {Step::Kind::kSilence, "at SPAN silence SPAN"},    {Step::Kind::kDisconnect, "at SPAN disconnect"},
    {Step::Kind::kStop, "at SPAN stop SPAN"},          {Step::Kind::kRepeat, "at SPAN repeat"},
};

std::optional<double> finite_number(std::string_view text) {
  const auto number = base::parse_number<double>(text);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

template <class Value, class Parsed>
bool assign(Value& value, const Parsed& parsed) {
  if (parsed) value = *parsed;
  return bool(parsed);
}

bool take(Step& step, std::string_view wanted, std::string_view word, bool first_span) {
  if (wanted == "SPAN") return assign(first_span ? step.at : step.span, base::parse_duration(word));
  if (wanted == "GROUP") return assign(step.group, parse_group(word));
  if (wanted == "FROM") return assign(step.from, finite_number(word));
  if (wanted == "TO") return assign(step.to, finite_number(word));
  if (wanted != "VALUE") return wanted == word;
  step.text = word;
  return true;
}

/// Why the numbers of a step are invalid; empty = they are valid. A step that takes no time would block the loop.
std::string_view invalid_reason(const Step& step) {
  using Kind = Step::Kind;
  const bool lasts = step.kind == Kind::kRamp || step.kind == Kind::kSilence || step.kind == Kind::kStop;
  if (lasts && step.span < kMinTime) return "expected a SPAN of at least 1ms";
  if (step.kind == Kind::kRepeat && step.at < kMinTime) return "expected to repeat after at least 1ms";
  return {};
}

bool is_number(const Dpt& type, const Payload& value) {
  const auto decoded = decode(type, value);
  return decoded && (std::holds_alternative<double>(*decoded) || std::holds_alternative<std::int64_t>(*decoded));
}

/// The options behind `group GROUP DPT VALUE`; false: the words are not options.
bool read_options(Group& group, const Words& words) {
  for (std::size_t i = 4; i < words.size(); ++i) {
    const auto next = [&] { return ++i < words.size() ? words[i] : std::string_view(); };
    const auto option = words[i];
    if (option == "write-only") {
      group.readable = false;
    } else if (option == "state") {
      if (!assign(group.state, parse_group(next())) || *group.state == group.address) return false;
    } else if (option == "every") {
      if (!assign(group.every, base::parse_duration(next())) || group.every < kMinTime) return false;
    } else if (option == "noise") {
      if (!assign(group.noise, finite_number(next())) || group.noise < 0) return false;
    } else if (option == "wave") {
      if (!assign(group.low, finite_number(next())) || !assign(group.high, finite_number(next()))) return false;
      if (next() != "over" || !assign(group.period, base::parse_duration(next())) || group.period < kMinTime)
        return false;
    } else {
      return false;
    }
  }
  return true;
}

Result<Group> read_group(const Words& words) {
  const auto expected = [] { return fail(ErrorCode::kInvalid, fmt::format("expected {}", kGroupForm)); };
  if (words.size() < 4) return expected();
  Group group;
  const auto address = parse_group(words[1]);
  if (!address) return fail(address.error());
  group.address = *address;
  const auto id = networks::knx::dpt::parse_dpt(words[2]);
  group.type = id ? networks::knx::dpt::find_dpt(*id) : nullptr;
  if (group.type == nullptr)
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: expected a data point type such as 9.001", model::quoted(words[2])));
  auto value = encode_text(*group.type, words[3]);
  if (!value) return fail(value.error());
  group.value = std::move(*value);
  if (!read_options(group, words)) return expected();
  const bool moves = group.noise > 0 || group.period > Duration{};
  if (moves && (!is_number(*group.type, group.value) || group.every == Duration{}))
    return fail(ErrorCode::kInvalid, "expected `noise` and `wave` with a number type and with `every SPAN` only");
  return group;
}

Group* find(std::vector<Group>& groups, GroupAddress address) {
  const auto found = std::find_if(groups.begin(), groups.end(), [&](auto& one) { return one.address == address; });
  return found == groups.end() ? nullptr : &*found;
}

/// State addresses that have no line of their own.
void add_state_groups(std::vector<Group>& groups) {
  for (std::size_t i = 0, count = groups.size(); i < count; ++i) {
    if (!groups[i].state || find(groups, *groups[i].state)) continue;
    Group state;
    state.address = *groups[i].state;
    state.type = groups[i].type;
    state.value = groups[i].value;
    groups.push_back(std::move(state));
  }
}

Result<void> bind(Step& step, std::vector<Group>& groups) {
  if (step.group == GroupAddress{}) return {};
  const auto* group = find(groups, step.group);
  const auto where = fmt::format("line {}: {}", step.line, to_string(step.group));
  if (group == nullptr)
    return fail(ErrorCode::kInvalid, fmt::format("{}: expected a group address that has a line {}", where, kGroupForm));
  if (step.kind == Step::Kind::kRamp && !is_number(*group->type, group->value))
    return fail(ErrorCode::kInvalid, fmt::format("{}: expected a group address with a number type", where));
  if (step.text.empty()) return {};
  auto value = encode_text(*group->type, step.text);
  if (!value) return fail(ErrorCode::kInvalid, fmt::format("line {}: {}", step.line, value.error().text));
  step.value = std::move(*value);
  return {};
}

/// Takes the `group` lines out of the text; leaves their line ends, so that lines keep their numbers.
Result<std::string> take_groups(std::string_view text, std::vector<Group>& groups) {
  std::string rest;
  for (int line = 1; !text.empty(); ++line) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto words = simulation::words_of(text.substr(0, end));
    const bool declares = !words.empty() && words[0] == "group";
    if (!declares) rest += text.substr(0, end);
    rest += '\n';
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!declares) continue;
    auto group = read_group(words);
    if (!group) return fail(ErrorCode::kInvalid, fmt::format("line {}: {}", line, group.error().text));
    if (find(groups, group->address))
      return fail(ErrorCode::kInvalid, fmt::format("line {}: {} is listed twice", line, words[1]));
    if (groups.size() == kMaxGroups)
      return fail(ErrorCode::kInvalid, fmt::format("line {}: expected at most {} groups", line, kMaxGroups));
    groups.push_back(std::move(*group));
  }
  return rest;
}

}  // namespace

Result<Script> parse_script(std::string_view text) {
  Script script;
  const auto rest = take_groups(text, script.groups);
  if (!rest) return fail(rest.error());
  add_state_groups(script.groups);
  auto steps = simulation::read_script<Step>({kForms, take, invalid_reason}, *rest);
  if (!steps) return fail(steps.error());
  for (auto& step : *steps) {
    if (auto bound = bind(step, script.groups); !bound) return fail(bound.error());
  }
  script.steps = std::move(*steps);
  return script;
}

}  // namespace rubicon::knx_simulator
