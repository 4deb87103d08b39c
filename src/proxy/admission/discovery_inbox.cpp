#include "proxy/admission/discovery_inbox.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "base/compare_text.h"
#include "model/json_members.h"
#include "proxy/memory.h"
#include "proxy/naming.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy::admission {

Announced last_announcement(const Device& device) {
  Announced announced{announcement(device), device.heard_at, device.joined};
  announced.join.heard = device.status != DeviceStatus::kUnknown;
  return announced;
}

bool same_announcement(const model::Join& one, const model::Join& other) {
  return one.name == other.name && one.model == other.model && one.device_type == other.device_type &&
         one.capabilities == other.capabilities;
}

std::string key_of(const DeviceName& device) {
  return fmt::format("{}.{}", model::to_key_part(device.network), model::to_key_part(device.address));
}

namespace {

using Tree = nlohmann::ordered_json;

constexpr tuples::SetOptions kInboxOptions{"application/json", {}, {}};
/// Between two publications of `proxy.inbox`.
constexpr Duration kInboxPause = std::chrono::milliseconds(250);
/// Devices listed in `proxy.inbox`; its `count` counts all.
constexpr std::size_t kMaxListed = 100;
/// The same of `proxy.inbox.ignored`, a list that few read.
constexpr Duration kIgnoredPause = std::chrono::seconds(1);
constexpr std::size_t kMaxIgnoredListed = 1000;

Tree describe_ignored(const DeviceName& device, const DiscoveryInbox::Entry& entry, std::string key) {
  const auto& join = entry.announced.join;
  return {{"key", std::move(key)},
          {"network", device.network},
          {"address", device.address},
          {"name", join.name},
          {"model", join.model},
          {"type", join.device_type},
          {"since", base::to_seconds(entry.since)},
          {"by", entry.state == InboxState::kIgnoredByUser ? "user" : "rule"},
          {"why", entry.why}};
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

DiscoveryInbox::DiscoveryInbox(ProxyContext& context)
    : context_(context),
      publish_soon_(context.scheduler, kInboxPause, [this] { publish(); }),
      publish_ignored_soon_(context.scheduler, kIgnoredPause, [this] { publish_ignored(); }) {}

/// Devices that are ignored by a rule make room for those that need a decision.
bool DiscoveryInbox::make_room(InboxState state) {
  if (entries_.size() < context_.config.max_devices) return true;
  if (state == InboxState::kIgnoredByRule || by_rule_.empty()) return false;
  take(DeviceName(*by_rule_.begin()));
  return true;
}

DiscoveryInbox::Entry* DiscoveryInbox::find_or_add(const DeviceName& device, InboxState state) {
  const auto found = entries_.find(device);
  if (found != entries_.end()) {
    count(found->second, false);
    return &found->second;
  }
  if (!make_room(state)) {
    ++counters_.refused;
    context_.warn("inbox", fmt::format("{} is not in the inbox: the limit of {} devices is reached", key_of(device),
                                       context_.config.max_devices));
    return nullptr;
  }
  auto& entry = entries_[device];
  entry.since = context_.clock.now().wall;
  return &entry;
}

void DiscoveryInbox::count(const Entry& entry, bool added) {
  auto& counter = entry.ignored() ? counters_.ignored : counters_.pending;
  added ? ++counter : --counter;
}

DiscoveryInbox::Put DiscoveryInbox::put(const DeviceName& device, const Announced& announced, InboxState state,
                                        std::string why) {
  auto* entry = find_or_add(device, state);
  if (!entry) return Put::kNoRoom;
  const bool same =
      entry->state == state && entry->why == why && same_announcement(entry->announced.join, announced.join);
  const bool shown = !entry->key.empty();
  const bool was_ignored = entry->ignored();
  entry->announced = announced;
  entry->state = state;
  entry->why = std::move(why);
  count(*entry, true);
  state == InboxState::kIgnoredByRule ? void(by_rule_.insert(device)) : void(by_rule_.erase(device));
  index_hidden(device, *entry);
  if (entry->ignored()) hide(*entry);
  if (!entry->ignored() && !(same && shown)) show(device, *entry);
  if (!same || shown == entry->key.empty()) publish_soon_.request();
  if (was_ignored || entry->ignored()) publish_ignored_soon_.request();
  return same ? Put::kSame : Put::kNew;
}

void DiscoveryInbox::show(const DeviceName& device, Entry& entry) {
  if (entry.key.empty()) {
    const auto part = key_of(device);
    entry.key = part;
    for (int twin = 2; !keys_.emplace(entry.key, device).second; ++twin) entry.key = fmt::format("{}_{}", part, twin);
  }
  const auto key = model::IslandKey{context_.config.prefix}.inbox(entry.key);
  const auto shown = context_.space.set(key, model::dump(describe(device, entry, context_.types)), kInboxOptions);
  if (!shown) context_.warn("inbox", shown.error().text);
}

void DiscoveryInbox::hide(Entry& entry) {
  if (entry.key.empty()) return;
  std::ignore = context_.space.erase(model::IslandKey{context_.config.prefix}.inbox(entry.key));
  keys_.erase(entry.key);
  entry.key.clear();
}

bool DiscoveryInbox::note_message(const DeviceName& device) {
  const auto found = entries_.find(device);
  if (found == entries_.end()) return false;
  ++counters_.discarded;
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
  drop_hidden_keys(device, found->second);
  auto entry = std::move(found->second);
  entries_.erase(found);
  publish_soon_.request();
  if (entry.ignored()) publish_ignored_soon_.request();
  return entry;
}

void DiscoveryInbox::drop_network(const std::string& network) {
  for (auto at = entries_.lower_bound({network, {}}); at != entries_.end() && at->first.network == network;) {
    const auto device = (at++)->first;
    take(device);
  }
}

std::vector<DeviceName> DiscoveryInbox::devices() const {
  std::vector<DeviceName> found;
  for (const auto& [device, entry] : entries_) found.push_back(device);
  return found;
}

/// `<network>.<address>`; both may contain dots.
const DeviceName* DiscoveryInbox::with_address(const std::string& text) const {
  for (auto dot = text.find('.'); dot != text.npos; dot = text.find('.', dot + 1)) {
    const auto found = entries_.find({text.substr(0, dot), text.substr(dot + 1)});
    if (found != entries_.end()) return &found->first;
  }
  return nullptr;
}

/// Users see keys: another device may have the text of a key as its address.
std::vector<DeviceName> DiscoveryInbox::matching(const std::string& pattern) const {
  if (const auto shown = keys_.find(pattern); shown != keys_.end()) return {shown->second};
  if (const auto* device = with_address(pattern)) return {*device};
  const auto wildcard = pattern.find_first_of("*?");
  if (wildcard == pattern.npos) return {};
  const auto beginning = pattern.substr(0, wildcard);
  std::vector<DeviceName> found;
  for (auto at = keys_.lower_bound(beginning); at != keys_.end() && at->first.starts_with(beginning); ++at) {
    if (base::glob_matches(pattern, at->first)) found.push_back(at->second);
  }
  return found;
}

std::vector<DeviceName> DiscoveryInbox::with_key(const std::string& key) const {
  if (const auto shown = keys_.find(key); shown != keys_.end()) return {shown->second};
  std::vector<DeviceName> found;
  for (auto at = hidden_keys_.lower_bound({key, {}}); at != hidden_keys_.end() && at->first == key; ++at)
    found.push_back(at->second);
  return found;
}

/// The ids of the configuration are those in force: a reload puts each entry again.
void DiscoveryInbox::index_hidden(const DeviceName& device, Entry& entry) {
  drop_hidden_keys(device, entry);
  if (!entry.ignored()) return;
  entry.hidden_key = key_with_id(device, entry);
  hidden_keys_.emplace(key_of(device), device);
  hidden_keys_.emplace(entry.hidden_key, device);
}

void DiscoveryInbox::drop_hidden_keys(const DeviceName& device, Entry& entry) {
  if (entry.hidden_key.empty()) return;
  hidden_keys_.erase({key_of(device), device});
  hidden_keys_.erase({std::exchange(entry.hidden_key, {}), device});
}

/// The key that the device would have with its configured id or that of its Join.
std::string DiscoveryInbox::key_with_id(const DeviceName& device, const Entry& entry) const {
  const auto rules = context_.config.networks.find(device.network);
  if (rules == context_.config.networks.end()) return key_of(device);
  const auto part = device_id(rules->second, device.address, entry.announced.join.id);
  return fmt::format("{}.{}", model::to_key_part(device.network), part);
}

void DiscoveryInbox::publish() {
  context_.clock.refresh();
  Tree list = Tree::array();
  for (const auto& [device, entry] : entries_) {
    if (list.size() >= kMaxListed) break;
    if (!entry.ignored()) list.push_back(describe(device, entry, context_.types));
  }
  const Tree all{{"count", counters_.pending}, {"ignored", counters_.ignored}, {"waiting", std::move(list)}};
  std::ignore = context_.space.set(model::IslandKey{context_.config.prefix}.inbox(), model::dump(all), kInboxOptions);
}

void DiscoveryInbox::publish_ignored() {
  Tree list = Tree::array();
  for (const auto& [device, entry] : entries_) {
    if (list.size() >= kMaxIgnoredListed) break;
    if (entry.ignored()) list.push_back(describe_ignored(device, entry, entry.hidden_key));
  }
  auto text = model::dump(Tree{{"count", counters_.ignored}, {"devices", std::move(list)}});
  if (text == shown_ignored_) return;
  shown_ignored_ = std::move(text);
  std::ignore =
      context_.space.set(model::IslandKey{context_.config.prefix}.inbox("ignored"), shown_ignored_, kInboxOptions);
}

namespace {

bool fits(const std::string& pattern, std::string_view text) {
  return pattern.empty() || base::glob_matches(pattern, text);
}

}  // namespace

RuleResult apply_rules(const DiscoveryRules& discovery, const DeviceName& device, const model::Join& join) {
  for (std::size_t i = 0; i < discovery.rules.size(); ++i) {
    const auto& rule = discovery.rules[i];
    if (!fits(rule.network, device.network) || !fits(rule.type, join.device_type) ||
        !fits(rule.address, device.address))
      continue;
    return {rule.action, fmt::format("discovery.rules[{}] says {}", i, to_string(rule.action))};
  }
  return {discovery.otherwise, fmt::format("discovery.new-devices is {}", to_string(discovery.otherwise))};
}

}  // namespace rubicon::proxy::admission
