#include "proxy/network_tuples.h"

#include <fmt/format.h>

#include <tuple>

#include "model/json_members.h"
#include "model/point_keys.h"
#include "proxy/tuple_text.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy {

namespace {

constexpr tuples::SetOptions kNetworkOptions{"application/json", {}, {}};
constexpr Duration kDevicesPause = std::chrono::milliseconds(250);
/// The list of all devices is long, and published as a whole.
constexpr Duration kAllDevicesPause = std::chrono::seconds(1);
constexpr Duration kCountersPause = std::chrono::seconds(1);
/// Properties that a network may publish; further ones are ignored.
constexpr std::size_t kMaxProperties = 256;

}  // namespace

NetworkTuples::NetworkTuples(ProxyContext& context, DeviceDirectory& directory)
    : context_(context),
      directory_(directory),
      publish_devices_(context.scheduler, kDevicesPause, [this] { publish_devices(); }),
      publish_all_devices_(context.scheduler, kAllDevicesPause, [this] { publish_all_devices(); }),
      publish_counters_(context.scheduler, kCountersPause, [this] { publish_counters(); }) {}

void NetworkTuples::begin() {
  std::string island = fmt::format("{{\"id\":{},\"name\":", number(context_.space.self()));
  model::append_json(context_.config.island_name, island);
  std::ignore = context_.space.set(model::IslandKey{context_.config.prefix}.island(), island + '}', kNetworkOptions);
  publish_networks();
  all_devices_ = "[]";
  if (auto devices =
          context_.space.set(model::IslandKey{context_.config.prefix}.devices(), all_devices_, kNetworkOptions))
    all_devices_tuple_ = *devices;
  for (const auto& [id, network] : directory_.networks()) declare(*network);
}

void NetworkTuples::publish_networks() {
  std::string list = "[";
  for (const auto& [id, network] : directory_.networks()) {
    if (list.size() > 1) list += ',';
    model::append_json(id, list);
  }
  std::ignore = context_.space.set(model::IslandKey{context_.config.prefix}.networks(), list + ']', kNetworkOptions);
}

void NetworkTuples::declare(Network& network) {
  if (network.status_tuple != TupleRef{}) return;
  if (!context_.config.networks.contains(network.id)) publish_networks();
  const auto status =
      context_.space.set(model::NetworkKey{network.key}.status(), network_status_text(network), kNetworkOptions);
  const auto devices = context_.space.set(model::NetworkKey{network.key}.devices(), "[]", kNetworkOptions);
  if (!status || !devices) {
    context_.warn(network.id, fmt::format("cannot publish the tuples of network {}", model::quoted(network.id)));
    return;
  }
  network.status_tuple = *status;
  network.devices_tuple = *devices;
  publish_property(network, "line", std::string(to_string(network.line)));
}

void NetworkTuples::remove(Network& network) {
  std::ignore = context_.space.erase(model::NetworkKey{network.key}.status());
  std::ignore = context_.space.erase(model::NetworkKey{network.key}.devices());
  too_long_.erase(model::NetworkKey{network.key}.devices());
  for (const auto& [name, value] : network.published) {
    std::ignore = context_.space.erase(model::NetworkKey{network.key}.property(name));
  }
}

void NetworkTuples::line_changed(Network& network) {
  std::ignore = context_.space.set(network.status_tuple, network_status_text(network), kNetworkOptions);
  publish_property(network, "line", std::string(to_string(network.line)));
}

void NetworkTuples::publish_property(Network& network, const std::string& name, std::string value) {
  const auto part = model::to_key_part(name);
  if (network.published.size() >= kMaxProperties && !network.published.contains(part)) return;
  auto& published = network.published[part];
  if (published == value) return;
  std::ignore = context_.space.set(model::NetworkKey{network.key}.property(part), value);
  published = std::move(value);
}

void NetworkTuples::devices_changed(Network& network) {
  network.devices_dirty = true;
  list_soon();
}

void NetworkTuples::networks_changed() {
  publish_networks();
  list_soon();
}

void NetworkTuples::list_soon() {
  publish_devices_.request();
  publish_all_devices_.request();
}

void NetworkTuples::publish_devices() {
  context_.clock.refresh();
  for (const auto& [id, network] : directory_.networks()) {
    if (!std::exchange(network->devices_dirty, false)) continue;
    publish_list(network->devices_tuple, model::NetworkKey{network->key}.devices(), reachable_devices(*network));
  }
}

void NetworkTuples::publish_all_devices() {
  context_.clock.refresh();
  std::string list = "[";
  for (const auto& [id, network] : directory_.networks())
    append_reachable(*network, model::to_key_part(id) + '.', list);
  list += ']';
  if (list == all_devices_) return;
  all_devices_ = std::move(list);
  publish_list(all_devices_tuple_, model::IslandKey{context_.config.prefix}.devices(), all_devices_);
}

/// A list that is too long for a value is published as empty, so that an outdated one does not remain.
void NetworkTuples::publish_list(TupleRef tuple, const std::string& key, const std::string& list) {
  if (tuple == TupleRef{}) return;
  const auto set = context_.space.set(tuple, list, kNetworkOptions);
  if (set) {
    too_long_.erase(key);
    return;
  }
  std::ignore = context_.space.set(tuple, "[]", kNetworkOptions);
  if (too_long_.insert(key).second)
    context_.log.warning(fmt::format("{} is published as []: the list is too long: {}", key, set.error().text));
}

void NetworkTuples::refresh_counters() {
  publish_counters_.request();
}

void NetworkTuples::publish_counters() {
  context_.clock.refresh();
  for (const auto& [id, slot] : directory_.networks()) {
    auto& network = *slot;
    for (const auto& [name, text] : network.reported) publish_property(network, name, text);
    const auto queue = context_.gateway.counters(id);
    const auto& faults = network.faults;
    const std::pair<const char*, std::uint64_t> own[] = {
        {"devices", network.devices.size()},         {"dropped-readings", queue.dropped_readings},
        {"refused-busy", queue.refused_busy},        {"undeliverable", queue.undeliverable},
        {"refused-joins", faults.refused_joins},     {"refused-points", faults.refused_points},
        {"unknown-devices", faults.unknown_devices}, {"undeclared-points", faults.undeclared_points},
        {"bad-values", faults.bad_values},           {"implausible-values", faults.implausible_values}};
    for (const auto& [name, count] : own) publish_property(network, name, std::to_string(count));
    if (!network.rules.roaming.empty())
      publish_property(network, "roamed-messages", std::to_string(faults.roamed_messages));
  }
}

}  // namespace rubicon::proxy
