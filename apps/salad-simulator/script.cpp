#include "apps/salad-simulator/script.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/config_reader.h"
#include "model/key.h"

namespace rubicon::salad_simulator {

namespace {

constexpr auto kShortest = std::chrono::milliseconds(1);
/// Whole numbers up to here are exact.
constexpr double kLargest = 1e15;

using Words = std::vector<std::string_view>;

Words words_of(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  Words words;
  line = line.substr(0, line.find('#'));
  for (auto at = line.find_first_not_of(kBlanks); at != line.npos; at = line.find_first_not_of(kBlanks)) {
    line.remove_prefix(at);
    const auto end = std::min(line.find_first_of(kBlanks), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
  return words;
}

/// How each kind of line looks: a word in capitals stands for something, the others for themselves.
struct Form {
  Step::Kind kind;
  std::string_view text;
};
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

std::optional<Step> step_of(const Form& form, const Words& words) {
  const auto wanted = words_of(form.text);
  if (wanted.size() != words.size()) return std::nullopt;
  Step step;
  step.kind = form.kind;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (!take(step, wanted[i], words[i], i == 1)) return std::nullopt;
  }
  return step;
}

/// What is wrong with its numbers; empty = nothing. What takes no time would never let the loop go.
std::string_view senseless(const Step& step) {
  using Kind = Step::Kind;
  const bool moves = step.kind == Kind::kRandom || step.kind == Kind::kRamp;
  if (moves && step.span < kShortest) return "expected a SPAN of at least 1ms";
  if (step.kind == Kind::kRepeat && step.at < kShortest) return "expected to repeat after at least 1ms";
  for (const double value : {step.from, step.to}) {
    if (!std::isfinite(value) || std::abs(value) > kLargest) return "expected numbers from -1e15 to 1e15";
  }
  if (step.kind == Kind::kRandom && step.from > step.to) return "expected FROM <= TO";
  return {};
}

}  // namespace

Result<std::vector<Step>> parse_script(std::string_view text) {
  std::vector<Step> steps;
  for (int line = 1; !text.empty(); ++line) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto words = words_of(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (words.empty()) continue;
    std::optional<Step> step;
    std::string expected;
    for (const auto& form : kForms) {
      if (!step) step = step_of(form, words);
      expected += fmt::format("{}'{}'", expected.empty() ? "" : ", ", form.text);
    }
    if (const auto why = step ? senseless(*step) : std::string_view(); !why.empty())
      return fail(ErrorCode::kInvalid, fmt::format("line {}: {}", line, why));
    if (!step)
      return fail(ErrorCode::kInvalid,
                  fmt::format("line {}: {} ..., expected one of: {}", line, model::quoted(words[0]), expected));
    steps.push_back(*step);
  }
  std::stable_sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) { return a.at < b.at; });
  return steps;
}

}  // namespace rubicon::salad_simulator
