#include "web/generated_points.h"

#include <fmt/format.h>

#include <array>

namespace rubicon::bench::web {

namespace {

constexpr std::array<const char*, kPointsPerDevice> kTypes{"temperature", "humidity", "light", "carbonDioxide",
                                                           "battery"};

}  // namespace

std::string device_key(int device) {
  return fmt::format("proxy.hall.{}", device);
}

std::string point_key(std::size_t point) {
  const auto device = static_cast<int>(point / kPointsPerDevice);
  return fmt::format("{}.sensor.{}-1", device_key(device), kTypes[point % kPointsPerDevice]);
}

std::string value_of(std::uint64_t update) {
  return fmt::format("{}.{}", update / 10, update % 10);
}

std::uint64_t last_update(std::size_t point, std::size_t points, std::uint64_t made) {
  if (made < point || made == 0) return 0;
  return made - (made - point) % points;
}

}  // namespace rubicon::bench::web
