#include "proxy/device_directory.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "proxy/naming.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy {

const Moment& TurnClock::refresh() {
  moment_ = {scheduler_.now(), scheduler_.wall_now()};
  fresh_ = true;
  end_of_turn_.request();
  return moment_;
}

namespace {

constexpr Duration kMaxSilence = std::chrono::hours(24 * 366);

template <class Text>
bool assign(Text& to, const std::string& from) {
  if (to == from) return false;
  to = from;
  return true;
}

/// From the configuration, else from a user, else from the device.
const std::string& name_of(const Device& device) {
  const auto* names = names_of(device.network->rules, device.address);
  if (names && !names->name.empty()) return names->name;
  return device.given_name.empty() ? device.announced_name : device.given_name.text();
}

const std::string& area_of(const Device& device) {
  const auto* names = names_of(device.network->rules, device.address);
  if (names && !names->area.empty()) return names->area;
  return device.given_area.empty() ? device.announced_area.text() : device.given_area.text();
}

}  // namespace

DeviceDirectory::DeviceDirectory(ProxyContext& context) : context_(context), capabilities_(context.types) {
  for (const auto& [id, rules] : context_.config.networks) network(id);
}

Network& DeviceDirectory::network(const std::string& id) {
  if (last_network_ && last_network_->id == id) return *last_network_;
  auto& slot = networks_[id];
  if (!slot) {
    slot = std::make_unique<Network>();
    slot->id = id;
    slot->key = model::IslandKey{context_.config.prefix}.network(model::to_key_part(id)).text;
    slot->since = context_.clock.now().wall;
    const auto rules = context_.config.networks.find(id);
    configure(*slot, rules == context_.config.networks.end() ? NetworkRules{} : rules->second);
  }
  last_network_ = slot.get();
  return *slot;
}

void DeviceDirectory::configure(Network& network, NetworkRules rules) {
  network.rules = std::move(rules);
  if (network.rules.silence) network.rules.silence = std::min(*network.rules.silence, kMaxSilence);
  network.reserved.clear();
  for (const auto& [address, names] : network.rules.devices) {
    network.reserved.emplace(device_id(network.rules, address), address);
  }
}

void DeviceDirectory::adopt_names(Network& network, const std::string& address, const std::string& announced) {
  if (!proxy::adopt_names(network.rules, address, announced)) return;
  network.reserved.insert_or_assign(device_id(network.rules, address), address);
  std::erase_if(network.reserved, [&](const auto& entry) { return entry.second == announced; });
}

void DeviceDirectory::remove_network(const std::string& id) {
  last_network_ = nullptr;
  networks_.erase(id);
}

std::vector<std::string> DeviceDirectory::networks_of(const std::string& address) const {
  std::map<DeviceStatus, std::vector<std::string>> by_status;
  for (const auto& [id, network] : networks_) {
    if (const auto* found = network->devices.find(address)) by_status[found->status].push_back(id);
  }
  for (const auto status : {DeviceStatus::kReachable, DeviceStatus::kUnknown, DeviceStatus::kUnreachable}) {
    if (!by_status[status].empty()) return by_status[status];
  }
  return {};
}

std::string DeviceDirectory::parts_of(const std::string& network, const std::string& address) const {
  const auto found = networks_.find(network);
  if (found == networks_.end()) return {};
  const auto* device = found->second->devices.find(address);
  return device ? device->key.substr(context_.config.prefix.size() + 1) : std::string();
}

Device* DeviceDirectory::find(DeviceNumber number) const {
  auto* device = find_by_place(static_cast<std::uint32_t>(number));
  return device && device->number == number ? device : nullptr;
}

Device* DeviceDirectory::find_by_key(std::string_view parts) {
  const auto key = fmt::format("{}.{}", context_.config.prefix, parts);
  for (const auto& [id, network] : networks_) {
    if (!key.starts_with(network->key + ".")) continue;
    const auto found = network->by_id.find(std::string_view(key).substr(network->key.size() + 1));
    if (found != network->by_id.end()) return *found;
  }
  return nullptr;
}

Result<DeviceDirectory::Joined> DeviceDirectory::join(Network& network, const std::string& address,
                                                      const model::Join& join) {
  Joined joined;
  joined.device = network.devices.find(address);
  if (!joined.device) {
    adopt_names(network, address, join.name);
    auto added = add(network, address, join.id);
    if (!added) {
      ++network.faults.refused_joins;
      return fail(added.error());
    }
    joined.device = *added;
    joined.fresh = true;
  }
  joined.changed = update_identity(*joined.device, join);
  joined.changed |= reconcile(*joined.device, join, joined.vanished);
  joined.changed |= joined.fresh;
  return joined;
}

bool DeviceDirectory::has_place(const Network& network, const std::string& address,
                                const std::string& wanted_id) const {
  return size() < context_.config.max_devices &&
         key_is_free(network, device_id(network.rules, address, wanted_id), address).has_value();
}

Result<void> DeviceDirectory::key_is_free(const Network& network, const std::string& id,
                                          const std::string& address) const {
  const auto kept = network.reserved.find(id);
  const auto holder = network.by_id.find(std::string_view(id));
  const bool reserved = kept != network.reserved.end() && kept->second != address;
  if (!reserved && holder == network.by_id.end()) return {};
  const auto& other = reserved ? kept->second : (*holder)->address;
  return fail(ErrorCode::kDuplicate, fmt::format("join of {} on {}: its key part {} belongs to {}; give it an id",
                                                 model::quoted(address), network.id, id, model::quoted(other)));
}

Result<Device*> DeviceDirectory::add(Network& network, const std::string& address, const std::string& wanted_id) {
  if (size() >= context_.config.max_devices) {
    return fail(ErrorCode::kBusy, fmt::format("join of {} on {}: the limit of {} devices is reached",
                                              model::quoted(address), network.id, context_.config.max_devices));
  }
  auto id = device_id(network.rules, address, wanted_id);
  if (auto free = key_is_free(network, id, address); !free) return fail(std::move(free.error()));
  auto* device = &network.devices.add(address);
  device->number = DeviceNumber{++joined_} << 32 | take_place(*device);
  device->network = &network;
  device->key = model::NetworkKey{network.key}.device(id).text;
  device->id = std::move(id);
  device->wanted_id = wanted_id;
  device->rate = network.rules.rate;
  network.by_id.insert(device);
  return device;
}

std::uint32_t DeviceDirectory::take_place(Device& device) {
  if (free_places_.empty()) {
    places_.push_back(&device);
    return static_cast<std::uint32_t>(places_.size() - 1);
  }
  const auto place = free_places_.back();
  free_places_.pop_back();
  places_[place] = &device;
  return place;
}

bool DeviceDirectory::update_identity(Device& device, const model::Join& join) {
  // A join may leave out what an earlier one announced.
  if (!join.name.empty()) device.announced_name = join.name;
  if (!join.area.empty()) device.announced_area = join.area;
  bool changed = !join.device_type.empty() && assign(device.type, join.device_type);
  changed |= !join.model.empty() && assign(device.model, join.model);
  return update_name(device) || changed;
}

bool DeviceDirectory::update_name(Device& device) {
  const bool named = assign(device.name, name_of(device));
  return assign(device.area, area_of(device)) || named;
}

bool DeviceDirectory::reconcile(Device& device, const model::Join& join, std::vector<Point>& vanished) {
  bool changed = false;
  std::vector<Point> points;
  points.reserve(std::min(join.capabilities.size(), kMaxPoints));
  std::set<std::pair<Kind, std::string_view>> taken;
  for (const auto& capability : join.capabilities) {
    auto* known = find_point(device, capability.point);
    if (known && known->details) {
      changed |= !(*known->details->capability == capability) || !known->storage.declared;
      const auto id = known->details->id();  // its keys stay, whatever the new capability would be called
      known->details->capability = capabilities_.of(capability);
      known->details->name(id);
      known->type = known->details->capability->type;
      doubt(device, *known);
      known->storage.declared = true;
      taken.emplace(known->id.kind, known->details->id());
      points.push_back(std::move(*known));
      continue;
    }
    auto made = make_point(device, capability);
    if (made && points.size() >= kMaxPoints) {
      made = fail(ErrorCode::kBusy, fmt::format("a device may have {} points", kMaxPoints));
    } else if (made && !taken.emplace(made->id.kind, made->details->id()).second) {
      made = fail(ErrorCode::kDuplicate, fmt::format("{} is there twice", made->details->id()));
    }
    if (!made) {
      ++device.network->faults.refused_points;
      context_.warn(device.key, fmt::format("{}: point refused: {}", device.key, made.error().text));
      continue;
    }
    points.push_back(std::move(*made));
    changed = true;
  }
  for (auto& point : device.points) {
    if (!point.details) continue;
    const bool stays = !point.storage.declared && taken.emplace(point.id.kind, point.details->id()).second;
    (stays ? points : vanished).push_back(std::move(point));
  }
  device.points = std::move(points);
  return changed || !vanished.empty();
}

Result<Point> DeviceDirectory::make_point(Device& device, const Capability& capability) {
  Point point;
  point.id = capability.point;
  point.details = std::make_unique<PointDetails>();
  point.details->capability = capabilities_.of(capability);
  point.type = point.details->capability->type;
  point.details->name(point_id(names_of(device.network->rules, device.address), capability, point.type));
  point.since = context_.clock.now().wall;
  const auto longest_key = point_key(device, point).description();
  if (longest_key.size() > model::kMaxKeyLength) {
    return fail(ErrorCode::kOutOfRange, fmt::format("key {} is too long", model::quoted(longest_key)));
  }
  doubt(device, point);
  point.number = ++device.last_point;
  return point;
}

void DeviceDirectory::doubt(const Device& device, Point& point) {
  auto& known = point.details->plausibility;
  auto rules = rules_of(device.network->rules, device.address, *point.details->capability);
  point.mirror.doubted = rules.has_value();
  if (!rules) return known.reset();
  if (!known || !(known->rules() == *rules)) known = std::make_unique<Plausibility>(rules_.of(std::move(*rules)));
}

Point* DeviceDirectory::add_undeclared(Device& device, const PointId& id) {
  const bool possible =
      id.kind == Kind::kSensor && context_.types.find(id.type) != nullptr && device.points.size() < kMaxPoints;
  if (!possible) return nullptr;
  Capability capability;
  capability.point = id;
  auto made = make_point(device, capability);
  const bool taken = made && std::any_of(device.points.begin(), device.points.end(), [&](const Point& point) {
                       return point.id.kind == id.kind && point.details->id() == made->details->id();
                     });
  if (!made || taken) return nullptr;
  made->storage.declared = false;
  device.points.push_back(std::move(*made));
  return &device.points.back();
}

void DeviceDirectory::remove(Device& device) {
  auto& network = *device.network;
  const auto place = static_cast<std::uint32_t>(device.number);
  places_[place] = nullptr;
  free_places_.push_back(place);
  const auto named = network.by_id.find(&device);
  if (named != network.by_id.end() && *named == &device) network.by_id.erase(named);
  network.devices.remove(device);
}

void DeviceDirectory::release(Device& device) {
  device.network->by_id.erase(&device);
}

Result<std::vector<Point>> DeviceDirectory::name(Device& device) {
  auto& network = *device.network;
  auto id = device_id(network.rules, device.address, device.wanted_id.text());
  if (auto free = key_is_free(network, id, device.address); !free) return fail(std::move(free.error()));
  device.id = std::move(id);
  device.key = model::NetworkKey{network.key}.device(device.id).text;
  network.by_id.insert(&device);
  const auto* names = names_of(network.rules, device.address);
  std::vector<Point> vanished, points;
  points.reserve(device.points.size());
  std::set<std::pair<Kind, std::string>> taken;
  for (auto& point : device.points) {
    point.details->name(point_id(names, *point.details->capability, point.type));
    const bool free = taken.emplace(point.id.kind, point.details->id()).second;
    (free ? points : vanished).push_back(std::move(point));
  }
  device.points = std::move(points);
  network.faults.refused_points += vanished.size();
  return vanished;
}

}  // namespace rubicon::proxy
