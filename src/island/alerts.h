#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/scheduler.h"
#include "model/alerts.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::island {

/// How much room the disks have that an island writes to. Looked up every ten seconds at most, and rounded down (to
/// 1 MB, above 1 GB to 100 MB), so that it changes seldom.
class FreeSpace {
 public:
  explicit FreeSpace(Scheduler& scheduler) : scheduler_(scheduler) {}

  /// Bytes that the user of this process may still write beside the file; nullopt where there is no such folder.
  std::optional<std::uint64_t> beside(const std::string& file);

 private:
  struct Known {
    SteadyTime looked{};
    std::optional<std::uint64_t> bytes;
  };
  Scheduler& scheduler_;
  std::map<std::string, Known> known_;  ///< by folder: those of the configuration
};

/// Publishes what needs a person as `<prefix>.alerts`. Looks every two seconds, and writes the tuple when it changed.
/// An alert lasts as long as its cause: users acknowledge nothing.
class Alerts {
 public:
  /// Adds what is wrong at this moment; asked each time.
  using Source = std::function<void(model::AlertList&)>;

  Alerts(Scheduler& scheduler, TupleSpace& space, std::string prefix);

  /// The most urgent first. What the source uses must live as long as this.
  void add(Source source) { sources_.push_back(std::move(source)); }
  void start() { publish(); }

 private:
  void publish();
  void date(model::AlertList& list);

  Scheduler& scheduler_;
  TupleSpace& space_;
  std::string prefix_;
  std::vector<Source> sources_;
  std::map<std::pair<std::string, std::string>, WallTime> dates_;  ///< of those whose source knows none, by kind, about
  std::string published_;
  Timer timer_;
};

/// What island::Alerts needs to know of the files of an island.
struct DiskState {
  std::string of;  ///< `its state file`
  std::optional<std::uint64_t> free;
};
/// `disk-full` for less than 100 MB.
void add_disk(const std::string& about, const DiskState& disk, model::AlertList& list);
/// `not-written` while writes of the state file fail.
class StateFailures {
 public:
  /// `count` as the state file counts them.
  void look(std::uint64_t count, SteadyTime now);
  /// If one failed since then.
  void add(const std::string& about, SteadyTime since, model::AlertList& list) const;

 private:
  std::uint64_t count_ = 0;
  SteadyTime last_ = SteadyTime::min();
};
/// `not-written`: a recorder or the history, by what its status says.
void add_unwritten(const std::string& about, std::string_view status, model::AlertList& list);
/// `bridge-down`: a bridge that is not connected, by what its status says.
void add_bridge(const std::string& about, std::string_view status, model::AlertList& list);
/// `interface-down`: interfaces by which DDS reaches no other host, by the text `dds-interfaces` (docs/tuple-keys.md).
void add_interfaces(const std::string& about, std::string_view text, model::AlertList& list);
/// `held-back`: the island had certificates for DDS, as `why` shows, and does not take part by it; empty = no.
void add_held_back(const std::string& about, const std::string& why, model::AlertList& list);
/// `clock`: a clock before 2020 was never set.
void add_clock(const std::string& about, WallTime now, model::AlertList& list);

}  // namespace rubicon::island
