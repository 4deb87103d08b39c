#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace rubicon::bench::web {

inline constexpr std::uint32_t kIsland = 6541;
inline constexpr int kPointsPerDevice = 5;
/// Of the values of all points.
inline constexpr const char* kValues = "*:*.*.*.*.*.value";

/// `proxy.hall.17`
std::string device_key(int device);
/// `proxy.hall.17.sensor.light-1`, of the points of all devices in turn.
std::string point_key(std::size_t point);
/// The value that update `update` (from 1 on) sets; it changes point `update % points`.
std::string value_of(std::uint64_t update);
/// The last update of a point when so many were made; 0 = none.
std::uint64_t last_update(std::size_t point, std::size_t points, std::uint64_t made);

}  // namespace rubicon::bench::web
