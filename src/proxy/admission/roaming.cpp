#include "proxy/admission/roaming.h"

#include <algorithm>
#include <set>

#include "rubicon/key.hpp"

namespace rubicon::proxy::admission {

namespace {

using Presence = RoamingClaims::Presence;

/// Consecutive takeovers by join alone while the other claimant still hears the device; more need a silent claimant.
constexpr unsigned kMaxTakeovers = 3;
/// After this time without a takeover they are counted from zero.
constexpr Duration kTakeoversForgotten = std::chrono::hours(24);
/// The smallest difference between two join times.
constexpr std::chrono::microseconds kTick{1};

Claim claim_of(const Device& device, OwnerId self) {
  return {self,           device.key,    model::to_key_part(device.network->id),   device.id,
          device.address, device.joined, device.status == DeviceStatus::kReachable};
}

}  // namespace

Roaming::Roaming(ProxyContext& context, DeviceDirectory& directory, Callbacks callbacks)
    : context_(context),
      directory_(directory),
      callbacks_(std::move(callbacks)),
      claims_(context, {[this](const Identity& identity) { on_claimed(identity); },
                        [this](const Identity& identity) { on_unclaimed(identity); }}) {}

void Roaming::follow_domains() {
  std::set<std::string> domains;
  for (const auto& [id, network] : directory_.networks()) {
    if (!network->rules.roaming.empty()) domains.insert(network->rules.roaming);
  }
  claims_.follow(domains);
}

WallTime Roaming::join_time(const Network& network, const std::string& address) const {
  const auto now = context_.clock.now().wall;
  if (network.rules.roaming.empty()) return now;
  return std::max(now, claims_.newest(identity_of(network, address)) + kTick);
}

Device* Roaming::own_device(const Identity& identity) {
  const auto own = own_.find(identity);
  return own == own_.end() ? nullptr : directory_.find(own->second.device);
}

std::vector<Roaming::Claimant> Roaming::claimants(const Identity& identity, const Network& network) const {
  std::vector<Claimant> all;
  claims_.each(identity, [&all](const RoamingClaims::Other& other, Presence presence) {
    if (presence == Presence::kHere || presence == Presence::kBack) all.push_back({other.claim, other.renewed_at});
  });
  const auto own = own_.find(identity);
  const auto* device = own == own_.end() ? nullptr : directory_.find(own->second.device);
  if (device && device->network != &network)
    all.push_back({claim_of(*device, context_.space.self()), own->second.renewed_at});
  return all;
}

bool Roaming::defers(const Network& network, const std::string& address, const Announced& announced, bool approved) {
  if (network.rules.roaming.empty()) return false;
  const auto all = claimants(identity_of(network, address), network);
  if (all.empty()) return false;
  const DeviceName name{network.id, address};
  auto& away = remember(name, announced);
  away.trusted |= approved;
  if (!announced.join.heard) return true;
  const bool newer =
      std::all_of(all.begin(), all.end(), [&](const Claimant& one) { return announced.joined > one.claim.since; });
  const bool heard_there = std::any_of(all.begin(), all.end(), [](const Claimant& one) { return one.claim.reachable; });
  if (context_.clock.now().steady - away.lost_at >= kTakeoversForgotten) away.takeovers = 0;
  if (newer && !(heard_there && away.takeovers >= kMaxTakeovers)) schedule_decision(name, away, true);
  return true;
}

bool Roaming::trusts(const DeviceName& name) const {
  const auto found = away_.find(name);
  return found != away_.end() && found->second.trusted;
}

Roaming::Whereabouts Roaming::on_message(const Network& network, const std::string& address) {
  if (network.rules.roaming.empty()) return Whereabouts::kUnknown;
  const auto identity = identity_of(network, address);
  const auto all = claimants(identity, network);
  bool lost_claimant = false;
  claims_.each(identity,
               [&lost_claimant](const auto&, Presence presence) { lost_claimant |= presence == Presence::kLost; });
  const auto found = away_.find({network.id, address});
  auto* away = found == away_.end() || !found->second.is_away ? nullptr : &found->second;
  if (away) {
    away->announced.heard_at = context_.clock.now().steady;
    away->announced.join.heard = true;
  }
  if (all.empty() && !lost_claimant) return away ? Whereabouts::kReturned : Whereabouts::kUnknown;
  const bool silent_there =
      std::none_of(all.begin(), all.end(), [](const Claimant& one) { return one.claim.reachable; });
  if (away && !lost_claimant && silent_there) schedule_decision(found->first, *away, false);
  return Whereabouts::kElsewhere;
}

std::optional<Announced> Roaming::take(const DeviceName& name) {
  const auto found = away_.find(name);
  if (found == away_.end() || !found->second.is_away) return std::nullopt;
  auto& away = found->second;
  away.is_away = false;
  away.decision.cancel();
  auto announced = std::exchange(away.announced, {});
  return announced;
}

Roaming::AwayDevice& Roaming::remember(const DeviceName& name, const Announced& announced) {
  const bool full = away_.size() >= context_.config.max_devices && !away_.contains(name);
  if (full) away_.erase(away_.begin());  // that device has to join again
  auto& away = away_[name];
  away.announced = announced;
  away.is_away = true;
  return away;
}

/// Waits until the other claimants had time to renew their claims: one that heard the same join keeps the device.
void Roaming::schedule_decision(const DeviceName& name, AwayDevice& away, bool by_join) {
  if (away.decision.pending() && (away.by_join || !by_join)) return;
  away.by_join = by_join;
  away.asked_at = context_.clock.now().steady;
  away.decision = context_.scheduler.after(kRoamingSettles, [this, name] { decide(name); });
}

void Roaming::decide(const DeviceName& name) {
  context_.clock.refresh();
  const auto found = away_.find(name);
  if (found == away_.end() || !found->second.is_away) return;
  auto& away = found->second;
  const auto& network = directory_.network(name.network);
  const auto all = claimants(identity_of(network, name.address), network);
  auto& joined = away.announced.joined;
  for (const auto& claimant : all) {
    if (claimant.renewed_at + kRoamingSettles >= away.asked_at) {
      joined = std::min(joined, std::max(WallTime{}, claimant.claim.since - kTick));  // the claimant heard this join
      return;
    }
    if (!away.by_join && claimant.claim.reachable) return;
  }
  for (const auto& claimant : all) joined = std::max(joined, claimant.claim.since + kTick);
  if (!away.by_join || all.empty()) away.takeovers = 0;
  callbacks_.arrived(name);
}

void Roaming::publish_claim(Device& device) {
  const auto& network = *device.network;
  if (network.rules.roaming.empty()) return;
  const auto away = away_.find({network.id, device.address});
  if (away != away_.end()) {
    away->second.is_away = false;
    away->second.decision.cancel();
    if (away->second.takeovers == 0) away_.erase(away);
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

void Roaming::withdraw_claim(const Device& device) {
  if (device.network->rules.roaming.empty()) return;
  const auto identity = identity_of(*device.network, device.address);
  const auto own = own_.find(identity);
  if (own == own_.end() || own->second.device != device.number) return;
  own_.erase(own);
  claims_.withdraw(identity);
}

void Roaming::forget(const DeviceName& name) {
  away_.erase(name);
}

std::map<DeviceName, Announced> Roaming::drop_network(const std::string& id) {
  std::map<DeviceName, Announced> dropped;
  for (auto& [name, away] : away_) {
    if (name.network == id && away.is_away) dropped.emplace(name, std::move(away.announced));
  }
  std::erase_if(away_, [&id](const auto& one) { return one.first.network == id; });
  return dropped;
}

void Roaming::enter_domain(const Network& network) {
  std::vector<DeviceNumber> numbers;
  for (const auto& device : network.devices.all()) numbers.push_back(device->number);
  for (const auto number : numbers) {
    auto* device = directory_.find(number);
    if (!device) continue;
    publish_claim(*device);
    on_claimed(identity_of(network, std::string(device->address)));
  }
}

void Roaming::on_claimed(const Identity& identity) {
  auto* device = own_device(identity);
  if (!device) return;
  const auto mine = claim_of(*device, context_.space.self());
  std::optional<RoamingClaims::Other> best;
  claims_.each(identity, [&](const RoamingClaims::Other& other, Presence presence) {
    if (presence == Presence::kHere && better(other.claim, best ? best->claim : mine)) best = other;
  });
  if (!best) return;
  claims_.record(best->claim.island, best->tuple, {});
  give_up(*device, best->claim, best->tuple);
}

void Roaming::give_up(Device& device, const Claim& to, const std::string& tuple) {
  auto& away = remember({device.network->id, device.address}, last_announcement(device));
  away.trusted = true;
  ++away.takeovers;
  away.lost_at = context_.clock.now().steady;
  callbacks_.moved(device, to, tuple);
}

/// A join time that was moved ahead to outbid a wrong clock returns to our own time when the dispute is over.
void Roaming::on_unclaimed(const Identity& identity) {
  bool disputed = false;
  claims_.each(identity, [&disputed](const auto&, Presence) { disputed = true; });
  auto* device = own_device(identity);
  if (device && !disputed) {
    device->joined = std::min(device->joined, context_.clock.now().wall);
    publish_claim(*device);
  }
  if (device) return callbacks_.unclaimed(*device);
  if (disputed) return;
  for (const auto& [id, network] : directory_.networks()) {
    const auto away = away_.find({id, identity.address});
    if (away != away_.end() && network->rules.roaming == identity.domain) away->second.takeovers = 0;
  }
}

Device* Roaming::device_of_claim(const std::string& tuple, const Identity*& identity) {
  identity = claims_.identity_of_own(tuple);
  return identity ? own_device(*identity) : nullptr;
}

}  // namespace rubicon::proxy::admission
