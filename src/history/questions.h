#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <string>

#include "base/lifetime.h"
#include "base/scheduler.h"
#include "history/history_source.h"
#include "history/keeper.h"
#include "transport/worker.h"

namespace rubicon::history {

/// The questions to a history: one at a time is a job of the worker, so that a batch waits for one at most. Callers
/// take turns. A question ends after kLongest, also in its middle, and when its caller cancels it.
class Questions {
 public:
  using Work = std::function<Result<std::string>(Store&)>;
  using Clock = std::function<SteadyTime()>;

  static constexpr std::size_t kMost = 32;         ///< that wait
  static constexpr std::size_t kMostOfCaller = 8;  ///< of these, of one caller
  static constexpr Duration kLongest = std::chrono::seconds(2);

  /// The worker must outlive it. `clock` is read by jobs of the worker.
  Questions(Scheduler& scheduler, transport::Worker& worker, std::shared_ptr<Keeper> keeper, Clock clock)
      : scheduler_(scheduler), worker_(worker), keeper_(std::move(keeper)), clock_(std::move(clock)) {}

  Handle ask(const std::string& caller, Work work, HistorySource::TextCall call);

 private:
  struct Asked {
    HistorySource::TextCall call;
    std::atomic<bool> cancelled{false};
  };
  struct Waiting {
    std::shared_ptr<Asked> asked;
    Work work;
  };
  struct Line {
    std::string caller;
    std::deque<Waiting> questions;
  };

  Result<void> put(const std::string& caller, Waiting question);
  void drop_cancelled();
  void run_next();
  void run(Waiting question);

  Scheduler& scheduler_;
  transport::Worker& worker_;
  std::shared_ptr<Keeper> keeper_;
  Clock clock_;
  std::deque<Line> lines_;  ///< of callers with questions that wait; the first one is next
  bool running_ = false;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::history
