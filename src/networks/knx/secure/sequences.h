#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "base/scheduler.h"
#include "networks/knx/secure/group_keys.h"

namespace rubicon::networks::knx::secure {

/// Our own sequence numbers in Data Secure (knx.md, section 11): none is used twice, whenever the process is killed.
/// Numbers are reserved on the disk before the first of them is used. The first of a reservation is the largest of: the
/// one after the last reserved, the one after `known`, and the milliseconds since 2018-01-05T00:00Z, which also repair
/// an old copy of the storage. (An old copy together with a clock that was set back cannot be noticed before the clock
/// is right.) Where the clock is ahead of the reservation by a minute, numbers are reserved from the clock: many hosts
/// know the time only some seconds after their start.
class OwnSequence {
 public:
  static constexpr std::uint64_t kReserve = 1000;
  static constexpr std::uint64_t kAhead = 60'000;  ///< ms

  /// The scheduler must outlive it. `known`: the last number known from elsewhere, 0 = none.
  OwnSequence(Scheduler& scheduler, GroupStorage storage, std::uint64_t known);

  /// Later numbers are above `known`.
  void raise(std::uint64_t known) { next_ = std::max(next_, known + 1); }
  /// 1 to kMaxSequence. kUnsupported: nothing is kept across restarts; kIo: the storage fails; kInvalid: what is stored
  /// cannot be read; kRefused: the clock was never set, and no last number is known; kOutOfRange: all numbers are used.
  /// Each with a sentence for the user.
  Result<std::uint64_t> next();
  /// The error that next() gives for a lack of storage or of a clock.
  Result<void> usable();

 private:
  Result<void> load();
  Result<void> reserve();

  Scheduler& scheduler_;
  GroupStorage storage_;
  bool loaded_ = false;
  std::uint64_t next_;       ///< at least
  std::uint64_t limit_ = 0;  ///< the last number that is reserved for this process
};

/// The last valid sequence number of each sender. Numbers are kept across restarts, written at most each 10 s and at
/// destruction, and wait for the disk at most once a minute: after a power cut telegrams of the last minute could be
/// replayed once. Numbers of senders that are no
/// longer expected stay stored: they may come back.
class SenderSequences {
 public:
  static constexpr Duration kPause = std::chrono::seconds(10), kSyncPause = std::chrono::seconds(60);

  /// `start`: the expected senders with their least last number. The scheduler must outlive it.
  SenderSequences(Scheduler& scheduler, GroupStorage storage, std::map<wire::IndividualAddress, std::uint64_t> start,
                  Note note);
  ~SenderSequences();
  SenderSequences(const SenderSequences&) = delete;
  SenderSequences& operator=(const SenderSequences&) = delete;

  /// 0 for a sender that is not known. An error with the reason while what is stored cannot be read.
  Result<std::uint64_t> last(wire::IndividualAddress sender);
  /// After last() of this sender succeeded.
  void set(wire::IndividualAddress sender, std::uint64_t sequence);

 private:
  /// Area and line of an address: the senders of one line are stored together.
  static std::uint8_t line_of(wire::IndividualAddress sender) {
    return static_cast<std::uint8_t>(number(sender) >> 8U);
  }
  Result<void> load(std::uint8_t line);
  void take(std::uint8_t line, ByteView stored);
  void write();
  void sync();
  Bytes row_of(std::uint8_t line) const;
  void note(std::string_view text);

  GroupStorage storage_;
  std::map<wire::IndividualAddress, std::uint64_t> last_;
  Note note_;
  std::set<std::uint8_t> loaded_, changed_;  ///< lines
  std::optional<std::uint8_t> unsynced_;     ///< a line that was written since the last sync, if there is one
  base::PacedCall write_later_, sync_later_;
};

}  // namespace rubicon::networks::knx::secure
