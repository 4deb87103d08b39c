#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "config/storage_config.h"
#include "recording/block_builder.h"
#include "recording/file_format.h"
#include "rubicon/tuple_space.hpp"
#include "transport/transports.h"

namespace rubicon::recorder {

/// The file a recorder writes: opens it, cuts off a damaged tail, appends, rotates. A write blocks the loop until the
/// operating system has the block, not until the disk has it.
class RecordingFile {
 public:
  /// `identity` is the head of new files, except its time.
  RecordingFile(transport::Transports& transports, std::string path, recording::FileHead identity,
                config::Rotation rotation);

  bool is_open() const { return file_ != nullptr; }
  const std::string& path() const { return path_; }
  /// In bytes; 0 = it is not open.
  std::uint64_t size() const { return file_ ? file_->size() : 0; }

  struct Opened {
    bool is_new = false;
    std::uint64_t cut = 0;  ///< bytes of a damaged tail
  };
  /// Continues after the last sound block, or begins a file whose first record was seen at `first`. kInvalid if the
  /// file is not a recording of this island.
  Result<Opened> open(WallTime first);
  /// After an error the file is closed, and the incomplete block cut off, at the latest by the next open().
  Result<void> append(ByteView block);

  /// The present snapshot is complete. Its size does not count for the rotation, as one snapshot may be larger than a
  /// file.
  void end_snapshot() { snapshot_size_ = file_ ? file_->size() - opened_size_ : 0; }
  bool rotation_due(WallTime now) const;
  /// Closes the file and renames it by the time of its first record. Closed after an error, too.
  Result<void> rotate();
  /// Removes the oldest of the renamed files beyond those to keep.
  Result<void> remove_old();

 private:
  Result<Opened> resume(WallTime first);
  Result<Opened> begin(WallTime first);

  transport::Transports& transports_;
  std::string path_;
  recording::FileHead identity_;
  config::Rotation rotation_;
  std::unique_ptr<transport::AppendFile> file_;
  WallTime created_{};
  std::uint64_t opened_size_ = 0;  ///< size when it was opened
  std::uint64_t snapshot_size_ = 0;
};

/// `recordings/home.rec` and a time -> `recordings/home-20260131T120000.000000Z.rec`.
std::string rotated_name(const std::string& path, WallTime first);

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
  /// longer than kMaxMark or not printable UTF-8.
  Result<void> note(std::string_view text);
  static constexpr std::size_t kMaxMark = 200;
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
