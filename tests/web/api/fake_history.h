#pragma once

#include <map>
#include <utility>
#include <vector>

#include "base/scheduler.h"
#include "history/history_source.h"

namespace rubicon::web::api {

/// A past that a test made up. It answers in a later turn, as history::History does.
class FakeHistory final : public history::HistorySource {
 public:
  explicit FakeHistory(Scheduler& scheduler) : scheduler_(scheduler) {}

  Handle ask(const std::string& caller, history::Question question, AnswerText text, TextCall call) override {
    callers.push_back(caller);
    questions.push_back(question);
    auto result = answer;
    if (result) {
      result->from = question.from;
      result->to = question.to;
    }
    return later([text = std::move(text), call = std::move(call), result] {
      call(result ? Result<std::string>(text(*result)) : fail(result.error()));
    });
  }
  Handle series(const std::string& caller, Pattern pattern, history::SeriesRange range, SeriesText text,
                TextCall call) override {
    callers.push_back(caller);
    patterns.push_back(std::move(pattern));
    ranges.push_back(std::move(range));
    return later([text = std::move(text), call = std::move(call), result = known] { call(text(result)); });
  }

  history::HistoryCounters counters() const override { return counted; }

  history::HistoryCounters counted;
  Result<history::Answer> answer;
  std::vector<history::SeriesEntry> known;
  std::vector<history::Question> questions;
  std::vector<Pattern> patterns;
  std::vector<history::SeriesRange> ranges;
  std::vector<std::string> callers;

 private:
  Handle later(std::function<void()> call) {
    const auto wanted = std::make_shared<bool>(true);
    scheduler_.post([wanted, call = std::move(call)] {
      if (*wanted) call();
    });
    return Handle([wanted] { *wanted = false; });
  }

  Scheduler& scheduler_;
};

}  // namespace rubicon::web::api
