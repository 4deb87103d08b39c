#pragma once

#include <array>
#include <cstdint>
#include <random>

#include "motes/mote_packet.h"

namespace rubicon::motes_simulator {

/// Room for a record behind NetMsg header, transport and application (wsn.md 12).
inline constexpr std::size_t kRecordRoom = 100;
inline constexpr std::size_t kNetHeader = 12;
/// What stands in the nbytes field of all that a mote sends, whatever its length (wsn.md 5).
inline constexpr std::uint8_t kFullCount = 0x66;

/// Where a firmware builds its messages. The buffers are used again and not always cleared, so that parts of older
/// messages stand behind a record (wsn.md 5).
class MessageMemory {
 public:
  /// `stale`: share of the messages with parts of an older one behind the record; the others have zeros there.
  MessageMemory(double stale, std::uint64_t seed) : stale_(stale), rng_(seed) {}

  /// 114 bytes: the message with its record in front of what memory holds.
  Bytes build(motes::NetMessage message);
  /// The acknowledgement's buffer has one odd byte behind the record, in each recording another.
  Bytes build_ack(motes::NetMessage message);
  void clear() { last_.clear(); }
  std::mt19937_64& rng() { return rng_; }

 private:
  using Room = std::array<std::uint8_t, kRecordRoom>;
  Room room();
  Bytes wrap(motes::NetMessage& message, const Room& room);

  double stale_;
  std::mt19937_64 rng_;
  Bytes last_;  ///< the message before
};

}  // namespace rubicon::motes_simulator
