#pragma once

#include <cstdint>
#include <optional>

#include "rubicon/time.hpp"

namespace rubicon::networks::zigbee::bridge {

/// Whether the lists of the bridge have a device, and when their lack of it means that it is gone: a list can be
/// published in the middle of a change (zigbee.md, section 9), and a retained copy can be older than the bridge.
class Presence {
 public:
  static constexpr Duration kAbsence = std::chrono::seconds(10);
  /// The same for a device that only a retained copy lacks: a living device with a battery reports within this time.
  static constexpr Duration kRetainedAbsence = std::chrono::hours(25);

  /// A list has the device. `list`: its number; `received`: how many had arrived when it did.
  void listed(std::uint64_t list, std::uint64_t received);
  bool in_list(std::uint64_t list) const { return listed_in_ == list; }
  /// A complete list lacks it. Why it is gone, or nullptr if it is not gone yet.
  const char* lacked(bool live_list, SteadyTime now);
  /// The same by the time alone.
  const char* overdue(SteadyTime now) const;
  /// When overdue() is to be asked; nullopt: the last list has the device, or nothing is known.
  std::optional<SteadyTime> due() const;
  /// A live message of the device or about it.
  void heard();
  /// The bridge reported that it left, or removed it, after so many lists had arrived.
  void leaving(std::uint64_t received) { leaving_after_ = received; }
  /// Another connection, another chance.
  void line_lost();

 private:
  std::uint64_t listed_in_ = 0;
  std::optional<SteadyTime> missing_since_;
  bool missing_live_ = false;  ///< a live list lacks it
  bool heard_ = false;         ///< since the line was lost
  std::optional<std::uint64_t> leaving_after_;
};

}  // namespace rubicon::networks::zigbee::bridge
