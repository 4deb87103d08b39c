#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "config/history_config.h"
#include "history/answer.h"
#include "history/counters.h"
#include "rubicon/key.hpp"
#include "rubicon/tuple_space.hpp"
#include "transport/worker.h"

namespace rubicon::history {

using AnswerCall = std::function<void(Result<Answer>)>;
using SeriesCall = std::function<void(Result<std::vector<SeriesEntry>>)>;

/// Keeps the values of tuples in one file, and answers what they were (docs/history.md). It observes passively. The
/// loop never waits for the file: a worker reads and writes it, in batches. All calls of callers run on the loop, in
/// a later turn.
class History final {
 public:
  struct Context {
    Scheduler& scheduler;
    std::unique_ptr<transport::Worker> worker;  ///< of this history alone
    base::LogSink& log;
    std::string directory{};  ///< relative paths start here
  };
  /// Opens the file, in the worker. What fails is in state() and in the log, and is tried again. Points that cannot be
  /// written wait, up to a bound.
  History(config::HistorySetup setup, Context context);
  /// Writes what is not written yet; waits for the worker to do it.
  ~History();

  /// Stores what the space shows of the configured tuples, as soon as the file is open. The space must outlive this.
  void follow(TupleSpace& space);

  /// The past of some series. kInvalid: a question beyond its limits; kBusy: too many questions wait; kIo or kInvalid:
  /// the file cannot be read. Destroying the handle cancels the call.
  [[nodiscard]] Handle ask(Question question, AnswerCall call);
  /// The series whose tuples match, by owner and key, at most 10,000.
  [[nodiscard]] Handle series(Pattern pattern, SeriesCall call);

  Counters counters() const;
  /// `opening`, `recording`, or `not written: ` and the reason.
  std::string state() const;
  const config::HistorySetup& setup() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::history
