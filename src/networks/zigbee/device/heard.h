#pragma once

#include <optional>

#include "rubicon/time.hpp"

namespace rubicon::networks::zigbee::device {

/// What a state message contains besides its values.
struct Heard {
  WallTime arrival{};
  std::optional<WallTime> last_seen{};  ///< absent: Zigbee2MQTT is configured to leave it out
  /// Its last_seen is later than all before it, or it has none: the device may have sent something. Otherwise
  /// Zigbee2MQTT published by itself: an echo, a timer of its own, a repetition.
  bool later = true;
  bool copy = false;      ///< a repetition of old values, at the start of Zigbee2MQTT for example
  bool at_start = false;  ///< a copy, or a repetition of the last message, that Zigbee2MQTT publishes when it starts
  /// A copy by the time alone: no last_seen, soon after the start. Events are no copies, as Zigbee2MQTT keeps none.
  bool presumed = false;
  bool answers = false;  ///< it has a property that was asked for and not answered yet: that one is no copy
  bool older = false;    ///< a copy from before the last message: Zigbee2MQTT lost what came since then
  bool aged = false;     ///< its last_seen is not of this moment
  /// No property differs from the message before it: a report of what was known, or of nothing.
  bool quiet = false;
};

}  // namespace rubicon::networks::zigbee::device
