#include <fmt/format.h>

#include "proxy/proxy_impl.h"

namespace rubicon::proxy {

namespace {

bool is_configured(const Network& network, const Announced& announced) {
  return !announced.join.heard || network.rules.lists_devices;
}

}  // namespace

/// Another island, or another network of this one, has the better claim.
void Proxy::Impl::moved(Device& device, const Claim& to, const std::string& tuple) {
  context.log.info(fmt::format("{} moved to {} of island {}", device.key, to.key, number(to.island)));
  demand.stop(device);
  hand_over.send(device, to, tuple);
  memory.left(device);
  remove(device);
}

/// What it announced decides again whether it is let in; nullptr if it cannot come.
Device* Proxy::Impl::arrive(const DeviceName& name) {
  const auto announced = roaming.take(name);
  if (!announced) return nullptr;
  auto& network = directory.network(name.network);
  const auto known = memory.recall(name.network, name.address);
  const auto* remembered = known ? &*known : nullptr;
  if (!let_in(network, name, *announced, remembered, is_configured(network, *announced))) return nullptr;
  if (!admit(network, name.address, *announced, remembered)) return nullptr;
  return directory.find(network, name.address);
}

bool Proxy::Impl::enter(Network& network, const std::string& address, const Announced& announced,
                        const state::KnownDevice* known, bool approved) {
  if (directory.find(network, address) || !roaming.holds_back(network, address, announced, approved))
    return admit(network, address, announced, known);
  inbox.take({network.id, address});
  return false;
}

/// True: it is, or was, with another island; `device` is set if it is back.
bool Proxy::Impl::elsewhere(Network& network, const std::string& address, Device*& device) {
  const auto heard = roaming.heard(network, address);
  if (heard == Roaming::Heard::kUnknown) return false;
  if (heard == Roaming::Heard::kReturns) device = arrive({network.id, address});
  if (!device) {
    ++network.faults.roamed_messages;
    board.refresh_counters();
  }
  return true;
}

/// Its devices leave the old domain and are claimed in the new one, where others may have better claims; those that the
/// old one held back come.
void Proxy::Impl::change_domain(Network& network, const std::string& domain) {
  if (network.rules.roaming == domain) return;
  for (auto& [address, device] : network.devices) roaming.withdrawn(device);
  const auto away = roaming.drop_network(network.id);
  network.rules.roaming = domain;
  roaming.follow();
  roaming.enter_domain(network);
  for (const auto& [name, announced] : away) {
    const auto known = memory.recall(name.network, name.address);
    const auto* remembered = known ? &*known : nullptr;
    if (let_in(network, name, announced, remembered, is_configured(network, announced)))
      enter(network, name.address, announced, remembered);
  }
}

}  // namespace rubicon::proxy
