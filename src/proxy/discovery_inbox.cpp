#include "proxy/discovery_inbox.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <tuple>

#include "base/glob.h"
#include "model/json_members.h"
#include "proxy/naming.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy {

namespace {

using Tree = nlohmann::ordered_json;

constexpr tuples::SetOptions kJson{"application/json", {}, {}};
constexpr Duration kPause = std::chrono::milliseconds(250);
/// Devices listed in `proxy.inbox`; its count says how many there are.
constexpr std::size_t kListed = 100;

bool fits(const std::string& pattern, std::string_view text) {
  return pattern.empty() || base::glob_matches(pattern, text);
}

Tree describe(const DeviceName& device, const DiscoveryInbox::Entry& entry, const TypeCatalogue& types) {
  const auto& join = entry.announced.join;
  Tree tree{{"key", entry.key},  {"network", device.network}, {"address", device.address},
            {"name", join.name}, {"model", join.model},       {"type", join.device_type}};
  Tree lists[3] = {Tree::array(), Tree::array(), Tree::array()};
  for (const auto& capability : join.capabilities) {
    lists[static_cast<std::size_t>(capability.point.kind)].push_back(
        point_id(nullptr, capability, types.find(capability.point.type)));
  }
  tree["sensors"] = std::move(lists[0]);
  tree["actuators"] = std::move(lists[1]);
  tree["properties"] = std::move(lists[2]);
  tree["since"] = base::to_seconds(entry.since);
  tree["why"] = entry.why;
  return tree;
}

}  // namespace

std::string_view to_string(Admission admission) {
  switch (admission) {
    case Admission::kAuto: return "auto";
    case Admission::kAsk: return "ask";
    case Admission::kIgnore: return "ignore";
  }
  return "auto";
}

bool says_the_same(const model::Join& one, const model::Join& other) {
  return one.name == other.name && one.model == other.model && one.device_type == other.device_type &&
         one.capabilities == other.capabilities;
}

std::string key_of(const DeviceName& device) {
  return fmt::format("{}.{}", model::to_key_part(device.network), model::to_key_part(device.address));
}

DiscoveryInbox::DiscoveryInbox(ProxyContext& context) : context_(context) {}

void DiscoveryInbox::begin() {
  publish();
}

std::pair<Admission, std::string> DiscoveryInbox::admission(const DeviceName& device, const model::Join& join) const {
  const auto& discovery = context_.config.discovery;
  for (std::size_t i = 0; i < discovery.rules.size(); ++i) {
    const auto& rule = discovery.rules[i];
    if (!fits(rule.network, device.network) || !fits(rule.type, join.device_type) ||
        !fits(rule.address, device.address))
      continue;
    return {rule.admission, fmt::format("discovery.rules[{}] says {}", i, to_string(rule.admission))};
  }
  return {discovery.otherwise, fmt::format("discovery.new-devices is {}", to_string(discovery.otherwise))};
}

/// Devices that only a rule hides make room for those that somebody has to see.
bool DiscoveryInbox::make_room(Standing standing) {
  if (entries_.size() < context_.config.max_devices) return true;
  if (standing == Standing::kIgnoredByRule || by_rule_.empty()) return false;
  take(DeviceName(*by_rule_.begin()));
  return true;
}

DiscoveryInbox::Entry* DiscoveryInbox::enter(const DeviceName& device, Standing standing) {
  const auto found = entries_.find(device);
  if (found != entries_.end()) {
    count(found->second, false);
    return &found->second;
  }
  if (!make_room(standing)) {
    ++counters_.refused;
    context_.warn("inbox", fmt::format("{} is not in the inbox: the limit of {} devices is reached", key_of(device),
                                       context_.config.max_devices));
    return nullptr;
  }
  auto& entry = entries_[device];
  entry.since = context_.clock.now().wall;
  return &entry;
}

void DiscoveryInbox::count(const Entry& entry, bool comes) {
  auto& counter = entry.ignored() ? counters_.ignored : counters_.waiting;
  comes ? ++counter : --counter;
}

DiscoveryInbox::Put DiscoveryInbox::put(const DeviceName& device, const Announced& announced, Standing standing,
                                        std::string why) {
  auto* entry = enter(device, standing);
  if (!entry) return Put::kNoRoom;
  const bool same =
      entry->standing == standing && entry->why == why && says_the_same(entry->announced.join, announced.join);
  const bool shown = !entry->key.empty();
  entry->announced = announced;
  entry->standing = standing;
  entry->why = std::move(why);
  count(*entry, true);
  standing == Standing::kIgnoredByRule ? void(by_rule_.insert(device)) : void(by_rule_.erase(device));
  if (entry->ignored()) hide(*entry);
  if (!entry->ignored() && !(same && shown)) show(device, *entry);
  if (!same || shown == entry->key.empty()) changed();
  return same ? Put::kSame : Put::kNews;
}

void DiscoveryInbox::show(const DeviceName& device, Entry& entry) {
  if (entry.key.empty()) {
    const auto part = key_of(device);
    entry.key = part;
    for (int twin = 2; !keys_.emplace(entry.key, device).second; ++twin) entry.key = fmt::format("{}_{}", part, twin);
  }
  const auto key = fmt::format("{}.inbox.{}", context_.config.prefix, entry.key);
  const auto shown = context_.space.set(key, model::dump(describe(device, entry, context_.types)), kJson);
  if (!shown) context_.warn("inbox", shown.error().text);
}

void DiscoveryInbox::hide(Entry& entry) {
  if (entry.key.empty()) return;
  std::ignore = context_.space.erase(fmt::format("{}.inbox.{}", context_.config.prefix, entry.key));
  keys_.erase(entry.key);
  entry.key.clear();
}

bool DiscoveryInbox::heard(const DeviceName& device) {
  const auto found = entries_.find(device);
  if (found == entries_.end()) return false;
  ++counters_.unheard;
  found->second.announced.heard_at = context_.clock.now().steady;
  found->second.announced.join.heard = true;
  return true;
}

const DiscoveryInbox::Entry* DiscoveryInbox::find(const DeviceName& device) const {
  const auto found = entries_.find(device);
  return found == entries_.end() ? nullptr : &found->second;
}

std::optional<DiscoveryInbox::Entry> DiscoveryInbox::take(const DeviceName& device) {
  const auto found = entries_.find(device);
  if (found == entries_.end()) return std::nullopt;
  count(found->second, false);
  hide(found->second);
  by_rule_.erase(device);
  auto entry = std::move(found->second);
  entries_.erase(found);
  changed();
  return entry;
}

void DiscoveryInbox::drop_network(const std::string& network) {
  for (auto at = entries_.lower_bound({network, {}}); at != entries_.end() && at->first.network == network;) {
    const auto device = (at++)->first;
    take(device);
  }
}

std::vector<DeviceName> DiscoveryInbox::all() const {
  std::vector<DeviceName> found;
  for (const auto& [device, entry] : entries_) found.push_back(device);
  return found;
}

std::vector<DeviceName> DiscoveryInbox::waiting_like(const std::string& pattern) const {
  std::vector<DeviceName> found;
  for (const auto& [device, entry] : entries_) {
    if (pattern == fmt::format("{}.{}", device.network, device.address)) return {device};
    if (!entry.ignored() && base::glob_matches(pattern, entry.key)) found.push_back(device);
  }
  return found;
}

std::vector<DeviceName> DiscoveryInbox::meant_by(const std::string& key) const {
  if (const auto shown = keys_.find(key); shown != keys_.end()) return {shown->second};
  std::vector<DeviceName> found;
  for (const auto& [device, entry] : entries_) {
    if (!entry.ignored()) continue;
    const auto rules = context_.config.networks.find(device.network);
    const auto part = rules == context_.config.networks.end()
                          ? std::string()
                          : device_id(rules->second, device.address, entry.announced.join.id);
    if (key == key_of(device) || key == fmt::format("{}.{}", model::to_key_part(device.network), part))
      found.push_back(device);
  }
  return found;
}

void DiscoveryInbox::changed() {
  if (timer_.pending()) return;
  timer_ = context_.scheduler.at(std::max(publish_at_, context_.clock.now().steady), [this] { publish(); });
}

void DiscoveryInbox::publish() {
  publish_at_ = context_.clock.refresh().steady + kPause;
  Tree list = Tree::array();
  for (const auto& [device, entry] : entries_) {
    if (list.size() >= kListed) break;
    if (!entry.ignored()) list.push_back(describe(device, entry, context_.types));
  }
  const Tree all{{"count", counters_.waiting}, {"ignored", counters_.ignored}, {"waiting", std::move(list)}};
  std::ignore = context_.space.set(context_.config.prefix + ".inbox", model::dump(all), kJson);
}

}  // namespace rubicon::proxy
