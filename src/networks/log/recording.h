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

}  // namespace rubicon::networks::log
