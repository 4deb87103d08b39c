#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/simulators/zigbee/radio_device.h"
#include "rubicon/time.hpp"

namespace rubicon::zigbee_simulator {

struct DeviceGroup;
struct WorldOptions;

/// `2026-11-21T00:16:49.837Z`
std::string iso_8601(WallTime time);
/// last_seen as the setting says; null for `disable`.
nlohmann::json last_seen_json(const std::string& setting, WallTime time);

/// The record of the coordinator, 0x00124b00deadbeef.
nlohmann::json coordinator_record();
/// `bridge/info` without its configuration schema.
nlohmann::json info_json(const WorldOptions& options, const std::vector<RadioDevice*>& devices, bool joining,
                         WallTime joining_end, bool restart_required);
/// `bridge/groups`
nlohmann::json groups_json(const std::vector<const DeviceGroup*>& groups);
/// `bridge/health`
nlohmann::json health_json(const std::vector<RadioDevice*>& devices, WallTime now, Duration up, std::uint64_t published,
                           std::uint64_t received);
/// The data of the response to `networkmap`; all devices hear the coordinator, and each the next.
nlohmann::json map_json(const std::vector<RadioDevice*>& devices, bool routes);

}  // namespace rubicon::zigbee_simulator
