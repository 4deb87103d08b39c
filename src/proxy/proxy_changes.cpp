#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>

#include "proxy/naming.h"
#include "proxy/proxy_impl.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy {

namespace {

/// What the configuration says of the device's keys, as opposed to its name for people.
bool same_keys(const DeviceNames* one, const DeviceNames* other) {
  static const DeviceNames kNone;
  const auto& a = one ? *one : kNone;
  const auto& b = other ? *other : kNone;
  return a.id == b.id && a.sensors == b.sensors && a.actuators == b.actuators;
}

}  // namespace

std::vector<std::string> Proxy::Impl::objections(const ProxyConfig& next) const {
  std::vector<std::string> lines;
  for (const auto& [id, network] : directory.networks()) {
    const auto rules = next.networks.find(id);
    if (rules == next.networks.end()) continue;
    for (const auto& [address, names] : rules->second.devices) {
      const auto device = network->devices.find(address);
      if (device == network->devices.end() || same_keys(names_of(network->rules, address), &names)) continue;
      std::map<std::pair<Kind, std::string>, std::string> taken;
      for (const auto& point : device->second.points) {
        auto part = point_id(&names, *point.details->capability, point.type);
        const auto [other, free] = taken.emplace(std::pair(point.id.kind, part), point.details->id);
        if (free) continue;
        lines.push_back(fmt::format("networks.{}.devices.{}: {} and {} would both become {}", id, address,
                                    other->second, point.details->id, part));
      }
    }
  }
  return lines;
}

/// Of the devices that are there.
std::vector<std::string> Proxy::Impl::lost_names_in(const std::string& id, const NetworkRules& next) const {
  std::vector<std::string> lines;
  const auto network = directory.networks().find(id);
  if (network == directory.networks().end()) return lines;
  for (const auto& [address, names] : next.devices) {
    const auto device = network->second->devices.find(address);
    if (device == network->second->devices.end()) continue;
    for (const auto& lost : proxy::lost_names(names, device->second))
      lines.push_back(fmt::format("networks.{}.devices.{}.{}: {}", id, address, fmt::join(lost.path, "."), lost.text));
  }
  return lines;
}

void Proxy::Impl::warn_of_lost_names(const Device& device) {
  const auto* names = names_of(device.network->rules, device.address);
  if (!names) return;
  for (const auto& lost : proxy::lost_names(*names, device)) {
    const auto path =
        fmt::format("networks.{}.devices.{}.{}", device.network->id, device.address, fmt::join(lost.path, "."));
    context.warn(path, fmt::format("{}: {}", path, lost.text));
  }
}

/// Networks that went, that came, that have other rules; in this order, so that a key part given up can be taken.
void Proxy::Impl::reconfigure(ProxyConfig next) {
  context.clock.refresh();
  next.prefix = config.prefix;
  next.island_name = config.island_name;
  next.host = config.host;
  const auto before = std::exchange(config, std::move(next)).networks;
  bool came_or_went = false;
  for (const auto& [id, rules] : before) {
    if (config.networks.contains(id)) continue;
    came_or_went = true;
    drop_network(id);
  }
  for (const auto& [id, rules] : config.networks) {
    const auto old = before.find(id);
    if (old == before.end()) {
      came_or_went = true;
      auto& network = directory.network(id);
      directory.configure(network, rules);
      board.declare(network);
      roaming.follow();
      restore(id);
    } else if (!(old->second == rules)) {
      change_rules(directory.network(id), rules);
    }
  }
  if (came_or_went) {
    board.networks_changed();
    roaming.follow();
  }
  board.refresh_counters();
  ask_again();
}

void Proxy::Impl::restart(const std::string& id) {
  context.clock.refresh();
  auto& network = directory.network(id);
  drop_devices(network);
  network.line = model::LineState::kConnecting;
  network.line_known = network.down = false;
  network.since = context.clock.now().wall;
  network.reason.clear();
  board.line_changed(network);
  restore(id);
}

void Proxy::Impl::drop_network(const std::string& id) {
  auto& network = directory.network(id);
  drop_devices(network);
  inbox.drop_network(id);
  roaming.drop_network(id);
  std::erase_if(decisions, [&id](const auto& one) { return one.first.network == id; });
  board.remove(network);
  directory.remove_network(id);
}

/// The devices leave the tuple space; what is remembered of them stays.
void Proxy::Impl::drop_devices(Network& network) {
  std::vector<Device*> devices;
  for (auto& [address, device] : network.devices) devices.push_back(&device);
  memory.dropped(devices);
  for (auto* device : devices) remove(*device);
}

void Proxy::Impl::change_rules(Network& network, NetworkRules rules) {
  std::vector<Device*> renamed;
  for (auto& [address, device] : network.devices) {
    if (!same_keys(names_of(network.rules, address), names_of(rules, address))) renamed.push_back(&device);
  }
  const auto old_rate = network.rules.rate;
  change_domain(network, rules.roaming);
  rename(network, std::move(rules), renamed);
  for (auto& [address, device] : network.devices) {
    if (directory.take_name(device)) mirror.described(device);
    if (old_rate != network.rules.rate && device.rate == old_rate) set_rate(device, network.rules.rate);
    liveness.watch(device);
  }
}

void Proxy::Impl::set_rate(Device& device, std::chrono::milliseconds rate) {
  device.rate = rate;
  auto* point = find_point(device, device.rate_point);
  if (point) mirror.own_value(device, *point, static_cast<std::int64_t>(rate.count()), Quality::kGood);
  demand.changed(device);
}

/// Who has a key that the configuration keeps for another device waits until it is free.
void Proxy::Impl::free_reserved_keys(Network& network) {
  for (const auto& [id, address] : network.reserved) {
    const auto found = network.by_id.find(id);
    if (found == network.by_id.end() || found->second->address == address) continue;
    auto& holder = *found->second;
    const auto said = last_said(holder);
    const DeviceName name{network.id, holder.address};
    const auto why =
        fmt::format("{} gave up its key to {}, which the configuration names so", holder.key, model::quoted(address));
    memory.dropped(std::array{&holder});
    remove(holder);
    park(name, said, why);
  }
}

/// All old keys go before the first new one comes, so that two devices may swap theirs.
void Proxy::Impl::rename(Network& network, NetworkRules rules, const std::vector<Device*>& renamed) {
  memory.dropped(renamed);  // one of them may find no key
  std::vector<std::map<PointNumber, TupleMirror::Kept>> kept;
  for (auto* device : renamed) {
    kept.push_back(mirror.retire(*device));
    directory.release(*device);
  }
  directory.configure(network, std::move(rules));
  free_reserved_keys(network);
  for (std::size_t i = 0; i < renamed.size(); ++i) {
    auto& device = *renamed[i];
    const auto vanished = directory.name(device);
    if (!vanished) {
      const auto said = last_said(device);
      const DeviceName name{network.id, device.address};
      roaming.withdrawn(device);
      desk.forget(device);
      demand.forget(device);
      directory.remove(device);
      park(name, said, vanished.error().text);
      continue;
    }
    for (const auto& point : *vanished) desk.forget(device, point.number);
    for (auto& point : device.points) point.wanted = false;  // whoever wants the new keys is told anew
    mirror.renamed(device, kept[i]);
    roaming.listed(device);
    memory.record_changed(device);
    demand.changed(device);
  }
  board.devices_changed(network);
}

/// The discovery rules may say something else now of those who wait; ignored by rule, too.
void Proxy::Impl::ask_again() {
  for (const auto& name : inbox.all()) {
    const auto* entry = inbox.find(name);
    if (!entry) continue;
    auto& network = directory.network(name.network);
    const auto announced = entry->announced;
    if (let_in(network, name, announced, nullptr, false) && inbox.find(name)) try_again(network, name);
  }
}

}  // namespace rubicon::proxy
