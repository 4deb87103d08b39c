#include "bridges/mqtt/house.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/json_members.h"
#include "model/point_keys.h"
#include "rubicon/summary.hpp"

namespace rubicon::bridges::mqtt {

namespace {

using model::Kind;
using tuples::EventKind;

constexpr Flow kPassive{.passive = true};
/// Of all islands together; further ones are left out.
constexpr std::size_t kMaxPoints = 1'000'000;

std::string name_of(OwnerId owner, std::string_view key) {
  return fmt::format("{}:{}", number(owner), key);
}

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

/// `localhost` and its addresses are one broker.
std::string place_of_broker(std::string host, std::uint64_t port) {
  if (host == "localhost" || host == "::1") host = "127.0.0.1";
  return fmt::format("{}:{}", host, port);
}

}  // namespace

House::House(const BridgeHost& host, const Options& options, Calls calls)
    : host_(host), options_(options), calls_(std::move(calls)) {}

void House::start() {
  started_ = host_.scheduler.wall_now();
  std::set<std::optional<OwnerId>> owners;
  for (const auto& pattern : options_.patterns) owners.insert(pattern.owner);
  if (options_.patterns.empty()) owners.insert(host_.island);
  if (owners.contains(std::nullopt)) owners = {std::nullopt};
  handles_.push_back(host_.space.watch_peers([this](OwnerId id, tuples::PeerEvent) { island_changed(id); }));
  handles_.push_back(host_.space.watch_summaries([this](OwnerId id, std::string_view) { island_changed(id); }));
  for (const auto id : host_.space.peers()) island_changed(id);
  for (const auto owner : owners) follow(owner);
}

void House::watch(std::optional<OwnerId> owner, const std::string& key, void (House::*take)(const Event&)) {
  handles_.push_back(
      host_.space.subscribe({owner, key}, kPassive, [this, take](const Event& event) { (this->*take)(event); }));
}

/// Networks first: a network that comes from our broker is known before its points.
void House::follow(std::optional<OwnerId> owner) {
  const auto network = model::IslandKey{"*"}.network("*");
  const auto device = network.device("*");
  const auto point = model::any_point();
  watch(owner, network.property("broker"), &House::broker_named);
  watch(owner, network.status(), &House::line_stated);
  watch(owner, device.status(), &House::device_stated);
  watch(owner, device.description(), &House::device_described);
  watch(owner, point.description(), &House::described);
  watch(owner, point.status(), &House::stated);
  watch(owner, point.value(), &House::valued);
}

bool House::selects_island(OwnerId id) const {
  if (options_.patterns.empty()) return !host_.island || id == *host_.island;
  return std::any_of(options_.patterns.begin(), options_.patterns.end(),
                     [id](const Pattern& one) { return !one.owner || *one.owner == id; });
}

bool House::selected(OwnerId owner, std::string_view point_key) const {
  if (model::is_of_island(point_key) || !selects_island(owner)) return false;
  const auto value = std::string(point_key) + ".value";
  if (any_key_matches(options_.except, value)) return false;
  const auto& patterns = options_.patterns;
  const bool wanted = patterns.empty() || std::any_of(patterns.begin(), patterns.end(),
                                                      [&](const Pattern& one) { return one.matches(owner, value); });
  if (!wanted || !host_.judge) return wanted;
  return host_.judge->access({"bridge:" + host_.name}, value).read;
}

std::string House::island_topic(OwnerId id) const {
  const auto found = islands_.find(id);
  const bool named = options_.friendly && found != islands_.end() && !found->second.name.empty();
  return fmt::format("{}/{}", options_.base, named ? level_of(found->second.name) : fmt::to_string(number(id)));
}

std::string House::topic_of(const DeviceEntry& device) const {
  const auto network = fmt::format("{}/{}", island_topic(device.island), device.network);
  const bool named = options_.friendly && device.about && !device.about->name.empty();
  auto topic = fmt::format("{}/{}", network, named ? level_of(device.about->name) : device.id);
  const bool taken = named && std::any_of(devices_.begin(), devices_.end(), [&](const auto& other) {
                       return other.second.get() != &device && other.second->topic == topic;
                     });
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
  return devices_.emplace(name, std::move(device)).first->second.get();
}

PointEntry* House::point_at(const TupleView& tuple, bool make) {
  const auto key = model::parent_key(tuple.key);
  name_.clear();
  fmt::format_to(std::back_inserter(name_), "{}:{}", number(tuple.owner), key);
  if (const auto found = points_.find(name_); found != points_.end()) return found->second.get();
  if (!make || points_.size() >= kMaxPoints || !selected(tuple.owner, key)) return nullptr;
  const auto parts = model::key_parts(key);
  const auto kind = parts.size() == 5 ? model::parse_kind(parts[3]) : std::nullopt;
  auto* device = kind ? device_at(tuple.owner, device_key(key), true) : nullptr;
  if (device == nullptr) return nullptr;
  auto point = std::make_unique<PointEntry>();
  point->device = device;
  point->kind = *kind;
  point->id = parts[4];
  point->key = key;
  point->topic = fmt::format("{}/{}/{}", device->topic, parts[3], parts[4]);
  auto* made = points_.emplace(name_, std::move(point)).first->second.get();
  by_topic_[made->topic] = made;
  device->points[made->key] = made;
  calls_.device(*device);
  return made;
}

void House::valued(const Event& event) {
  if (event.kind == EventKind::kLost) return;
  const bool set = event.kind == EventKind::kSet;
  auto* point = point_at(event.tuple, set);
  if (point == nullptr) return;
  if (event.kind == EventKind::kDeleted) return forget_point(name_of(event.tuple.owner, point->key));
  point->value = set ? event.tuple.value : std::string_view();
  point->time = event.tuple.user_time == WallTime{} ? event.tuple.write_time : event.tuple.user_time;
  // What was pressed before we looked is no event.
  point->fresh = !point->value.empty() && event.tuple.write_time >= started_;
  calls_.point(*point);
}

void House::stated(const Event& event) {
  if (event.kind != EventKind::kSet) return;
  auto* point = point_at(event.tuple, true);
  if (point == nullptr) return;
  const auto heard = model::heard_quality_from_json(event.tuple.value);
  const auto quality = heard ? heard->quality
                             : model::parse_quality(model::point_status_from_json(event.tuple.value).quality)
                                   .value_or(model::Quality::kUnknown);
  if (std::exchange(point->quality, quality) != quality) calls_.point(*point);
}

void House::described(const Event& event) {
  if (event.kind != EventKind::kSet) return;
  auto* point = point_at(event.tuple, true);
  auto about = point ? model::point_description_from_json(event.tuple.value) : std::nullopt;
  if (!about || point->about == about) return;
  point->about = std::move(about);
  calls_.device(*point->device);
  calls_.point(*point);
}

void House::device_stated(const Event& event) {
  auto* device = device_at(event.tuple.owner, model::parent_key(event.tuple.key), false);
  if (device == nullptr || event.kind != EventKind::kSet) return;
  auto status = model::device_condition_from_json(event.tuple.value).status;
  if (std::exchange(device->status, status) != status) calls_.device(*device);
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
  if (options_.friendly) name_again(*device);
  calls_.device(*device);
}

/// Its topics have its name.
void House::name_again(DeviceEntry& device) {
  const auto topic = topic_of(device);
  if (topic == device.topic) return;
  calls_.renamed(device);
  for (auto& [key, point] : device.points) {
    by_topic_.erase(point->topic);
    point->topic = topic + point->topic.substr(device.topic.size());
    by_topic_[point->topic] = point;
  }
  device.topic = topic;
  for (auto& [key, point] : device.points) calls_.point(*point);
}

void House::line_stated(const Event& event) {
  const auto key = model::parent_key(event.tuple.key);
  const auto name = name_of(event.tuple.owner, key);
  if (event.kind == EventKind::kDeleted) return forget_network(name);
  if (event.kind != EventKind::kSet || !selects_island(event.tuple.owner) || foreign_.contains(name)) return;
  const auto status = model::line_status_from_json(event.tuple.value);
  if (status.line.empty()) return;  // a tuple of three parts that is no line
  const auto id = std::string(model::last_part(key));
  auto [at, fresh] = networks_.try_emplace(name, NetworkEntry{event.tuple.owner, id, {}, false, false});
  auto& network = at->second;
  network.topic = fmt::format("{}/{}", island_topic(network.island), id);
  if (std::exchange(network.works, status.works()) != status.works() || fresh) calls_.network(network);
}

/// A network whose broker is ours: its devices are there already.
void House::broker_named(const Event& event) {
  if (event.kind != EventKind::kSet) return;
  const auto json = model::object_of(event.tuple.value);
  const auto& ours = options_.broker.line;
  const auto theirs = place_of_broker(model::text_of(json, "host"), model::count_of(json, "port"));
  const auto network = model::network_of(event.tuple.key);
  if (!network || theirs != place_of_broker(ours.host, ours.port)) return;
  const auto name = name_of(event.tuple.owner, network->text);
  if (foreign_.insert(name).second) forget_network(name);
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
  if (std::exchange(island.present, present) != present || !known) calls_.island(island);
}

void House::forget_point(const std::string& name) {
  const auto found = points_.find(name);
  if (found == points_.end()) return;
  auto& point = *found->second;
  auto& device = *point.device;
  calls_.point_gone(point);
  by_topic_.erase(point.topic);
  device.points.erase(point.key);
  points_.erase(found);
  calls_.device(device);
}

void House::forget_device(const std::string& name) {
  const auto found = devices_.find(name);
  if (found == devices_.end()) return;
  auto& device = *found->second;
  calls_.device_gone(device);
  for (const auto& [key, point] : device.points) {
    by_topic_.erase(point->topic);
    points_.erase(name_of(device.island, key));
  }
  devices_.erase(found);
}

void House::forget_network(const std::string& name) {
  const auto below = name + ".";
  for (auto at = devices_.lower_bound(below); at != devices_.end() && at->first.starts_with(below);) {
    const auto gone = (at++)->first;
    forget_device(gone);
  }
  const auto found = networks_.extract(name);
  if (!found.empty()) calls_.network_gone(found.mapped().island, found.mapped().id);
}

PointEntry* House::find_by_topic(std::string_view topic) {
  const auto found = by_topic_.find(topic);
  return found == by_topic_.end() ? nullptr : found->second;
}

DeviceEntry* House::find_device(std::string_view topic) {
  const auto found =
      std::find_if(devices_.begin(), devices_.end(), [topic](const auto& one) { return one.second->topic == topic; });
  return found == devices_.end() ? nullptr : found->second.get();
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

}  // namespace rubicon::bridges::mqtt
