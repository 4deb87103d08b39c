#pragma once

#include <array>
#include <cstdint>
#include <random>

#include "motes/mote_packet.h"

namespace rubicon::motes_simulator {

/// Bytes for a record after NetMsg header, transport and application (wsn.md 12).
inline constexpr std::size_t kRecordRoom = 100;
inline constexpr std::size_t kNetHeader = 12;
/// The nbytes field of everything that a mote sends, whatever its length (wsn.md 5).
inline constexpr std::uint8_t kFullCount = 0x66;

/// The message buffers of a firmware. They are reused and not always cleared, so that parts of older messages follow a
/// record (wsn.md 5).
class MessageMemory {
 public:
  /// `stale`: share of the messages in which parts of an older one follow the record; in the others zeros do.
  MessageMemory(double stale, std::uint64_t seed) : stale_(stale), rng_(seed) {}

  /// 114 bytes: the message, its record, and the previous content of the buffer.
  Bytes build(motes::NetMessage message);
  /// In an acknowledgement one further byte follows the record, which differs between recordings.
  Bytes build_ack(motes::NetMessage message);
  void clear() { last_.clear(); }
  std::mt19937_64& rng() { return rng_; }

 private:
  using Room = std::array<std::uint8_t, kRecordRoom>;
  Room room();
  Bytes wrap(motes::NetMessage& message, const Room& room);

  double stale_;
  std::mt19937_64 rng_;
  Bytes last_;  ///< the previous message
};

}  // namespace rubicon::motes_simulator
