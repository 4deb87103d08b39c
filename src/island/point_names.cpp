#include "island/point_names.h"

#include <fmt/format.h>

#include <string_view>
#include <unordered_map>

#include "base/nearest.h"

namespace rubicon::island {

namespace {

/// To compare each wrong address with all others takes time; who made so many mistakes has them all in sight.
constexpr std::size_t kMostNamed = 50;

proxy::LostName lost_device(const std::string& address, const std::vector<network::ListedDevice>& listed) {
  std::vector<std::string> addresses;
  for (const auto& device : listed) addresses.push_back(device.address);
  const auto near = base::did_you_mean(address, addresses);
  return {{address}, fmt::format("the network has no such device{}", near.empty() ? "" : "; " + near)};
}

}  // namespace

std::vector<proxy::LostName> lost_names(const proxy::NetworkRules& rules,
                                        const std::optional<std::vector<network::ListedDevice>>& listed,
                                        const TypeCatalogue& types) {
  std::vector<proxy::LostName> out;
  if (!listed) return out;
  std::unordered_map<std::string_view, const network::ListedDevice*> by_address;
  for (const auto& device : *listed) by_address.emplace(device.address, &device);
  for (const auto& [address, names] : rules.devices) {
    if (out.size() >= kMostNamed) break;
    const auto device = by_address.find(address);
    if (device == by_address.end()) {
      out.push_back(lost_device(address, *listed));
      continue;
    }
    std::vector<std::string> sensors, actuators;
    for (const auto& capability : device->second->capabilities) {
      if (capability.point.kind == Kind::kProperty) continue;
      auto& ids = capability.point.kind == Kind::kSensor ? sensors : actuators;
      ids.push_back(proxy::point_id(nullptr, capability, types.find(capability.point.type)));
    }
    for (auto& lost : proxy::lost_names(names, sensors, actuators)) {
      lost.path.insert(lost.path.begin(), address);
      out.push_back(std::move(lost));
    }
  }
  return out;
}

}  // namespace rubicon::island
