#include "apps/simulators/motes/script.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "apps/simulators/motes/sensors.h"
#include "apps/simulators/script.h"
#include "base/config_reader.h"
#include "base/text.h"

namespace rubicon::motes_simulator {

namespace {

constexpr auto kMinSpan = std::chrono::milliseconds(1);
constexpr std::size_t kMaxSinks = 16;

using Form = simulation::Form<Step>;
constexpr Form kForms[] = {
    {Step::Kind::kReboot, "at SPAN reboot MOTE"},
    {Step::Kind::kReboot, "at SPAN reboot MOTE over SPAN"},
    {Step::Kind::kKill, "at SPAN kill MOTE"},
    {Step::Kind::kMove, "at SPAN move MOTE to SINKS"},
    {Step::Kind::kStall, "at SPAN stall MOTE"},
    {Step::Kind::kSet, "at SPAN set MOTE SENSOR TO"},
    {Step::Kind::kRamp, "at SPAN ramp MOTE SENSOR FROM TO over SPAN"},
    {Step::Kind::kSine, "at SPAN sine MOTE SENSOR FROM TO every SPAN"},
    {Step::Kind::kWalk, "at SPAN walk MOTE SENSOR FROM TO every SPAN"},
    {Step::Kind::kCount, "at SPAN count MOTE SENSOR"},
    {Step::Kind::kLoss, "at SPAN loss PERCENT"},
    {Step::Kind::kLossOf, "at SPAN loss PERCENT of MOTE"},
    {Step::Kind::kDuplicates, "at SPAN duplicates PERCENT"},
    {Step::Kind::kDelay, "at SPAN delay SPAN"},
    {Step::Kind::kSinkReboot, "at SPAN sink-reboot SINK"},
    {Step::Kind::kUnplug, "at SPAN unplug SINK for SPAN"},
    {Step::Kind::kRepeat, "at SPAN repeat"},
};

template <typename Number>
bool read_number(std::string_view text, Number lowest, Number highest, Number& into) {
  const auto number = base::parse_number<Number>(text);
  into = number.value_or(Number{});
  return number && into >= lowest && into <= highest;
}

bool read_id(std::string_view text, std::uint16_t& into) {
  return read_number<std::uint16_t>(text, 1, 65532, into);
}

bool read_motes(std::string_view text, MotePattern& into) {
  if (text == "all") return true;
  const auto at = text.find('@');
  if (at != text.npos && !read_id(text.substr(at + 1), into.sink)) return false;
  return read_id(text.substr(0, at), into.address);
}

bool read_sinks(std::string_view text, std::vector<std::uint16_t>& into) {
  if (text == "none") return true;
  while (into.size() < kMaxSinks) {
    const auto comma = text.find(',');
    std::uint16_t sink = 0;
    if (!read_id(text.substr(0, comma), sink)) return false;
    if (std::find(into.begin(), into.end(), sink) == into.end()) into.push_back(sink);
    if (comma == text.npos) return true;
    text.remove_prefix(comma + 1);
  }
  return false;
}

bool take_sensor(Step& step, std::string_view word) {
  const auto sensor = parse_sensor(word);
  step.sensor = sensor.value_or(0);
  return sensor.has_value();
}

bool take_span(Duration& into, std::string_view word) {
  const auto span = base::parse_duration(word);
  into = span.value_or(Duration{});
  return span.has_value();
}

bool take(Step& step, std::string_view wanted, std::string_view word, bool first_span) {
  if (wanted == "SPAN") return take_span(first_span ? step.at : step.span, word);
  if (wanted == "MOTE") return read_motes(word, step.motes);
  if (wanted == "SENSOR") return take_sensor(step, word);
  if (wanted == "SINKS") return read_sinks(word, step.sinks);
  if (wanted == "SINK") {
    step.sinks.resize(1);
    return read_id(word, step.sinks.front());
  }
  if (wanted == "FROM") return read_number(word, 0.0, 65535.0, step.from);
  if (wanted == "TO") return read_number(word, 0.0, 65535.0, step.to);
  if (wanted != "PERCENT") return wanted == word;
  const bool read = read_number(word, 0.0, 100.0, step.to);
  step.to /= 100;
  return read;
}

/// Why a step is invalid; empty if it is valid. Steps that take no time would stop the world.
std::string_view invalid_reason(const Step& step) {
  using Kind = Step::Kind;
  if (step.kind == Kind::kRepeat && step.at < kMinSpan) return "expected to repeat after at least 1ms";
  const bool moves = step.kind == Kind::kRamp || step.kind == Kind::kSine || step.kind == Kind::kWalk;
  if (moves && step.span < kMinSpan) return "expected a SPAN of at least 1ms";
  return {};
}

}  // namespace

bool operator==(const Step& a, const Step& b) {
  const auto all = [](const Step& one) {
    return std::tie(one.at, one.kind, one.motes, one.sinks, one.sensor, one.from, one.to, one.span);
  };
  return all(a) == all(b);
}

Result<std::vector<Step>> parse_script(std::string_view text) {
  return simulation::read_script<Step>({kForms, take, invalid_reason}, text);
}

}  // namespace rubicon::motes_simulator
