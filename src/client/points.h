#pragma once

#include <array>

#include "model/point_keys.h"
#include "model/point_tuples.h"
#include "rubicon/client.hpp"

namespace rubicon::client {

/// The tuples that make up points.
struct PointPatterns {
  Pattern values, statuses, descriptions, lines;

  std::array<const Pattern*, 4> all() const { return {&values, &statuses, &descriptions, &lines}; }
};
/// kInvalid unless `points` is a key of five parts.
Result<PointPatterns> point_patterns(const Pattern& points);

/// `proxy.wsn-1.status` of `proxy.wsn-1.7.sensor.light-1.value`.
std::string line_key(std::string_view key);

/// Takes type and unit from the `.description` of a point.
void describe(Point& point, std::string_view description);
/// Shows a point of a lost island as network-down.
void hide_behind_lost_island(Point& point);

/// The devices that match among the tuples: one for each description, with the statuses of device and line.
std::vector<Device> devices_from(const std::vector<Tuple>& tuples, const DeviceQuery& query);
/// One network for each status of a line among the tuples, with the devices and properties among them.
std::vector<Network> networks_from(const std::vector<Tuple>& tuples);
/// The order of devices in lists: reachable ones first (docs/cli.md).
bool listed_before(const Device& a, const Device& b);

}  // namespace rubicon::client
