#pragma once

#include <cstdint>
#include <deque>
#include <tuple>

#include "motes/mote_packet.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::wsn {

/// Reliable messages of the last seconds: a sender that misses our acknowledgement says it again. And reports: one that
/// the radio carries twice is no second measurement. Not for longer: after a restart a mote counts from the same number
/// again (wsn.md 9.2).
class RecentMessages {
 public:
  static constexpr Duration kSpan = std::chrono::seconds(3);
  static constexpr std::size_t kMost = 256;

  /// True if it was heard before; else it is from now on.
  bool seen(const motes::NetMessage& message, SteadyTime now);
  /// It was switched on, and counts anew.
  void forget(std::uint16_t mote);

 private:
  using Name = std::tuple<std::uint16_t, std::uint16_t, std::uint16_t, std::uint8_t, std::uint8_t, std::uint8_t>;
  std::deque<std::pair<SteadyTime, Name>> names_;
};

}  // namespace rubicon::networks::wsn
