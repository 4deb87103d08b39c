#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "config/history_config.h"
#include "history/history_source.h"
#include "history/questions.h"
#include "rubicon/key.hpp"
#include "rubicon/tuple_space.hpp"
#include "transport/worker.h"

namespace rubicon::history {

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
  Counters counters() const override;

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

}  // namespace rubicon::history
