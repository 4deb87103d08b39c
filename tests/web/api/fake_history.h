#pragma once

#include <map>
#include <utility>
#include <vector>

#include "base/scheduler.h"
#include "web/api/history_source.h"

namespace rubicon::web::api {

/// A past that a test made up. It answers in a later turn, as history::History does.
class FakeHistory final : public HistorySource {
 public:
  explicit FakeHistory(Scheduler& scheduler) : scheduler_(scheduler) {}

  Handle ask(history::Question question, std::function<void(Result<history::Answer>)> call) override {
    questions.push_back(question);
    auto result = answer;
    if (result) {
      result->from = question.from;
      result->to = question.to;
    }
    return later([call = std::move(call), result] { call(result); });
  }
  Handle series(Pattern pattern, std::function<void(Result<std::vector<history::SeriesEntry>>)> call) override {
    patterns.push_back(std::move(pattern));
    return later([call = std::move(call), result = known] { call(result); });
  }

  history::Counters counters() const override { return counted; }

  history::Counters counted;
  Result<history::Answer> answer;
  std::vector<history::SeriesEntry> known;
  std::vector<history::Question> questions;
  std::vector<Pattern> patterns;

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
