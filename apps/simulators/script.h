#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/scheduler.h"
#include "rubicon/key.hpp"
#include "rubicon/result.hpp"

/// What the scripts of the simulators have in common: lines `at SPAN ...` with times from the start; `#` begins a
/// comment; `at SPAN repeat` starts the script again. A Step has the members `at`, `kind` (with kRepeat) and `line`.
namespace rubicon::simulation {

/// The form of a kind of line: words in capitals are placeholders, the others stand as they are.
template <class Step>
struct Form {
  typename Step::Kind kind;
  std::string_view text;
};

template <class Step>
struct Grammar {
  std::span<const Form<Step>> forms;
  /// Reads a word of a line as a placeholder of its form, for example SPAN, into the step; false: it does not match.
  /// `first_span`: the SPAN of `at`.
  bool (*take)(Step& step, std::string_view wanted, std::string_view word, bool first_span);
  /// Why the values of a step are invalid; empty = they are valid.
  std::string_view (*invalid_reason)(const Step& step);
};

/// The words of a line, without its comment.
std::vector<std::string_view> words_of(std::string_view line);

template <class Step>
std::optional<Step> step_of(const Grammar<Step>& grammar, const Form<Step>& form,
                            const std::vector<std::string_view>& words) {
  const auto wanted = words_of(form.text);
  if (wanted.size() != words.size()) return std::nullopt;
  Step step;
  step.kind = form.kind;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (!grammar.take(step, wanted[i], words[i], i == 1)) return std::nullopt;
  }
  return step;
}

/// The forms that a wrong line may have been meant as: those with its keyword, otherwise all.
template <class Step>
std::string expected_for(const Grammar<Step>& grammar, const std::vector<std::string_view>& words) {
  std::string like_it, all;
  for (const auto& form : grammar.forms) {
    const auto text = fmt::format("'{}'", form.text);
    all += (all.empty() ? "" : ", ") + text;
    if (words.size() > 2 && words_of(form.text)[2] == words[2]) like_it += (like_it.empty() ? "" : ", ") + text;
  }
  return like_it.empty() ? all : like_it;
}

template <class Step>
Result<Step> read_line(const Grammar<Step>& grammar, const std::vector<std::string_view>& words, int line) {
  std::optional<Step> step;
  for (const auto& form : grammar.forms) {
    if (!step) step = step_of(grammar, form, words);
  }
  if (!step)
    return fail(ErrorCode::kInvalid, fmt::format("line {}: {} ..., expected one of: {}", line, model::quoted(words[0]),
                                                 expected_for(grammar, words)));
  if (const auto why = grammar.invalid_reason(*step); !why.empty())
    return fail(ErrorCode::kInvalid, fmt::format("line {}: {}", line, why));
  step->line = line;
  return std::move(*step);
}

/// The steps in the order of their times; kInvalid names the line and what was expected there.
template <class Step>
Result<std::vector<Step>> read_script(const Grammar<Step>& grammar, std::string_view text) {
  std::vector<Step> steps;
  for (int line = 1; !text.empty(); ++line) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto words = words_of(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (words.empty()) continue;
    auto step = read_line(grammar, words, line);
    if (!step) return fail(step.error());
    steps.push_back(std::move(*step));
  }
  std::stable_sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) { return a.at < b.at; });
  const auto repeat =
      std::find_if(steps.begin(), steps.end(), [](auto& one) { return one.kind == Step::Kind::kRepeat; });
  if (repeat != steps.end() && repeat + 1 != steps.end())
    return fail(ErrorCode::kInvalid,
                fmt::format("line {}: is never reached, expected a time before 'repeat'", (repeat + 1)->line));
  return steps;
}

/// Runs the steps at their times, for ever if the script repeats, until it is destroyed.
template <class Step>
class ScriptRun {
 public:
  ScriptRun(Scheduler& scheduler, std::vector<Step> steps, std::function<void(const Step&)> take)
      : scheduler_(scheduler), steps_(std::move(steps)), take_(std::move(take)) {}

  void begin() {
    began_ = scheduler_.now();
    next_ = 0;
    resume();
  }

 private:
  void resume() {
    while (next_ < steps_.size()) {
      const Step& step = steps_[next_];
      const auto due = began_ + step.at;
      if (due > scheduler_.now()) {
        timer_ = scheduler_.at(due, [this] { resume(); });
        return;
      }
      ++next_;
      if (step.kind == Step::Kind::kRepeat) return begin();
      take_(step);
    }
  }

  Scheduler& scheduler_;
  std::vector<Step> steps_;
  std::function<void(const Step&)> take_;
  SteadyTime began_{};
  std::size_t next_ = 0;
  Timer timer_;
};

}  // namespace rubicon::simulation
