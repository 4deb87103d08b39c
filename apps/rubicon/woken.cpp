#include "apps/rubicon/woken.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/rubicon/output.h"
#include "client/device_watch.h"
#include "model/point_keys.h"

namespace rubicon::cli {

namespace {

bool wakes(const client::Device& device, const Selections& selections) {
  return std::any_of(device.sensors.begin(), device.sensors.end(), [&](const std::string& sensor) {
    const auto key = model::DeviceKey{device.key()}.point(Kind::kSensor, sensor).value();
    return any_fits(selections, device.island, key);
  });
}

}  // namespace

std::size_t count_woken(const std::vector<client::Device>& devices, const Selections& selections) {
  return static_cast<std::size_t>(std::count_if(
      devices.begin(), devices.end(), [&](const client::Device& device) { return wakes(device, selections); }));
}

void warn_if_many_wake(Client& client, const Selections& selections) {
  client.read({std::nullopt, model::IslandKey{"*"}.network("*").device("*").description()},
              [selections](const std::vector<client::Tuple>& tuples) {
                std::vector<client::Device> devices;
                for (const auto& tuple : tuples) {
                  if (auto device = client::device_from(tuple.owner, tuple.key, tuple.value))
                    devices.push_back(std::move(*device));
                }
                if (const auto count = count_woken(devices, selections); count > kManyDevices)
                  print_error(fmt::format("this wakes the sensors of {} devices; --passive wakes none", count));
              });
}

void Wakers::wake(OwnerId owner, std::string_view key) {
  const std::pair name(owner, std::string(key));
  if (handles_.contains(name)) return;
  if (handles_.size() < most_) {
    handles_.emplace(name, subscribe_({owner, name.second}));
  } else if (!std::exchange(full_, true)) {
    print_error(fmt::format("more than {} tuples match: the others are shown, but not woken", most_));
  }
}

void Wakers::forget(OwnerId owner, std::string_view key) {
  handles_.erase({owner, std::string(key)});
}

}  // namespace rubicon::cli
