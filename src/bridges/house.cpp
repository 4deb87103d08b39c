#include "bridges/house.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "model/json_members.h"
#include "model/point_keys.h"
#include "rubicon/summary.hpp"

namespace rubicon::bridges {

namespace {

using model::Kind;
using tuples::EventKind;

constexpr Flow kPassive{.passive = true};
/// Of all islands together; further ones are left out.
constexpr std::size_t kMaxPoints = 1'000'000;

/// The key of the device of a point.
std::string_view device_key(std::string_view point_key) {
  return model::parent_key(model::parent_key(point_key));
}

/// A level of a topic: what people write, without what MQTT means something by.
std::string level_of(std::string_view text) {
  std::string level;
  for (const char c : text) {
    const bool bad = c == '/' || c == '+' || c == '#' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
    level += bad ? '_' : c;
  }
  if (level.starts_with('$')) level.front() = '_';
  return level.substr(0, 64);
}

/// What a network says of its groups.
Groups groups_from_json(std::string_view text) {
  Groups groups;
  if (base::is_nested_deeper(text, 3)) return groups;
  const auto list = model::parse_json(text);
  for (const auto& one : list.is_array() ? list : nlohmann::json::array()) {
    if (one.is_object()) groups[model::text_of(one, "address")] = model::texts_of(one, "members");
  }
  return groups;
}

}  // namespace

std::string name_of(OwnerId owner, std::string_view key) {
  return fmt::format("{}:{}", number(owner), key);
}

House::House(const BridgeHost& host, const Scope& scope, Callbacks calls)
    : host_(host), scope_(scope), callbacks_(std::move(calls)) {}

void House::start() {
  started_ = host_.scheduler.wall_now();
  std::set<std::optional<OwnerId>> owners;
  for (const auto& pattern : scope_.patterns) owners.insert(pattern.owner);
  if (scope_.patterns.empty()) owners.insert(host_.island);
  if (owners.contains(std::nullopt)) owners = {std::nullopt};
  handles_.push_back(host_.space.watch_peers([this](OwnerId id, tuples::PeerEvent) { island_changed(id); }));
  handles_.push_back(host_.space.watch_summaries([this](OwnerId id, std::string_view) { island_changed(id); }));
  for (const auto id : host_.space.peers()) island_changed(id);
  for (const auto owner : owners) {
    for (const auto& [key, take] : takes(model::IslandKey{"*"}.network("*")))
      handles_.push_back(host_.space.subscribe({owner, key}, kPassive,
                                               [this, take = take](const Event& event) { (this->*take)(event); }));
  }
}

/// The tuples of a network, and what takes each. Networks first: one that comes from where we show it is known before
/// its points.
std::vector<std::pair<std::string, House::Take>> House::takes(const model::NetworkKey& network) const {
  const auto device = network.device("*");
  const auto point = device.point("*", "*");
  return {{network.property(scope_.origin), &House::origin_named},
          {network.property("groups"), &House::grouped},
          {network.status(), &House::line_stated},
          {device.status(), &House::device_stated},
          {device.description(), &House::device_described},
          {point.description(), &House::described},
          {point.status(), &House::stated},
          {point.value(), &House::valued}};
}

/// A network that was hidden: its tuples were refused when they came. What was pressed meanwhile is no event of now.
void House::look_again(OwnerId island, const model::NetworkKey& network) {
  for (const auto& [key, take] : takes(network)) {
    std::vector<std::string> keys;
    host_.space.list({island, key}, [&keys](const TupleView& tuple) { keys.emplace_back(tuple.key); });
    for (const auto& one : keys) {
      if (const auto tuple = host_.space.get(island, one)) (this->*take)({EventKind::kSet, *tuple});
    }
  }
  const auto below = name_of(island, network.text) + ".";
  for (auto at = devices_.lower_bound(below); at != devices_.end() && at->first.starts_with(below); ++at) {
    for (auto* point : at->second->points) point->fresh = false;
  }
}

bool House::selects_island(OwnerId id) const {
  if (scope_.patterns.empty()) return !host_.island || id == *host_.island;
  return std::any_of(scope_.patterns.begin(), scope_.patterns.end(),
                     [id](const Pattern& one) { return !one.owner || *one.owner == id; });
}

bool House::selected(OwnerId owner, std::string_view point_key) const {
  if (model::is_of_island(point_key) || !selects_island(owner) || owner == host_.space.self()) return false;
  const auto value = std::string(point_key) + ".value";
  if (any_key_matches(scope_.except, value)) return false;
  const auto& patterns = scope_.patterns;
  const bool wanted = patterns.empty() || std::any_of(patterns.begin(), patterns.end(),
                                                      [&](const Pattern& one) { return one.matches(owner, value); });
  if (!wanted || !host_.judge) return wanted;
  return host_.judge->access({"bridge:" + host_.name}, value).read;
}

std::string House::island_topic(OwnerId id) const {
  const auto found = islands_.find(id);
  const bool named = scope_.friendly && found != islands_.end() && !found->second.name.empty();
  return fmt::format("{}/{}", scope_.base, named ? level_of(found->second.name) : fmt::to_string(number(id)));
}

std::string House::topic_of(const DeviceEntry& device) const {
  const auto network = fmt::format("{}/{}", island_topic(device.island), device.network);
  const bool named = scope_.friendly && device.about && !device.about->name.empty();
  auto topic = fmt::format("{}/{}", network, named ? level_of(device.about->name) : device.id);
  const auto other = by_topic_.find(topic);
  const bool taken = named && other != by_topic_.end() && other->second != &device;
  return taken ? fmt::format("{} ({})", topic, device.id) : topic;
}

DeviceEntry* House::device_at(OwnerId island, std::string_view key, bool make) {
  const auto name = name_of(island, key);
  if (const auto found = devices_.find(name); found != devices_.end()) return found->second.get();
  const auto parts = model::key_parts(key);
  if (!make || parts.size() != 3) return nullptr;
  if (foreign_.contains(name_of(island, model::parent_key(key)))) return nullptr;
  auto device = std::make_unique<DeviceEntry>();
  device->island = island;
  device->prefix = parts[0];
  device->network = parts[1];
  device->id = parts[2];
  device->key = key;
  device->since = host_.scheduler.now();
  device->topic = topic_of(*device);
  by_topic_[device->topic] = device.get();
  return devices_.emplace(name, std::move(device)).first->second.get();
}

PointEntry* House::find_point(OwnerId island, std::string_view key) {
  if (recent_ && recent_->key == key && recent_->device->island == island) return recent_;
  const auto found = points_.find(Place{island, key});
  if (found != points_.end()) recent_ = found->get();
  return found == points_.end() ? nullptr : recent_;
}

PointEntry* House::point_at(const TupleView& tuple, bool make) {
  const auto key = model::parent_key(tuple.key);
  if (auto* found = find_point(tuple.owner, key)) return found;
  if (!make || points_.size() >= kMaxPoints || !selected(tuple.owner, key)) return nullptr;
  const auto parts = model::key_parts(key);
  const auto kind = parts.size() == 5 ? model::parse_kind(parts[3]) : std::nullopt;
  auto* device = kind ? device_at(tuple.owner, device_key(key), true) : nullptr;
  if (device == nullptr) return nullptr;
  auto point = std::make_unique<PointEntry>();
  point->device = device;
  point->kind = *kind;
  point->key = key;
  auto* made = points_.insert(std::move(point)).first->get();
  device->points.insert(made);
  callbacks_.device(*device);
  return made;
}

/// What devices and points of one type say of themselves is often the same text.
std::shared_ptr<const model::PointDescription> Descriptions::of(std::string_view text) {
  if (const auto found = by_text_.find(text); found != by_text_.end()) return found->second;
  auto about = model::point_description_from_json(text);
  if (!about) return nullptr;
  if (by_text_.size() >= most_) {
    std::erase_if(by_text_, [](const auto& one) { return one.second.use_count() == 1; });
    most_ = std::max(kFew, 2 * by_text_.size());
  }
  auto shared = std::make_shared<const model::PointDescription>(std::move(*about));
  by_text_.emplace(text, shared);
  return shared;
}

void House::valued(const Event& event) {
  const bool set = event.kind == EventKind::kSet;
  auto* point = point_at(event.tuple, set);
  if (point == nullptr) return;
  if (event.kind == EventKind::kDeleted) return forget_point(*point);
  if (event.kind == EventKind::kLost) return lose(*point);
  point->lost = false;
  point->value = set ? event.tuple.value : std::string_view();
  point->time = event.tuple.user_time == WallTime{} ? event.tuple.write_time : event.tuple.user_time;
  // A press before the bridge started is not an event.
  point->fresh = !point->value.empty() && event.tuple.write_time >= started_;
  callbacks_.point(*point);
}

/// Its value is dropped as the copy was: what comes back is published once it is there.
void House::lose(PointEntry& point) {
  point.lost = true;
  point.fresh = false;
  point.value.clear();
  point.quality = model::Quality::kNetworkDown;
  callbacks_.point(point);
}

void House::stated(const Event& event) {
  if (event.kind != EventKind::kSet) return;
  auto* point = point_at(event.tuple, true);
  if (point == nullptr) return;
  const auto& text = event.tuple.value;
  auto quality = model::quality_from_json(text);
  if (!quality) quality = model::parse_quality(model::point_status_from_json(text).quality);
  const auto now = quality.value_or(model::Quality::kUnknown);
  if (std::exchange(point->quality, now) != now) callbacks_.point(*point);
  callbacks_.status(*point);
}

void House::described(const Event& event) {
  if (event.kind != EventKind::kSet) return;
  auto* point = point_at(event.tuple, true);
  auto about = point ? descriptions_.of(event.tuple.value) : nullptr;
  if (!about || point->about == about) return;
  point->about = std::move(about);
  callbacks_.device(*point->device);
  callbacks_.point(*point);
}

void House::device_stated(const Event& event) {
  auto* device = device_at(event.tuple.owner, model::parent_key(event.tuple.key), false);
  const bool lost = event.kind == EventKind::kLost;
  if (device == nullptr || (event.kind != EventKind::kSet && !lost)) return;
  auto status = model::device_condition_from_json(event.tuple.value).status;
  const bool was_lost = std::exchange(device->lost, lost);
  if (std::exchange(device->status, status) != status || was_lost != lost) callbacks_.device(*device);
}

/// A device without points of ours is none.
void House::device_described(const Event& event) {
  const auto key = model::parent_key(event.tuple.key);
  if (event.kind == EventKind::kDeleted) return forget_device(name_of(event.tuple.owner, key));
  if (event.kind != EventKind::kSet || !selects_island(event.tuple.owner)) return;
  auto about = model::device_description_from_json(event.tuple.value);
  auto* device = about && !model::is_of_island(event.tuple.key) ? device_at(event.tuple.owner, key, true) : nullptr;
  if (device == nullptr || device->about == about) return;
  device->about = std::move(about);
  if (const auto status = host_.space.get(device->island, device->key + ".status"))
    device->status = model::device_condition_from_json(status->value).status;
  if (scope_.friendly) name_again(*device);
  callbacks_.device(*device);
}

/// Its topics have its name.
void House::name_again(DeviceEntry& device) {
  const auto topic = topic_of(device);
  if (topic == device.topic) return;
  callbacks_.renamed(device);
  leave_topic(device);
  device.topic = topic;
  by_topic_[topic] = &device;
  for (auto* point : device.points) callbacks_.point(*point);
}

void House::line_stated(const Event& event) {
  const auto key = model::parent_key(event.tuple.key);
  const auto name = name_of(event.tuple.owner, key);
  const bool lost = event.kind == EventKind::kLost;
  if (event.kind == EventKind::kDeleted) return forget_network(name);
  if (event.kind != EventKind::kSet && !(lost && networks_.contains(name))) return;
  if (!selects_island(event.tuple.owner) || foreign_.contains(name)) return;
  const auto status = model::line_status_from_json(event.tuple.value);
  if (status.line.empty()) return;  // a tuple of three parts that is not a line
  const auto id = std::string(model::last_part(key));
  auto [at, fresh] = networks_.try_emplace(name, NetworkEntry{event.tuple.owner, id, {}});
  auto& network = at->second;
  network.topic = fmt::format("{}/{}", island_topic(network.island), id);
  const bool works = status.works() && !lost, was_lost = std::exchange(network.lost, lost);
  if (std::exchange(network.works, works) != works || was_lost != lost || fresh) callbacks_.network(network);
}

/// Its devices came from where we show them: they are there already. They are shown once it comes from elsewhere.
void House::origin_named(const Event& event) {
  const auto network = model::network_of(event.tuple.key);
  if (event.kind == EventKind::kLost || !network) return;
  const auto name = name_of(event.tuple.owner, network->text);
  const bool is_ours = event.kind == EventKind::kSet && callbacks_.is_ours(event.tuple.value);
  if (is_ours && foreign_.insert(name).second) forget_network(name);
  if (!is_ours && foreign_.erase(name) > 0) look_again(event.tuple.owner, *network);
}

/// Announces the devices again that became a group or are none any more.
void House::grouped(const Event& event) {
  const auto network = model::network_of(event.tuple.key);
  if (event.kind == EventKind::kLost || !network || !selects_island(event.tuple.owner)) return;
  const auto groups = event.kind == EventKind::kSet ? groups_from_json(event.tuple.value) : Groups();
  const auto name = name_of(event.tuple.owner, network->text);
  const auto before = std::exchange(groups_[name], groups);
  if (groups.empty()) groups_.erase(name);
  if (before == groups) return;
  for (auto& [key, device] : devices_) {
    if (!key.starts_with(name + ".") || !device->about) continue;
    const auto& address = device->about->address;
    if (groups.contains(address) || before.contains(address)) callbacks_.device(*device);
  }
}

std::vector<DeviceEntry*> House::find_addresses(const DeviceEntry& near,
                                                const std::vector<std::string>& addresses) const {
  std::vector<DeviceEntry*> found;
  const auto below = name_of(near.island, model::parent_key(near.key)) + ".";
  for (auto at = devices_.lower_bound(below); at != devices_.end() && at->first.starts_with(below); ++at) {
    const auto& about = at->second->about;
    if (about && std::find(addresses.begin(), addresses.end(), about->address) != addresses.end())
      found.push_back(at->second.get());
  }
  return found;
}

std::vector<DeviceEntry*> House::members_of(const DeviceEntry& group) const {
  const auto groups = groups_.find(name_of(group.island, model::parent_key(group.key)));
  if (groups == groups_.end() || !group.about) return {};
  const auto members = groups->second.find(group.about->address);
  return members == groups->second.end() ? std::vector<DeviceEntry*>() : find_addresses(group, members->second);
}

std::vector<DeviceEntry*> House::groups_of(const DeviceEntry& member) const {
  const auto groups = groups_.find(name_of(member.island, model::parent_key(member.key)));
  std::vector<std::string> addresses;
  if (groups == groups_.end() || !member.about) return {};
  for (const auto& [group, members] : groups->second) {
    if (std::find(members.begin(), members.end(), member.about->address) != members.end()) addresses.push_back(group);
  }
  return addresses.empty() ? std::vector<DeviceEntry*>() : find_addresses(member, addresses);
}

void House::island_changed(OwnerId id) {
  const auto text = host_.space.summary(id);
  const auto summary = text.empty() ? Summary{} : model::summary_from_json(text).value_or(Summary{});
  const bool known = islands_.contains(id);
  const auto peers = host_.space.peers();
  const bool present = std::find(peers.begin(), peers.end(), id) != peers.end();
  if (!selects_island(id) || (!known && !model::is_island(id, summary))) return;
  auto& island = islands_[id];
  if (present && !summary.prefix.empty()) {
    island.name = summary.name;
    island.prefix = summary.prefix;
    island.version = summary.program;
  }
  island.id = id;
  island.topic = island_topic(id);
  if (std::exchange(island.present, present) == present && known) return;
  island.forgets.cancel();
  if (!present) island.forgets = host_.scheduler.after(kGoneForGood, [this, id] { forget_island(id); });
  if (present && known) island.forgets = host_.scheduler.after(kReturn, [this, id] { forget_lost(id); });
  callbacks_.island(island);
}

bool House::is_complete(const DeviceEntry& device) const {
  if (host_.scheduler.now() - device.since >= kComplete) return true;
  if (!device.about) return false;
  const auto all = device.about->sensors.size() + device.about->actuators.size() + device.about->properties.size();
  const auto described = [](const auto* point) { return point->about != nullptr; };
  return device.points.size() >= all && std::all_of(device.points.begin(), device.points.end(), described);
}

PointEntry* House::find_by_topic(std::string_view topic) {
  const auto id = topic.rfind('/');
  const auto kind = id == topic.npos ? id : topic.rfind('/', id - 1);
  const auto* device = kind == topic.npos || kind == 0 ? nullptr : find_device(topic.substr(0, kind));
  if (device == nullptr) return nullptr;
  const auto key = fmt::format("{}.{}.{}", device->key, topic.substr(kind + 1, id - kind - 1), topic.substr(id + 1));
  return find_point(device->island, key);
}

DeviceEntry* House::find_device(std::string_view topic) {
  const auto found = by_topic_.find(topic);
  return found == by_topic_.end() ? nullptr : found->second;
}

IslandEntry* House::find_island(OwnerId id) {
  const auto found = islands_.find(id);
  return found == islands_.end() ? nullptr : &found->second;
}

void House::each_device(const std::function<void(DeviceEntry&)>& visit) {
  for (auto& [name, device] : devices_) visit(*device);
}
void House::each_network(const std::function<void(NetworkEntry&)>& visit) {
  for (auto& [name, network] : networks_) visit(network);
}
void House::each_island(const std::function<void(IslandEntry&)>& visit) {
  for (auto& [id, island] : islands_) visit(island);
}

std::string PointEntry::topic(std::string_view below) const {
  std::string all;
  const auto of_kind = to_string(kind);
  all.reserve(device->topic.size() + of_kind.size() + id().size() + below.size() + 2);
  all += device->topic;
  for (const auto part : {of_kind, id()}) {
    all += '/';
    all += part;
  }
  return all += below;
}

}  // namespace rubicon::bridges
