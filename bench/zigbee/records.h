#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/time.hpp"

namespace rubicon::bench::zigbee {

/// The records of `bridge/devices` of so many devices of one of the simulator's models (empty: of all), with texts as
/// long as those of a real Zigbee2MQTT: 3.7 KB a device.
std::vector<std::string> device_records(int devices, std::string_view model = {});

/// The payload of `bridge/devices` with the first so many records.
std::string list_of(const std::vector<std::string>& records, std::size_t count);

/// The same record under another friendly name.
std::string renamed(const std::string& record, const std::string& name);

/// As a record is before the interview ends.
std::string interviewing(const std::string& record);

/// A report of a thermometer with all cached properties, of 149 bytes; `count` varies its values.
std::string state_text(WallTime seen, int count);

std::string address_of(const std::string& record);
std::string name_of(const std::string& record);

}  // namespace rubicon::bench::zigbee
