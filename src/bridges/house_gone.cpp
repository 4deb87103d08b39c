#include <algorithm>
#include <iterator>
#include <utility>

#include "bridges/house.h"

// What is not there any longer: deleted by its owner, not brought back by it, or gone with it.
namespace rubicon::bridges {

void House::forget_lost(OwnerId island) {
  const auto is_gone = [island](const auto& entry) { return entry.island == island && entry.lost; };
  std::vector<std::string> networks, devices;
  std::vector<PointEntry*> points;
  for (const auto& [name, network] : networks_) {
    if (is_gone(network)) networks.push_back(name);
  }
  for (const auto& [name, device] : devices_) {
    if (is_gone(*device)) devices.push_back(name);
    if (device->island != island || device->lost) continue;
    std::copy_if(device->points.begin(), device->points.end(), std::back_inserter(points),
                 [](const auto* point) { return point->lost; });
  }
  for (const auto* point : points) forget_point(*point);
  for (const auto& name : devices) forget_device(name);
  for (const auto& name : networks) forget_network(name);
  forget_lost_origins(island);
}

/// Of networks that came from where we show them, and do not any longer.
void House::forget_lost_origins(OwnerId island) {
  const auto below = name_of(island, {});
  std::vector<model::NetworkKey> shown;
  std::erase_if(foreign_, [&](const std::string& name) {
    if (!name.starts_with(below)) return false;
    const model::NetworkKey network{name.substr(below.size())};
    const bool is_lost = !host_.space.get(island, network.property(scope_.origin));
    if (is_lost) shown.push_back(network);
    return is_lost;
  });
  for (const auto& network : shown) look_again(island, network);
}

void House::forget_island(OwnerId island) {
  std::set<std::string> networks;
  for (const auto& [name, network] : networks_) {
    if (network.island == island) networks.insert(name);
  }
  for (const auto& [name, device] : devices_) {
    if (device->island == island) networks.insert(name_of(island, model::parent_key(device->key)));
  }
  for (const auto& name : networks) forget_network(name);
  const auto below = name_of(island, {});
  std::erase_if(groups_, [&below](const auto& one) { return one.first.starts_with(below); });
  std::erase_if(foreign_, [&below](const auto& name) { return name.starts_with(below); });
  const auto found = islands_.find(island);
  callbacks_.island_gone(found->second);
  islands_.erase(found);
}

void House::forget_point(const PointEntry& gone) {
  const auto found = points_.find(Place{gone.device->island, gone.key});
  auto& point = **found;
  auto& device = *point.device;
  callbacks_.point_gone(point);
  device.points.erase(&point);
  recent_ = nullptr;
  points_.erase(found);
  callbacks_.device(device);
}

/// Another device may have taken the topic since: that of an island with the same name.
void House::leave_topic(const DeviceEntry& device) {
  const auto found = by_topic_.find(device.topic);
  if (found != by_topic_.end() && found->second == &device) by_topic_.erase(found);
}

void House::forget_device(const std::string& name) {
  const auto found = devices_.find(name);
  if (found == devices_.end()) return;
  auto& device = *found->second;
  callbacks_.device_gone(device);
  recent_ = nullptr;
  for (const auto* point : std::exchange(device.points, {}))
    points_.erase(points_.find(Place{device.island, point->key}));
  leave_topic(device);
  devices_.erase(found);
}

void House::forget_network(const std::string& name) {
  const auto below = name + ".";
  for (auto at = devices_.lower_bound(below); at != devices_.end() && at->first.starts_with(below);) {
    const auto gone = (at++)->first;
    forget_device(gone);
  }
  groups_.erase(name);
  const auto found = networks_.extract(name);
  if (!found.empty()) callbacks_.network_gone(found.mapped().island, found.mapped().id);
}

}  // namespace rubicon::bridges
