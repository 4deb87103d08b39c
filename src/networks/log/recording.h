#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "model/message.h"
#include "networks/log/replay_clock.h"
#include "recording/recording_reader.h"

namespace rubicon::networks::log {

/// Counts of what the files held so far; `lines` are those of text tables.
struct ReplayCounters {
  std::uint64_t records = 0;
  std::uint64_t readings = 0;
  std::uint64_t damaged = 0;
  std::uint64_t skipped_bytes = 0;
  std::uint64_t lines = 0;
};

/// The messages of devices at one moment of a recording.
struct Step {
  RecordTime time{};
  /// UTC of the moment, if the recording has it.
  std::optional<WallTime> wall;
  /// Device and message, in order.
  std::vector<std::pair<std::string, model::Body>> messages;
};

/// Reports damage: byte offset in the present file, and what is wrong there.
using Complaint = std::function<void(std::uint64_t offset, std::string_view what)>;

/// A recording format: turns the bytes of one file after the other into steps. Knows neither files nor time.
class Recording {
 public:
  virtual ~Recording() = default;
  /// A file begins. `labels`: its entries in label_tables(), in their order.
  virtual void begin(std::string_view file_name, std::vector<std::string> labels) = 0;
  /// A new round begins with the first file.
  virtual void restart() {}
  virtual void feed(ByteView bytes) = 0;
  /// The file has no more bytes.
  virtual void end() = 0;
  /// The next step; nullopt until more bytes are fed. One moment may give several steps of the same time.
  virtual std::optional<Step> next() = 0;
  /// next() returned nothing only to end the turn: call it again before feeding more.
  virtual bool has_more() const { return false; }
  /// Everything that must be known before playing is known.
  virtual bool ready() const { return true; }
  /// Why nothing can be played, an error that reading the files again does not cure.
  virtual std::optional<Error> failure() const { return std::nullopt; }
  /// Whether the times of a file continue those of the file before.
  virtual bool absolute_times() const = 0;
  /// Readings have the user times they were recorded with.
  virtual bool has_user_times() const { return false; }
  /// The pause between two files whose times are unrelated.
  virtual RecordTime period() const = 0;
  /// Paths of tables with an entry for each file. Its key is the last number in the file's name.
  virtual std::vector<std::string> label_tables() const { return {}; }
  /// All devices so far; they leave at the end if the options say so.
  virtual std::vector<std::string> devices() const = 0;
};

/// Counts and reports what cannot be played of a recording. The counters and the reader must outlive it.
class RecordingFaults {
 public:
  RecordingFaults(ReplayCounters& counters, Complaint complain, const recording::RecordingReader& reader)
      : counters_(counters), complain_(std::move(complain)), reader_(reader) {}

  void skipped(const recording::Damage& damage) {
    ++counters_.damaged;
    counters_.skipped_bytes += damage.bytes;
    complain_(damage.offset, fmt::format("{}; {} bytes skipped", damage.why, damage.bytes));
  }
  /// A record that cannot be played.
  void invalid(const std::string& text) {
    ++counters_.damaged;
    complain_(reader_.block_offset(), text);
  }
  /// More of something than is played; reported once for each `what`.
  void limit_exceeded(std::string_view what, std::size_t limit) {
    if (!exceeded_.emplace(what).second) return;
    invalid(fmt::format("more {} than are played, expected at most {}; the others are ignored", what, limit));
  }
  /// A file of another island.
  void foreign_file(const std::string& text) { complain_(0, text); }

 private:
  ReplayCounters& counters_;
  Complaint complain_;
  const recording::RecordingReader& reader_;
  std::set<std::string, std::less<>> exceeded_;
};

/// Limits the work of one turn of the loop, so that a long recording does not hold up the other networks. Counts in
/// small records, each about 100 ns.
class WorkBudget {
 public:
  void charge(std::size_t records) { used_ += records; }
  void charge_copied(std::size_t bytes) { used_ += bytes / kCopiedPerRecord; }
  void charge_parsed(std::size_t bytes) { used_ += bytes / kParsedPerRecord; }
  /// For work that must be the last of its turn.
  void charge_all() { used_ += kRecords; }

  bool used_up() const { return used_ >= kRecords; }
  /// A new turn.
  void renew() { used_ = 0; }

 private:
  static constexpr std::size_t kRecords = 10'000;
  /// Number of bytes that take as long to read as a small record.
  static constexpr std::size_t kCopiedPerRecord = 256, kParsedPerRecord = 16;

  std::size_t used_ = 0;
};

}  // namespace rubicon::networks::log
