#pragma once

#include <optional>
#include <string_view>

#include "rubicon/time.hpp"

namespace rubicon::networks::zigbee::device {

/// The JSON value of `last_seen` in a state message, in each form that Zigbee2MQTT has (zigbee.md, section 1):
/// `"2026-11-21T00:16:49.837Z"`, the same in local time with the offset of the zone, or milliseconds since 1970.
/// nullopt for anything else and for times outside the years 1970 to 2199.
std::optional<WallTime> read_last_seen(std::string_view json);

}  // namespace rubicon::networks::zigbee::device
