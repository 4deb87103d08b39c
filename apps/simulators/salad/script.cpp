#include "apps/simulators/salad/script.h"

#include <cmath>

#include "apps/simulators/script.h"
#include "base/config_reader.h"

namespace rubicon::salad_simulator {

namespace {

constexpr auto kMinTime = std::chrono::milliseconds(1);
/// Whole numbers up to here are exact.
constexpr double kMaxNumber = 1e15;

using Form = simulation::Form<Step>;
constexpr Form kForms[] = {
    {Step::Kind::kSet, "at SPAN set ID TO"},
    {Step::Kind::kRamp, "at SPAN ramp ID FROM TO over SPAN"},
    {Step::Kind::kRandom, "at SPAN random ID FROM TO every SPAN"},
    {Step::Kind::kHold, "at SPAN hold ID"},
    {Step::Kind::kSilence, "at SPAN silence SPAN"},
    {Step::Kind::kGarbage, "at SPAN garbage"},
    {Step::Kind::kRepeat, "at SPAN repeat"},
};

std::optional<double> number(std::string_view text) {
  const auto value = networks::salad::read_number(text);
  if (!value) return std::nullopt;
  if (const auto* whole = std::get_if<std::int64_t>(&*value)) return static_cast<double>(*whole);
  const auto* real = std::get_if<double>(&*value);
  return real ? std::optional(*real) : std::nullopt;
}

bool take(Step& step, std::string_view wanted, std::string_view word, bool first_span) {
  if (wanted == "SPAN") {
    const auto span = base::parse_duration(word);
    if (span) (first_span ? step.at : step.span) = *span;
    return span.has_value();
  }
  if (wanted == "ID") {
    const auto id = networks::salad::read_id(word);
    if (id) step.id = *id;
    return id.has_value();
  }
  if (wanted != "FROM" && wanted != "TO") return wanted == word;
  const auto value = number(word);
  if (value) (wanted == "FROM" ? step.from : step.to) = *value;
  return value.has_value();
}

/// Why the numbers of a step are invalid; empty = they are valid. A step that takes no time would block the loop.
std::string_view invalid_reason(const Step& step) {
  using Kind = Step::Kind;
  const bool moves = step.kind == Kind::kRandom || step.kind == Kind::kRamp;
  if (moves && step.span < kMinTime) return "expected a SPAN of at least 1ms";
  if (step.kind == Kind::kRepeat && step.at < kMinTime) return "expected to repeat after at least 1ms";
  for (const double value : {step.from, step.to}) {
    if (!std::isfinite(value) || std::abs(value) > kMaxNumber) return "expected numbers from -1e15 to 1e15";
  }
  if (step.kind == Kind::kRandom && step.from > step.to) return "expected FROM <= TO";
  return {};
}

}  // namespace

Result<std::vector<Step>> parse_script(std::string_view text) {
  return simulation::read_script<Step>({kForms, take, invalid_reason}, text);
}

}  // namespace rubicon::salad_simulator
