#pragma once

#include <functional>
#include <vector>

#include "history/answer.h"
#include "history/counters.h"
#include "rubicon/key.hpp"
#include "rubicon/tuple_space.hpp"

namespace rubicon::web::api {

/// The past of tuples, as history::History keeps it: its calls, for the API.
class HistorySource {
 public:
  virtual ~HistorySource() = default;
  /// Calls in a later turn; destroying the handle cancels that.
  [[nodiscard]] virtual Handle ask(history::Question question, std::function<void(Result<history::Answer>)> call) = 0;
  [[nodiscard]] virtual Handle series(Pattern pattern,
                                      std::function<void(Result<std::vector<history::SeriesEntry>>)> call) = 0;
  virtual history::Counters counters() const = 0;
};

/// Of a history::History, or what has the same calls. It must outlive this.
template <class History>
class HistoryOf final : public HistorySource {
 public:
  explicit HistoryOf(History& history) : history_(history) {}

  Handle ask(history::Question question, std::function<void(Result<history::Answer>)> call) override {
    return history_.ask(std::move(question), std::move(call));
  }
  Handle series(Pattern pattern, std::function<void(Result<std::vector<history::SeriesEntry>>)> call) override {
    return history_.series(std::move(pattern), std::move(call));
  }
  history::Counters counters() const override { return history_.counters(); }

 private:
  History& history_;
};

}  // namespace rubicon::web::api
