#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/rate_limit.h"
#include "base/scheduler.h"
#include "recorder/recording_file.h"
#include "recording/block_builder.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::recorder {

/// Writes what some patterns match to a file (docs/recording.md). A block goes to the file when it is full, and once a
/// second; what cannot be written is dropped and counted, and the file is tried again after a second, then after pauses
/// that double up to a minute. Everything taken by reference must outlive it; its destruction writes what is left.
class Recorder {
 public:
  struct Place {
    Scheduler& scheduler;
    TupleSpace& space;  ///< the island's own: there each set is seen; another one's sees the last of a turn
    transport::Transports& transports;
    base::LogSink& log;
    std::string prefix;                ///< of the island's keys
    std::string directory{};           ///< where a relative path starts
    OwnerId island = model::kNoOwner;  ///< whose recording it is; kNoOwner = of who owns the space
  };
  Recorder(config::RecorderSetup setup, Place place);
  ~Recorder();

  /// Subscribes and opens the file. Before, nothing is touched.
  void start();

  /// Since the start.
  struct Counters {
    std::uint64_t records = 0;   ///< written
    std::uint64_t bytes = 0;     ///< written, compressed
    std::uint64_t dropped = 0;   ///< records that could not be written
    std::uint64_t files = 0;     ///< begun
    std::uint64_t failures = 0;  ///< of opening, writing and rotating
    std::uint64_t cut = 0;       ///< bytes of damaged tails
  };
  const Counters& counters() const { return counters_; }
  const config::RecorderSetup& setup() const { return setup_; }
  /// `recording`, or `dropping records: why`.
  std::string state() const { return reason_.empty() ? "recording" : "dropping records: " + reason_; }
  /// Writes what waits.
  void flush() { write_block(); }

 private:
  void on_event(std::size_t pattern, const tuples::Event& event);
  void add(recording::RecordKind kind, const tuples::TupleView& tuple);
  OwnerId identity() const;
  void mark(std::string_view word);
  void take(const recording::Record& record);
  WallTime seen();
  void write_block();
  bool make_ready(WallTime first);
  void rotate_if_due(WallTime now);
  void failed(const Error& why);
  void failed_to_write(const Error& why);
  void drop(std::uint64_t records);
  void written();
  void complain(std::string_view text);
  void begin_snapshot(std::string_view word);
  void snapshot_slice();

  config::RecorderSetup setup_;
  Place place_;
  Log log_;
  base::RateLimit complaints_;
  recording::BlockBuilder block_;
  RecordingFile file_;
  Counters counters_;
  WallTime seen_{};  ///< the moment of this turn
  bool seen_is_fresh_ = false;
  SteadyTime try_again_{}, rotate_again_{}, failed_at_{};
  Duration pause_{};    ///< before the next attempt to write; zero = the last minute had no failure
  bool gap_ = false;    ///< something was dropped since the last snapshot
  std::string reason_;  ///< why nothing can be written; empty = it can
  SteadyTime trouble_since_{}, next_count_{};
  std::uint64_t dropped_before_ = 0;                       ///< the trouble began
  std::vector<std::pair<OwnerId, std::string>> snapshot_;  ///< still to be written, from the back
  bool in_snapshot_ = false;
  Timer flush_;
  std::vector<tuples::Handle> subscriptions_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  ///< posted calls look whether we still are
};

}  // namespace rubicon::recorder
