#pragma once

#include <cstdint>

namespace rubicon::networks::knx::line {

/// Counters of all tunnels that a line has opened one after another.
struct TunnelCounters {
  std::uint64_t repeats = 0;             ///< requests sent a second time
  std::uint64_t missing_acks = 0;        ///< no TUNNELLING_ACK with status 00 in time
  std::uint64_t unconfirmed = 0;         ///< no L_Data.con in time
  std::uint64_t not_acknowledged = 0;    ///< L_Data.con with its error bit
  std::uint64_t not_understood = 0;      ///< TUNNELLING_ACK with status 29
  std::uint64_t late_confirmations = 0;  ///< L_Data.con that belongs to no pending request
  std::uint64_t duplicates = 0;          ///< received again, acknowledged, discarded
  std::uint64_t wrong_sequence = 0;
  std::uint64_t wrong_channel = 0;
  std::uint64_t bad_frames = 0;
  std::uint64_t unknown_services = 0;
  std::uint64_t missing_heartbeats = 0;
};

}  // namespace rubicon::networks::knx::line
