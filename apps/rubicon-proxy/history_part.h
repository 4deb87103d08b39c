#pragma once

#include <memory>
#include <optional>
#include <string>

#include "base/log.h"
#include "history/history.h"
#include "history/status_tuple.h"
#include "rubicon/tuple_space.hpp"
#include "tuples/link.h"

namespace rubicon::daemon {

/// The history of an island: a component of its own beside it, as the console is one. The island does not depend on it:
/// where it cannot be opened, the log says why, and it is tried again.
class HistoryPart {
 public:
  /// All must outlive it.
  struct Host {
    Scheduler& scheduler;
    tuples::Ecology& ecology;
    LogSink& log;
    TupleSpace& island;  ///< its status is a tuple of the island
    std::string prefix;  ///< of the keys of the island
  };

  HistoryPart(Host host, OwnerId id) : host_(std::move(host)), id_(id), log_(host_.log, "history") {}

  /// Whether take() would change nothing.
  bool has(const std::optional<config::HistorySetup>& setup) const;
  /// Opens, changes or closes the history.
  void take(const std::optional<config::HistorySetup>& setup, const std::string& directory);
  /// nullptr if there is none.
  history::History* history() const { return history_.get(); }

 private:
  Result<void> open(const config::HistorySetup& setup, const std::string& directory);

  Host host_;
  OwnerId id_;
  Log log_;
  std::unique_ptr<tuples::Link> link_;
  std::unique_ptr<TupleSpace> space_;
  std::unique_ptr<history::History> history_;
  std::unique_ptr<history::StatusTuple> status_;
};

}  // namespace rubicon::daemon
