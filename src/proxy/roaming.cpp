#include "proxy/roaming.h"

#include <algorithm>

#include "rubicon/key.hpp"

namespace rubicon::proxy {

namespace {

using Presence = RoamingClaims::Presence;

/// So often a device is taken over by a join alone, though the other island hears it.
constexpr unsigned kPatience = 3;
constexpr Duration kForgotten = std::chrono::hours(24);
constexpr std::chrono::microseconds kNext{1};

Claim claim_of(const Device& device, OwnerId self) {
  return {self,           device.key,    model::to_key_part(device.network->id),   device.id,
          device.address, device.joined, device.status == DeviceStatus::kReachable};
}

}  // namespace

Roaming::Roaming(ProxyContext& context, DeviceDirectory& directory, Calls calls)
    : context_(context),
      directory_(directory),
      calls_(std::move(calls)),
      claims_(context, {[this](const Identity& identity) { claimed(identity); },
                        [this](const Identity& identity) { ceased(identity); }}) {}

void Roaming::follow() {
  std::set<std::string> domains;
  for (const auto& [id, network] : directory_.networks()) {
    if (!network->rules.roaming.empty()) domains.insert(network->rules.roaming);
  }
  claims_.follow(domains);
}

WallTime Roaming::stamp(const Network& network, const std::string& address) const {
  const auto now = context_.clock.now().wall;
  if (network.rules.roaming.empty()) return now;
  return std::max(now, claims_.newest(identity_of(network, address)) + kNext);
}

std::vector<Roaming::Holder> Roaming::holders(const Identity& identity, const Network& network) const {
  std::vector<Holder> all;
  claims_.each(identity, [&all](const RoamingClaims::Other& other, Presence presence) {
    if (presence == Presence::kHere || presence == Presence::kBack) all.push_back({other.claim, other.renewed_at});
  });
  const auto own = own_.find(identity);
  auto* device = own == own_.end() ? nullptr : directory_.find(own->second.device);
  if (device && device->network != &network)
    all.push_back({claim_of(*device, context_.space.self()), own->second.renewed_at});
  return all;
}

bool Roaming::holds_back(const Network& network, const std::string& address, const Announced& announced,
                         bool approved) {
  if (network.rules.roaming.empty()) return false;
  const auto all = holders(identity_of(network, address), network);
  if (all.empty()) return false;
  const DeviceName name{network.id, address};
  auto& rover = remember(name, announced);
  rover.trusted |= approved;
  if (!announced.join.heard) return true;
  const bool newer =
      std::all_of(all.begin(), all.end(), [&](const Holder& one) { return announced.joined > one.claim.since; });
  const bool heard_there = std::any_of(all.begin(), all.end(), [](const Holder& one) { return one.claim.reachable; });
  if (context_.clock.now().steady - rover.lost_at >= kForgotten) rover.losses = 0;
  if (newer && !(heard_there && rover.losses >= kPatience)) ask(name, rover, true);
  return true;
}

bool Roaming::trusts(const DeviceName& name) const {
  const auto found = rovers_.find(name);
  return found != rovers_.end() && found->second.trusted;
}

Roaming::Heard Roaming::heard(const Network& network, const std::string& address) {
  if (network.rules.roaming.empty()) return Heard::kUnknown;
  const auto identity = identity_of(network, address);
  const auto all = holders(identity, network);
  bool missed = false;
  claims_.each(identity, [&missed](const auto&, Presence presence) { missed |= presence == Presence::kLost; });
  const auto found = rovers_.find({network.id, address});
  auto* rover = found == rovers_.end() || !found->second.away ? nullptr : &found->second;
  if (rover) {
    rover->announced.heard_at = context_.clock.now().steady;
    rover->announced.join.heard = true;
  }
  if (all.empty() && !missed) return rover ? Heard::kReturns : Heard::kUnknown;
  const bool silent_there = std::none_of(all.begin(), all.end(), [](const Holder& one) { return one.claim.reachable; });
  if (rover && !missed && silent_there) ask(found->first, *rover, false);
  return Heard::kElsewhere;
}

std::optional<Announced> Roaming::take(const DeviceName& name) {
  const auto found = rovers_.find(name);
  if (found == rovers_.end() || !found->second.away) return std::nullopt;
  auto& rover = found->second;
  rover.away = false;
  rover.decision.cancel();
  auto announced = std::exchange(rover.announced, {});
  return announced;
}

Roaming::Rover& Roaming::remember(const DeviceName& name, const Announced& announced) {
  const bool full = rovers_.size() >= context_.config.max_devices && !rovers_.contains(name);
  if (full) rovers_.erase(rovers_.begin());  // that one has to join again
  auto& rover = rovers_[name];
  rover.announced = announced;
  rover.away = true;
  return rover;
}

/// Waits for what the holders say: one that hears the same keeps the device.
void Roaming::ask(const DeviceName& name, Rover& rover, bool by_join) {
  if (rover.decision.pending() && (rover.by_join || !by_join)) return;
  rover.by_join = by_join;
  rover.asked_at = context_.clock.now().steady;
  rover.decision = context_.scheduler.after(kRoamingSettles, [this, name] { decide(name); });
}

void Roaming::decide(const DeviceName& name) {
  context_.clock.refresh();
  const auto found = rovers_.find(name);
  if (found == rovers_.end() || !found->second.away) return;
  auto& rover = found->second;
  const auto& network = directory_.network(name.network);
  const auto all = holders(identity_of(network, name.address), network);
  auto& joined = rover.announced.joined;
  for (const auto& holder : all) {
    if (holder.renewed_at + kRoamingSettles >= rover.asked_at) {
      joined = std::min(joined, std::max(WallTime{}, holder.claim.since - kNext));  // it is the holder's join
      return;
    }
    if (!rover.by_join && holder.claim.reachable) return;
  }
  for (const auto& holder : all) joined = std::max(joined, holder.claim.since + kNext);
  if (!rover.by_join || all.empty()) rover.losses = 0;
  calls_.arrives(name);
}

void Roaming::listed(Device& device) {
  const auto& network = *device.network;
  if (network.rules.roaming.empty()) return;
  const auto rover = rovers_.find({network.id, device.address});
  if (rover != rovers_.end()) {
    rover->second.away = false;
    rover->second.decision.cancel();
    if (rover->second.losses == 0) rovers_.erase(rover);
  }
  const auto identity = identity_of(network, device.address);
  const auto claim = claim_of(device, context_.space.self());
  auto& own = own_[identity];
  const auto before = std::exchange(own.device, device.number);
  if (claim.since != own.since) own.renewed_at = context_.clock.now().steady;
  own.since = claim.since;
  const auto tuple = claims_.publish(identity, claim);
  auto* other = before == device.number ? nullptr : directory_.find(before);
  if (other) give_up(*other, claim, tuple);
}

void Roaming::withdrawn(const Device& device) {
  if (device.network->rules.roaming.empty()) return;
  const auto identity = identity_of(*device.network, device.address);
  const auto own = own_.find(identity);
  if (own == own_.end() || own->second.device != device.number) return;
  own_.erase(own);
  claims_.withdraw(identity);
}

void Roaming::forget(const DeviceName& name) {
  rovers_.erase(name);
}

std::map<DeviceName, Announced> Roaming::drop_network(const std::string& id) {
  std::map<DeviceName, Announced> away;
  for (auto& [name, rover] : rovers_) {
    if (name.network == id && rover.away) away.emplace(name, std::move(rover.announced));
  }
  std::erase_if(rovers_, [&id](const auto& one) { return one.first.network == id; });
  return away;
}

void Roaming::enter_domain(const Network& network) {
  std::vector<DeviceNumber> numbers;
  for (const auto& [address, device] : network.devices) numbers.push_back(device.number);
  for (const auto number : numbers) {
    auto* device = directory_.find(number);
    if (!device) continue;
    listed(*device);
    claimed(identity_of(network, std::string(device->address)));
  }
}

void Roaming::claimed(const Identity& identity) {
  const auto own = own_.find(identity);
  auto* device = own == own_.end() ? nullptr : directory_.find(own->second.device);
  if (!device) return;
  const auto mine = claim_of(*device, context_.space.self());
  std::optional<RoamingClaims::Other> best;
  claims_.each(identity, [&](const RoamingClaims::Other& other, Presence presence) {
    if (presence == Presence::kHere && better(other.claim, best ? best->claim : mine)) best = other;
  });
  if (best) give_up(*device, best->claim, best->tuple);
}

void Roaming::give_up(Device& device, const Claim& to, const std::string& tuple) {
  auto& rover = remember({device.network->id, device.address}, last_said(device));
  rover.trusted = true;
  ++rover.losses;
  rover.lost_at = context_.clock.now().steady;
  calls_.moved(device, to, tuple);
}

/// A join time that had to outbid somebody's wrong clock ends with the dispute.
void Roaming::ceased(const Identity& identity) {
  bool disputed = false;
  claims_.each(identity, [&disputed](const auto&, Presence) { disputed = true; });
  const auto own = own_.find(identity);
  auto* device = own == own_.end() ? nullptr : directory_.find(own->second.device);
  if (device && !disputed) {
    device->joined = std::min(device->joined, context_.clock.now().wall);
    listed(*device);
  }
  if (device) return calls_.alone(*device);
  if (disputed) return;
  for (const auto& [id, network] : directory_.networks()) {
    const auto rover = rovers_.find({id, identity.address});
    if (rover != rovers_.end() && network->rules.roaming == identity.domain) rover->second.losses = 0;
  }
}

Device* Roaming::meant_by(const std::string& tuple, const Identity*& identity) {
  identity = claims_.meant_by(tuple);
  const auto own = identity ? own_.find(*identity) : own_.end();
  return own == own_.end() ? nullptr : directory_.find(own->second.device);
}

}  // namespace rubicon::proxy
