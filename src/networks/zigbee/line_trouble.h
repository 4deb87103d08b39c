#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <string>

namespace rubicon::networks::zigbee {

/// What is known of a line that is up.
struct LineFacts {
  std::string base;                     ///< topic of the bridge
  std::string user;                     ///< as which the broker knows us; empty = none
  std::set<std::string> forbidden;      ///< filters whose subscription the broker refused
  std::set<std::string> not_taken;      ///< topics to which it takes no messages of ours
  bool list_missing = false;            ///< no bridge/devices was received, although it is time
  bool others_came = false;             ///< another retained message of the bridge was received: bridge/groups
  bool retains = true;                  ///< false: mqtt.force_disable_retain
  std::optional<std::size_t> too_long;  ///< bytes of a bridge/devices that was dropped
  std::size_t largest_packet = 0;       ///< bytes that we take
  std::size_t silent_devices = 0;       ///< so many devices, and nothing of any of them for too long
};

/// What is wrong with a line that is up, the likely cause, and what to do; empty = nothing is. Of several troubles the
/// one that explains the others.
std::string line_trouble(const LineFacts& facts);

}  // namespace rubicon::networks::zigbee
