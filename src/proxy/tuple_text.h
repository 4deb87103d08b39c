#pragma once

#include <string>

#include "proxy/device.h"

namespace rubicon::proxy {

// The JSON texts of the proxy's tuples. Times are seconds since 1970; 0 = never.

/// A value as its tuple shows it: booleans by the words of their type, `on` and `off` where it has none. Written into a
/// string that keeps its memory.
void write_value(const Type* type, const Value& value, std::string& out);

/// {quality, since, heard, changed, reason[, command]}. Written into a string that keeps its memory.
void write_point_status(const Device& device, const Point& point, std::string& out);

/// {status, since, reason}
std::string device_status_text(const Device& device);
/// {type, type_id, quantity, unit, data_type, minimum, maximum, words, codes, access, report, instance}
std::string point_description(const Point& point);
/// {name[, area], model, type, address, network, capabilities, sensors, actuators, properties}
std::string device_description(const Device& device);
/// {line, since, reason, attempts, next_attempt}
std::string network_status_text(const Network& network);
/// Ids of the reachable devices.
std::string reachable_devices(const Network& network);
/// Adds the ids of the reachable devices to a JSON list that is open, each behind `before`.
void append_reachable(const Network& network, std::string_view before, std::string& list);

/// `0.35 s`, to the millisecond.
std::string seconds_text(Duration span);

}  // namespace rubicon::proxy
