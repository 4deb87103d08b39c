#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "model/message.h"
#include "networks/log/replay_clock.h"

namespace rubicon::networks::log {

/// What was found in the files so far; `lines` counts those of text tables.
struct ReplayCounters {
  std::uint64_t records = 0;
  std::uint64_t readings = 0;
  std::uint64_t damaged = 0;
  std::uint64_t skipped_bytes = 0;
  std::uint64_t lines = 0;
};

/// What devices said at one moment of a recording.
struct Step {
  RecordTime time{};
  /// UTC of the moment, where the recording knows it.
  std::optional<WallTime> wall;
  /// Device and what it said, in order.
  std::vector<std::pair<std::string, model::Body>> messages;
};

/// A damaged place: byte offset in the present file, and what is wrong there.
using Complaint = std::function<void(std::uint64_t offset, std::string_view what)>;

/// A recording format: bytes of one file after the other -> steps. Knows no files and no clock.
class Recording {
 public:
  virtual ~Recording() = default;
  /// A file begins; `labels` holds what side tables say about it, in the order of label_tables().
  virtual void begin(std::string_view file_name, std::vector<std::string> labels) = 0;
  /// The first file follows again: a new round.
  virtual void restart() {}
  virtual void feed(ByteView bytes) = 0;
  /// The file has no more bytes.
  virtual void end() = 0;
  /// The next step, or nothing until more bytes come. A moment with much to say comes as several steps of one time.
  virtual std::optional<Step> next() = 0;
  /// next() gave nothing so that others get their turn: call it again, feed nothing before.
  virtual bool has_more() const { return false; }
  /// What must be known before anything can be played is known.
  virtual bool ready() const { return true; }
  /// Why nothing more can be played, however often the files are read.
  virtual std::optional<Error> failure() const { return std::nullopt; }
  /// Whether times of one file continue those of the file before.
  virtual bool absolute_times() const = 0;
  /// Readings carry the user times they were recorded with, or none.
  virtual bool has_user_times() const { return false; }
  /// Pause between two files whose times are not related.
  virtual RecordTime period() const = 0;
  /// Side tables to be looked up at each file: key (the last number in the file's name), value.
  virtual std::vector<std::string> label_tables() const { return {}; }
  /// All devices told of so far, for the end policy.
  virtual std::vector<std::string> devices() const = 0;
};

}  // namespace rubicon::networks::log
