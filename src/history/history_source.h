#pragma once

#include <functional>
#include <string>
#include <vector>

#include "history/answer.h"
#include "history/counters.h"
#include "rubicon/key.hpp"
#include "rubicon/tuple_space.hpp"

namespace rubicon::history {

/// The past of tuples, for programs that ask: in their own words, so that long answers are not written on the loop.
class HistorySource {
 public:
  /// Puts an answer into words. It runs on another thread than its maker's: it uses nothing of the loop.
  using AnswerText = std::function<std::string(const Answer&)>;
  using SeriesText = std::function<std::string(const std::vector<SeriesEntry>&)>;
  /// Called in a later turn; destroying the handle cancels it.
  using TextCall = std::function<void(Result<std::string>)>;

  virtual ~HistorySource() = default;

  /// The past of some series. Callers have their turns one after the other, whoever of them has more questions.
  /// kInvalid: a question beyond its limits; kExpired: its answer would take too long; kBusy: too many questions wait;
  /// kIo or kInvalid: the file cannot be read.
  [[nodiscard]] virtual Handle ask(const std::string& caller, Question question, AnswerText text, TextCall call) = 0;
  /// The series whose tuples match.
  [[nodiscard]] virtual Handle series(const std::string& caller, Pattern pattern, SeriesRange range, SeriesText text,
                                      TextCall call) = 0;
  virtual Counters counters() const = 0;
};

}  // namespace rubicon::history
