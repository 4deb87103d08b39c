#include <fmt/format.h>

#include <array>

#include "proxy/naming.h"
#include "proxy/proxy_impl.h"
#include "proxy/reload_checks.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy {

/// First the networks that are removed, then new and changed ones: a key part given up can be taken at once.
void Proxy::Impl::reconfigure(ProxyConfig next) {
  context.clock.refresh();
  next.prefix = config.prefix;
  next.island_name = config.island_name;
  next.host = config.host;
  const auto before = std::exchange(config, std::move(next)).networks;
  bool networks_changed = false;
  for (const auto& [id, rules] : before) {
    if (config.networks.contains(id)) continue;
    networks_changed = true;
    drop_network(id);
  }
  for (const auto& [id, rules] : config.networks) {
    const auto old = before.find(id);
    if (old == before.end()) {
      networks_changed = true;
      auto& network = directory.network(id);
      directory.configure(network, rules);
      network_tuples.declare(network);
      admission.roaming().follow_domains();
      admission.restore(id);
    } else if (!(old->second == rules)) {
      change_rules(directory.network(id), rules);
    }
  }
  if (networks_changed) {
    network_tuples.networks_changed();
    admission.roaming().follow_domains();
  }
  network_tuples.refresh_counters();
  admission.reevaluate_inbox();
}

void Proxy::Impl::restart(const std::string& id) {
  context.clock.refresh();
  auto& network = directory.network(id);
  drop_devices(network);
  network.line = model::LineState::kConnecting;
  network.line_known = network.down = false;
  network.since = context.clock.now().wall;
  network.reason.clear();
  network_tuples.line_changed(network);
  admission.restore(id);
}

void Proxy::Impl::drop_network(const std::string& id) {
  auto& network = directory.network(id);
  drop_devices(network);
  admission.drop_network(id);
  network_tuples.remove(network);
  directory.remove_network(id);
}

/// Removes the devices from the tuple space; the state file keeps what it remembers of them.
void Proxy::Impl::drop_devices(Network& network) {
  std::vector<Device*> devices;
  for (auto& [address, device] : network.devices) devices.push_back(&device);
  memory.save_before_removal(devices);
  for (auto* device : devices) remove(*device);
}

void Proxy::Impl::change_rules(Network& network, NetworkRules rules) {
  std::vector<Device*> renamed;
  for (const auto& [address, device] : network.devices) adopt_names(rules, address, device.announced_name);
  for (auto& [address, device] : network.devices) {
    if (!same_keys(names_of(network.rules, address), names_of(rules, address))) renamed.push_back(&device);
  }
  const auto old_rate = network.rules.rate;
  admission.change_domain(network, rules.roaming);
  rename(network, std::move(rules), renamed);
  for (auto& [address, device] : network.devices) {
    if (directory.update_name(device)) mirror.described(device);
    for (auto& point : device.points) directory.doubt(device, point);
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

/// A device that holds a key which the configuration reserves for another one is deferred until it gets a free key.
void Proxy::Impl::free_reserved_keys(Network& network) {
  for (const auto& [id, address] : network.reserved) {
    const auto found = network.by_id.find(id);
    if (found == network.by_id.end() || found->second->address == address) continue;
    auto& holder = *found->second;
    const auto announced = last_announcement(holder);
    const DeviceName name{network.id, holder.address};
    const auto why = fmt::format("{} gave up its key to {}, for which the configuration reserves it", holder.key,
                                 model::quoted(address));
    memory.save_before_removal(std::array{&holder});
    remove(holder);
    admission.defer(name, announced, why);
  }
}

/// Frees all old keys before it gives the first new one, so that two devices can swap theirs.
void Proxy::Impl::rename(Network& network, NetworkRules rules, const std::vector<Device*>& renamed) {
  memory.save_before_removal(renamed);  // before one of them finds no key
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
      const auto announced = last_announcement(device);
      const DeviceName name{network.id, device.address};
      admission.roaming().withdraw_claim(device);
      desk.forget(device);
      demand.forget(device);
      directory.remove(device);
      admission.defer(name, announced, vanished.error().text);
      continue;
    }
    for (const auto& point : *vanished) desk.forget(device, point.number);
    demand.reset(device);
    mirror.renamed(device, kept[i]);
    admission.roaming().publish_claim(device);
    memory.record_changed(device);
    demand.changed(device);
  }
  network_tuples.devices_changed(network);
}

}  // namespace rubicon::proxy
