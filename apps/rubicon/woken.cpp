#include "apps/rubicon/woken.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/rubicon/output.h"
#include "client/device_watch.h"

namespace rubicon::cli {

namespace {

bool wakes(const client::Device& device, const std::vector<Pattern>& patterns) {
  return std::any_of(device.sensors.begin(), device.sensors.end(), [&](const std::string& sensor) {
    const auto key = fmt::format("{}.sensor.{}.value", device.key(), sensor);
    return std::any_of(patterns.begin(), patterns.end(),
                       [&](const Pattern& pattern) { return pattern.matches(device.island, key); });
  });
}

}  // namespace

std::size_t woken_devices(const std::vector<client::Device>& devices, const std::vector<Pattern>& patterns) {
  return static_cast<std::size_t>(std::count_if(devices.begin(), devices.end(),
                                                [&](const client::Device& device) { return wakes(device, patterns); }));
}

void tell_who_wakes(Client& client, const std::vector<Pattern>& patterns) {
  client.read({std::nullopt, "*.*.*.description"}, [patterns](const std::vector<client::Tuple>& tuples) {
    std::vector<client::Device> devices;
    for (const auto& tuple : tuples) {
      if (auto device = client::device_from(tuple.owner, tuple.key, tuple.value)) devices.push_back(std::move(*device));
    }
    if (const auto count = woken_devices(devices, patterns); count > kManyDevices)
      say(fmt::format("this wakes the sensors of {} devices; --passive wakes none", count));
  });
}

}  // namespace rubicon::cli
