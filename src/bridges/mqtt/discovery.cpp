#include "bridges/mqtt/discovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "model/json_members.h"
#include "rubicon/key.hpp"

namespace rubicon::bridges::mqtt {

using Json = nlohmann::ordered_json;

/// What the messages of one device have in common.
struct Announcer::About {
  std::string id;  ///< of the device
  std::string name;
  Json device, availability;
};

namespace {

constexpr std::size_t kMaxSlug = 120;  // of an entity id; they have 255 bytes
constexpr int kTimeToLive = 5;         // s, of commands

/// Of an entity id: [a-z0-9_].
std::string slug(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool good = std::isalnum(static_cast<unsigned char>(c)) != 0;
    if (good) out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (!good && !out.empty() && out.back() != '_') out += '_';
  }
  out.resize(std::min(out.size(), kMaxSlug));
  while (!out.empty() && out.back() == '_') out.pop_back();
  return out;
}

Json availability(std::initializer_list<std::string> topics) {
  auto list = Json::array();
  for (const auto& topic : topics) {
    const Json entry{{"t", topic + "/online"}};
    if (std::find(list.begin(), list.end(), entry) == list.end()) list.push_back(entry);
  }
  return list;
}

void add(Json& json, const char* key, const std::string& text) {
  if (!text.empty()) json[key] = text;
}

/// The value of a property of this type, such as its firmware.
std::string value_of(const DeviceEntry& device, std::string_view type) {
  for (const auto* point : device.points) {
    if (point->kind == model::Kind::kProperty && point->type() == type) return point->value;
  }
  return {};
}

std::string island_object(OwnerId island) {
  return fmt::format("rubicon_{}", number(island));
}

void add_attributes(const Options& options, Entity& entity) {
  for (const auto* topic : {"stat_t", "pos_t", "mode_stat_t"}) {
    const auto found = entity.body.find(topic);
    if (options.attributes && found != entity.body.end() && !entity.body.contains("json_attr_t"))
      entity.body["json_attr_t"] = found->get<std::string>() + "/attributes";
  }
}

Entity connectivity(const std::string& topic, const std::string& id) {
  Json body{{"stat_t", topic + "/online"}, {"pl_on", "online"}, {"pl_off", "offline"}, {"dev_cla", "connectivity"}};
  body["ent_cat"] = "diagnostic";
  body["name"] = "Connection";
  return {"binary_sensor", id, std::move(body)};
}

}  // namespace

std::string Announcer::object_id(const DeviceEntry& device) {
  return fmt::format("{}_{}_{}", island_object(device.island), device.network, device.id);
}

bool Announcer::takes(const PointEntry& point) const {
  return takes_command(options_, point.key + ".command");
}

nlohmann::ordered_json Announcer::device_json(const DeviceEntry& device) const {
  const auto about = device.about.value_or(model::DeviceDescription{});
  Json json{{"ids", {object_id(device)}}, {"name", about.name.empty() ? device.id : about.name}};
  add(json, "mf", value_of(device, "manufacturer"));
  add(json, "mdl", about.model.empty() ? about.type : about.model);
  add(json, "mdl_id", value_of(device, "modelName"));
  add(json, "sw", value_of(device, "firmware"));
  add(json, "hw", value_of(device, "hardware"));
  add(json, "sn", value_of(device, "serialNumber"));
  add(json, "sa", about.area);
  json["via_device"] = fmt::format("{}_{}", island_object(device.island), device.network);
  if (!options_.page.empty())
    json["cu"] = fmt::format("{}/#/devices/{}/{}/{}", options_.page, number(device.island), device.network, device.id);
  return json;
}

/// A group names the entities of its members that are of its kind.
void Announcer::add_members(const DeviceEntry& group, Entity& entity) const {
  if (!entity.body.contains("cmd_t") && !entity.body.contains("set_pos_t")) return;
  auto members = Json::array();
  for (const auto* member : house_.members_of(group)) {
    for (const auto& one : entities_of(*member, [this](const PointEntry& point) { return takes(point); })) {
      if (one.platform == entity.platform) members.push_back(fmt::format("{}_{}", object_id(*member), one.id));
    }
  }
  if (!members.empty()) entity.body["group"] = std::move(members);
}

std::vector<Announcement> Announcer::of(const DeviceEntry& device) const {
  const auto island = house_.island_topic(device.island);
  const auto network = fmt::format("{}/{}", island, device.network);
  const About about{object_id(device), device.about ? device.about->name : device.id, device_json(device),
                    availability({home_, island, network, device.topic})};
  auto entities = entities_of(device, [this](const PointEntry& point) { return takes(point); });
  for (auto& entity : entities) {
    add_attributes(options_, entity);
    add_members(device, entity);
    // An entity that can only be read is unavailable while its value is not good. An entity with commands is available
    // as long as its device.
    if (entity.body.contains("cmd_t") || entity.platform == "event" || !entity.body.contains("stat_t")) continue;
    entity.body["avty"] =
        availability({home_, island, network, device.topic, entity.body["stat_t"].get<std::string>()});
  }
  return write(about, std::move(entities));
}

std::vector<Announcement> Announcer::of(const NetworkEntry& network) const {
  const auto island = house_.island_topic(network.island);
  const auto id = fmt::format("{}_{}", island_object(network.island), network.id);
  Json device{{"ids", {id}}, {"name", fmt::format("Network {}", network.id)}, {"mdl", "network"}};
  device["via_device"] = island_object(network.island);
  return write({id, network.id, std::move(device), availability({home_, island})},
               {connectivity(network.topic, "online")});
}

std::vector<Announcement> Announcer::of(const IslandEntry& island) const {
  const auto id = island_object(island.id);
  Json device{{"ids", {id}}, {"name", island.name.empty() ? id : island.name}, {"mdl", "island"}};
  add(device, "sw", island.version);
  if (!options_.page.empty()) device["cu"] = options_.page;
  return write({id, island.name, std::move(device), availability({home_})}, {connectivity(island.topic, "online")});
}

void Announcer::complete(const About& about, Entity& entity) const {
  auto& body = entity.body;
  body["uniq_id"] = fmt::format("{}_{}", about.id, entity.id);
  const auto own = body["name"].is_string() ? " " + body["name"].get<std::string>() : std::string();
  const auto object = slug(about.name + own);
  body["default_entity_id"] = fmt::format("{}.{}", entity.platform, object.empty() ? slug(about.id + own) : object);
  if (body.contains("cmd_t") || body.contains("set_pos_t") || body.contains("mode_cmd_t"))
    body["message_expiry_interval"] = kTimeToLive;
}

std::vector<Announcement> Announcer::write(const About& about, std::vector<Entity> entities) const {
  std::vector<Announcement> all;
  auto components = Json::object();
  std::size_t bytes = 0;
  for (auto& entity : entities) {
    complete(about, entity);
    if (options_.discovery == Discovery::kEntities) {
      auto body = entity.body;
      if (!body.contains("avty")) body["avty"] = about.availability;
      body.update(Json{{"avty_mode", "all"}, {"dev", about.device}, {"o", {{"name", "rubicon"}}}});
      all.push_back({fmt::format("{}/{}/{}/{}/config", options_.discovery_base, entity.platform, about.id, entity.id),
                     model::dump(body)});
      continue;
    }
    Json component{{"p", entity.platform}};
    component.update(entity.body);
    const auto size = model::dump(component).size() + entity.id.size();
    if (components.size() >= kMaxEntities || (bytes + size > kMaxBytes && !components.empty())) {
      all.push_back(whole(about, std::exchange(components, Json::object()), all.size() + 1));
      bytes = 0;
    }
    bytes += size;
    components[entity.id] = std::move(component);
  }
  if (!components.empty()) all.push_back(whole(about, components, all.size() + 1));
  return all;
}

Announcement Announcer::whole(const About& about, const nlohmann::ordered_json& components, std::size_t part) const {
  const Json origin{{"name", "rubicon"}, {"sw", RUBICON_VERSION}};
  const Json message{{"dev", about.device}, {"o", origin}, {"avty", about.availability},
                     {"avty_mode", "all"},  {"qos", 0},    {"cmps", components}};
  const auto id = part == 1 ? about.id : fmt::format("{}_{}", about.id, part);
  return {fmt::format("{}/device/{}/config", options_.discovery_base, id), model::dump(message)};
}

bool Announcer::is_of_rubicon(std::string_view topic) const {
  return topic.starts_with(options_.discovery_base + "/") && topic.ends_with("/config") &&
         topic.find("/rubicon_") != topic.npos;
}

bool Announcer::is_ours(std::string_view payload) const {
  const auto json = model::object_of(payload);
  const auto origin = json.find("o");
  const auto all = json.find("avty");
  if (origin == json.end() || model::text_of(*origin, "name") != "rubicon" || all == json.end() || !all->is_array())
    return false;
  return !all->empty() && model::text_of(all->front(), "t") == home_ + "/online";
}

namespace {

constexpr std::string_view kPresence = "/online";

std::string_view above(std::string_view topic) {
  return topic.substr(0, std::min(topic.rfind('/'), topic.size()));
}

}  // namespace

/// Devices, points, whether a point is there. They do not overlap with each other or with those of commands: a broker
/// may send a message once for each filter.
std::vector<std::string> Leftovers::filters() const {
  const auto& base = options_.base;
  std::vector<std::string> all{base + "/+/+/+/online", base + "/+/+/+/+/+", base + "/+/+/+/+/+/online"};
  const auto& discovery = options_.discovery_base;
  if (options_.discovery == Discovery::kNone) return all;
  all.push_back(discovery + "/device/+/config");
  all.push_back(discovery + "/+/+/+/config");
  return all;
}

void Leftovers::take(const transport::MqttMessage& message) {
  const bool announced = announcer_.is_of_rubicon(message.topic);
  const bool foreign = announced && !message.payload.empty() && !announcer_.is_ours(message.payload);
  disputed_ |= foreign && !message.retained;  // what a run before left is written over
  if (!message.retained || message.payload.empty() || topics_.size() >= kMaxTopics) return;
  const bool ours = announced ? announcer_.is_ours(message.payload) : message.topic.starts_with(options_.base + "/");
  if (ours) topics_.emplace(message.topic, announced);
}

bool Leftovers::is_other_form(const transport::MqttMessage& message) const {
  if (!message.retained || !announcer_.is_of_rubicon(message.topic)) return false;
  const bool whole = message.topic.starts_with(options_.discovery_base + "/device/");
  return whole != (options_.discovery == Discovery::kDevices) && announcer_.is_ours(message.payload);
}

bool Leftovers::is_gone(const std::string& topic) const {
  bool there = false;
  house_.each_island([&](IslandEntry& island) { there |= island.present && topic.starts_with(island.topic + "/"); });
  if (!there) return false;
  const auto point = topic.ends_with(kPresence) ? above(topic) : std::string_view(topic);
  return house_.find_by_topic(point) == nullptr && house_.find_device(point) == nullptr;
}

std::set<std::string> Leftovers::gone(const std::set<std::string>& kept) {
  std::set<std::string> all;
  for (const auto& [topic, announced] : std::exchange(topics_, {})) {
    if (announced ? !kept.contains(topic) : is_gone(topic)) all.insert(topic);
  }
  return all;
}

}  // namespace rubicon::bridges::mqtt
