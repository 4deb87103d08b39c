#pragma once

#include <string>

#include "base/scheduler.h"
#include "history/history.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::history {

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
