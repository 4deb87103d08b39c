#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/lifetime.h"
#include "base/limited_log.h"
#include "base/log.h"
#include "base/scheduler.h"
#include "recorder/recording_file.h"
#include "recording/block_builder.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::recorder {

/// Writes the changes of tuples that match its patterns to a file (docs/recording.md), each block when it is full and
/// at least once a second. Records that cannot be written are dropped and counted; the file is tried again after a
/// second, then after pauses that double up to a minute. Everything taken by reference must outlive it. Destroying it
/// writes the last block.
class Recorder {
 public:
  struct Context {
    Scheduler& scheduler;
    TupleSpace& space;  ///< the island's own, which shows each set; another one shows the last set of a turn
    transport::Transports& transports;
    base::LogSink& log;
    std::string prefix;                ///< of the island's keys
    std::string directory{};           ///< relative paths start here
    OwnerId island = model::kNoOwner;  ///< the recorded island; kNoOwner = the owner of the space
  };
  Recorder(config::RecorderSetup setup, Context context);
  ~Recorder();

  /// Opens the file and subscribes; the constructor does neither.
  void start();

  /// Since the start.
  struct Counters {
    std::uint64_t records = 0;   ///< written
    std::uint64_t bytes = 0;     ///< written, compressed
    std::uint64_t dropped = 0;   ///< records that could not be written
    std::uint64_t files = 0;     ///< new ones
    std::uint64_t failures = 0;  ///< to open, write and rotate files
    std::uint64_t cut = 0;       ///< bytes of damaged tails cut off
  };
  const Counters& counters() const { return counters_; }
  const config::RecorderSetup& setup() const { return setup_; }
  /// `recording`, or `dropping records: ` and the reason.
  std::string state() const { return reason_.empty() ? "recording" : "dropping records: " + reason_; }
  /// Why records are dropped; empty = they are not.
  const std::string& reason() const { return reason_; }
  /// Writes the records that are not written yet.
  void flush() { write_block(); }
  /// Writes a mark of a user with the present time: `mark`, or `mark: ` and the text. kInvalid for a text that is
  /// longer than kMostMark or not printable UTF-8.
  Result<void> note(std::string_view text);
  static constexpr std::size_t kMostMark = 200;
  const std::string& path() const { return file_.path(); }
  /// Of the file in bytes; 0 = it is not open.
  std::uint64_t file_size() const { return file_.size(); }

 private:
  void on_event(std::size_t pattern, const tuples::Event& event);
  void add(recording::RecordKind kind, const tuples::TupleView& tuple);
  OwnerId identity() const;
  void mark(std::string_view word);
  void write(const recording::Record& record);
  WallTime seen();
  void write_block();
  bool ensure_open(WallTime first);
  bool is_left_out(std::string_view key) const { return key == log_lines_; }
  void log_opening(const RecordingFile::Opened& opened);
  void rotate_if_due(WallTime now);
  void failed(const Error& why);
  void failed_to_write(const Error& why);
  void drop(std::uint64_t records);
  void written();
  void log_failure(std::string_view text);
  void begin_snapshot(std::string_view word);
  void write_snapshot_slice();

  config::RecorderSetup setup_;
  Context context_;
  std::string log_lines_;  ///< repeats a hundred lines at each new one, and is no part of the building: not recorded
  Log log_;
  base::LimitedLog limited_log_;
  recording::BlockBuilder block_;
  RecordingFile file_;
  Counters counters_;
  std::optional<WallTime> seen_;  ///< the time of this turn, read once
  SteadyTime try_again_{}, rotate_again_{}, failed_at_{};
  Duration pause_{};    ///< before the next attempt to write; zero = no failure in the last minute
  bool gap_ = false;    ///< records were dropped since the last snapshot
  std::string reason_;  ///< why records are dropped; empty = they are not
  SteadyTime failing_since_{}, next_count_{};
  std::uint64_t dropped_before_ = 0;                       ///< dropped records at failing_since_
  std::vector<std::pair<OwnerId, std::string>> snapshot_;  ///< keys still to be written, from the back
  bool in_snapshot_ = false;
  Timer flush_;
  std::vector<tuples::Handle> subscriptions_;
  bool closing_ = false;
  base::OncePerTurn end_turn_;
  base::OncePerTurn next_slice_;
};

}  // namespace rubicon::recorder
