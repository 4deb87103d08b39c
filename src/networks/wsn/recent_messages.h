#pragma once

#include <cstdint>
#include <deque>
#include <tuple>

#include "motes/mote_packet.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::wsn {

/// Detects repetitions: of reliable messages, which a mote repeats if it misses our acknowledgement, and of reports
/// that the radio carried twice. Looks back kSpan only, because after a restart a mote counts from the same number
/// again (wsn.md 9.2).
class RecentMessages {
 public:
  static constexpr Duration kSpan = std::chrono::seconds(3);
  static constexpr std::size_t kMaxMessages = 256;

  /// True if the message was seen before; it is remembered from now on.
  bool seen(const motes::NetMessage& message, SteadyTime now);
  /// The mote was switched on: its sequence numbers start again.
  void forget(std::uint16_t mote);

 private:
  using Key = std::tuple<std::uint16_t, std::uint16_t, std::uint16_t, std::uint8_t, std::uint8_t, std::uint8_t>;
  std::deque<std::pair<SteadyTime, Key>> messages_;
};

}  // namespace rubicon::networks::wsn
