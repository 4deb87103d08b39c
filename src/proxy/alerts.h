#pragma once

#include "model/alerts.h"
#include "proxy/device_directory.h"

namespace rubicon::proxy {

/// A battery with less charge needs a person.
inline constexpr double kLowBattery = 15;  // %
/// A failed command that was not repeated is no longer news.
inline constexpr Duration kFailureLasts = std::chrono::hours(24);

/// What the networks, devices and points show at this moment. Lines come first, then commands, batteries and silent
/// devices; devices of a line that is down are left out, because the line has its own alert.
void add_alerts(const DeviceDirectory& directory, WallTime now, model::AlertList& list);

}  // namespace rubicon::proxy
