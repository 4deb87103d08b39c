#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "config/storage_config.h"
#include "history/history_source.h"
#include "history/keeper.h"
#include "rubicon/key.hpp"
#include "rubicon/tuple_space.hpp"
#include "transport/transports.h"

namespace rubicon::history {

/// The questions to a history: one at a time is a job of the worker, so that a batch waits for one at most. Callers
/// take turns. A question ends after kMaxTime, also in its middle, and when its caller cancels it.
class Questions {
 public:
  using Work = std::function<Result<std::string>(Store&)>;
  using Clock = std::function<SteadyTime()>;

  static constexpr std::size_t kMaxCount = 32;    ///< that wait
  static constexpr std::size_t kMaxOfCaller = 8;  ///< of these, of one caller
  static constexpr Duration kMaxTime = std::chrono::seconds(2);

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

/// Keeps the values of tuples in one file, and answers what they were (docs/history.md). It observes passively. The
/// loop never waits for the file: a worker reads and writes it, in batches. All calls of callers run on the loop, in
/// a later turn.
class History final : public HistorySource {
 public:
  struct Context {
    Scheduler& scheduler;
    std::unique_ptr<transport::Worker> worker;  ///< of this history alone
    base::LogSink& log;
    std::string directory{};   ///< relative paths start here
    Questions::Clock clock{};  ///< of the worker, for the time of questions; empty = that of the scheduler
  };
  /// Opens the file, in the worker. What fails is in state() and in the log, and is tried again. Points that cannot be
  /// written wait, up to a bound.
  History(config::HistorySetup setup, Context context);
  /// Writes what is not written yet; waits for the worker to do it, but neither for a question nor for the check of
  /// the file.
  ~History() override;

  /// Stores what the space shows of the configured tuples, as soon as the file is open. The space must outlive this.
  void follow(TupleSpace& space);

  Handle ask(const std::string& caller, Question question, AnswerText text, TextCall call) override;
  Handle series(const std::string& caller, Pattern pattern, SeriesRange range, SeriesText text, TextCall call) override;
  HistoryCounters counters() const override;

  struct State {
    std::string word;      ///< `opening`, `recording`, or `failing`: not all can be written
    std::string reason{};  ///< of `failing`

    friend bool operator==(const State&, const State&) = default;
  };
  State state() const;
  const std::string& path() const;
  const config::HistorySetup& setup() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Shows as one tuple what a history does (docs/history.md): a new state within a second, numbers every ten seconds.
/// At its end the tuple is deleted.
class StatusTuple {
 public:
  /// All must outlive it.
  StatusTuple(Scheduler& scheduler, TupleSpace& space, std::string key, const History& history);
  ~StatusTuple();
  StatusTuple(const StatusTuple&) = delete;
  StatusTuple& operator=(const StatusTuple&) = delete;

 private:
  void look();
  std::string text() const;

  Scheduler& scheduler_;
  TupleSpace& space_;
  std::string key_;
  const History& history_;
  History::State shown_{};
  WallTime since_{};
  std::string text_;
  SteadyTime numbers_due_{};
  Timer timer_;
};

}  // namespace rubicon::history
