#include "networks/zigbee/bridge/messages.h"

#include <fmt/format.h>

#include "base/text.h"
#include "networks/zigbee/bridge/device_record.h"
#include "networks/zigbee/bridge/json_tree.h"

namespace rubicon::networks::zigbee::bridge {

namespace {

void read_word(const JsonObject& object, std::string_view name, std::string& out) {
  if (auto word = word_at(object, name); !word.empty()) out = std::move(word);
}

/// `availability: true`, and `availability: {timeout: 20}` of one device, also mean on.
std::optional<bool> read_availability_option(const JsonObject& options) {
  if (const auto flag = flag_at(options, "availability")) return flag;
  const auto map = object_at(options, "availability");
  if (!map) return std::nullopt;
  return flag_at(*map, "enabled").value_or(true);
}

EntityOptions read_options(const JsonObject& options) {
  return {flag_at(options, "optimistic"), read_availability_option(options), flag_at(options, "retain")};
}

/// A group is named by its number there, a device by its ieee_address.
std::string entity_of(std::string_view key) {
  if (auto address = address_of(key); !address.empty()) return address;
  const auto number = base::parse_number<std::uint32_t>(key);
  return number ? fmt::format("group-{}", *number) : std::string();
}

void read_entities(const JsonObject& config, std::string_view list, BridgeDescription& bridge) {
  const auto entities = object_at(config, list);
  if (!entities) return;
  for (const auto field : *entities) {
    JsonObject options;
    if (field.value.get(options)) continue;
    const auto read = read_options(options);
    if (const auto entity = entity_of(field.key); !entity.empty() && read != EntityOptions{}) bridge.of[entity] = read;
  }
}

void read_availability(const JsonObject& config, BridgeDescription& bridge) {
  if (const auto flag = flag_at(config, "availability")) bridge.availability_enabled = *flag;
  const auto map = object_at(config, "availability");
  if (!map) return;
  bridge.availability_enabled = flag_at(*map, "enabled").value_or(false);
}

void read_config(const JsonObject& config, BridgeDescription& bridge) {
  if (const auto advanced = object_at(config, "advanced")) {
    read_word(*advanced, "output", bridge.output);
    read_word(*advanced, "last_seen", bridge.last_seen);
    read_word(*advanced, "log_level", bridge.log_level);
    bridge.cache_state = flag_at(*advanced, "cache_state").value_or(true);
  }
  if (const auto mqtt = object_at(config, "mqtt")) {
    bridge.retained = !flag_at(*mqtt, "force_disable_retain").value_or(false);
  }
  read_availability(config, bridge);
  if (const auto all = object_at(config, "device_options")) bridge.all = read_options(*all);
  read_entities(config, "devices", bridge);
  read_entities(config, "groups", bridge);
}

BridgeEvent::Kind kind_of(const std::string& type, const std::string& status) {
  using Kind = BridgeEvent::Kind;
  if (type == "device_joined") return Kind::kJoined;
  if (type == "device_announce") return Kind::kAnnounced;
  if (type == "device_leave") return Kind::kLeft;
  if (type != "device_interview") return Kind::kOther;
  if (status == "started") return Kind::kInterviewing;
  if (status == "successful") return Kind::kInterviewed;
  return status == "failed" ? Kind::kFailed : Kind::kOther;
}

void read_event_definition(const JsonObject& data, BridgeEvent& event) {
  event.supported = flag_at(data, "supported").value_or(false);
  const auto definition = object_at(data, "definition");
  if (!definition) return;
  event.vendor = text_at(*definition, "vendor");
  event.model = text_at(*definition, "model");
  event.description = text_at(*definition, "description");
}

}  // namespace

Result<bool> read_online(std::string_view payload) {
  std::string word(base::trimmed(payload));
  if (word.starts_with('{')) {
    JsonTree tree;
    const auto object = tree.parse_object(payload, "state of the bridge, or availability", kMaxMessageBytes);
    if (!object) return fail(object.error());
    // A state message of a device has more members than this one.
    word = object->size() == 1 ? text_at(*object, "state") : std::string();
  }
  if (word == "online") return true;
  if (word == "offline") return false;
  return fail(ErrorCode::kInvalid, "state of the bridge, or availability: expected online or offline");
}

bool BridgeDescription::optimistic(const std::string& address) const {
  const auto own = of.find(address);
  if (own != of.end() && own->second.optimistic) return *own->second.optimistic;
  return all.optimistic.value_or(true);
}

bool BridgeDescription::availability(const std::string& address) const {
  const auto own = of.find(address);
  if (own != of.end() && own->second.availability) return *own->second.availability;
  return all.availability.value_or(availability_enabled);
}

Result<BridgeDescription> read_info(std::string_view payload) {
  JsonTree tree;
  const auto object = tree.parse_object(payload, "bridge/info", kMaxMessageBytes);
  if (!object) return fail(object.error());
  BridgeDescription bridge;
  bridge.version = text_at(*object, "version");
  if (const auto coordinator = object_at(*object, "coordinator")) {
    bridge.coordinator = text_at(*coordinator, "type");
    bridge.coordinator_address = address_of(text_at(*coordinator, "ieee_address"));
  }
  if (const auto network = object_at(*object, "network")) bridge.channel = small_count_at(*network, "channel");
  bridge.permit_join = flag_at(*object, "permit_join").value_or(false);
  bridge.permit_join_end = milliseconds_at(*object, "permit_join_end");
  bridge.restart_required = flag_at(*object, "restart_required").value_or(false);
  if (const auto config = object_at(*object, "config")) read_config(*config, bridge);
  return bridge;
}

Result<void> check_version(const BridgeDescription& bridge) {
  const auto text = base::one_line(bridge.version);
  const auto major = base::parse_number<unsigned>(bridge.version.substr(0, bridge.version.find('.')));
  if (!major)
    return fail(ErrorCode::kUnsupported, fmt::format("the version of Zigbee2MQTT cannot be read: '{}'", text));
  if (*major >= 2) return {};
  return fail(ErrorCode::kUnsupported,
              fmt::format("Zigbee2MQTT {} is too old: version 2.0 or later is needed; update it", text));
}

std::string_view to_string(BridgeEvent::Kind kind) {
  using Kind = BridgeEvent::Kind;
  switch (kind) {
    case Kind::kJoined: return "joined";
    case Kind::kInterviewing: return "interviewing";
    case Kind::kInterviewed: return "interviewed";
    case Kind::kFailed: return "failed";
    case Kind::kAnnounced: return "announced";
    case Kind::kLeft: return "left";
    case Kind::kOther: return "other";
  }
  return "other";
}

Result<BridgeEvent> read_event(std::string_view payload) {
  JsonTree tree;
  const auto object = tree.parse_object(payload, "bridge/event", kMaxMessageBytes);
  if (!object) return fail(object.error());
  BridgeEvent event;
  event.type = text_at(*object, "type");
  const auto data = object_at(*object, "data");
  event.kind = kind_of(event.type, data ? text_at(*data, "status") : std::string());
  if (data) {
    event.address = address_of(text_at(*data, "ieee_address"));
    event.name = text_at(*data, "friendly_name");
  }
  if (event.kind == BridgeEvent::Kind::kOther) return event;
  if (event.address.empty())
    return fail(ErrorCode::kInvalid, fmt::format("bridge/event {}: no ieee_address", base::one_line(event.type)));
  if (event.kind == BridgeEvent::Kind::kInterviewed) read_event_definition(*data, event);
  return event;
}

Result<BridgeResponse> read_response(std::string_view payload) {
  JsonTree tree;
  const auto object = tree.parse_object(payload, "bridge/response", kMaxMessageBytes);
  if (!object) return fail(object.error());
  BridgeResponse response;
  response.ok = text_at(*object, "status") == "ok";
  response.transaction = word_at(*object, "transaction");
  if (!response.ok) {
    response.error = base::one_line(text_at(*object, "error"));
    if (response.error.empty()) response.error = "the bridge gave no reason";
  }
  if (object_at(*object, "data")) response.data = json_at(*object, "data");
  if (response.data.empty()) response.data = "{}";
  return response;
}

namespace {

constexpr std::size_t kMaxNodes = 20'000, kMaxLinks = 200'000, kMaxFailed = 8;

NetworkMap::Node read_node(const JsonObject& object) {
  NetworkMap::Node node{
      address_of(text_at(object, "ieeeAddr")), text_at(object, "friendlyName"), text_at(object, "type"),
      text_at(object, "manufacturerName"),     text_at(object, "modelID"),      {}};
  if (const auto definition = object_at(object, "definition")) {
    node.vendor = text_at(*definition, "vendor");
    node.model = text_at(*definition, "model");
  }
  const auto failed = array_at(object, "failed");
  if (!failed) return node;
  for (const auto item : *failed) {
    std::string_view text;
    if (!item.get(text) && node.failed.size() < kMaxFailed) node.failed.emplace_back(text.substr(0, kMaxTextBytes));
  }
  return node;
}

/// `relationship` of the neighbour table (ZigBee specification, section 2.4.4.3.2).
std::string relation_of(const JsonObject& link) {
  constexpr std::string_view kRelations[] = {"parent", "child", "sibling", "none", "previous child"};
  const auto number = member(link, "relationship") ? count_at(link, "relationship") : std::size(kRelations);
  return number < std::size(kRelations) ? std::string(kRelations[number]) : std::string();
}

std::string end_of(const JsonObject& link, std::string_view name) {
  const auto end = object_at(link, name);
  return end ? address_of(text_at(*end, "ieeeAddr")) : std::string();
}

NetworkMap::Link read_link(const JsonObject& link) {
  return {end_of(link, "source"), end_of(link, "target"), small_count_at(link, "linkquality"),
          small_count_at(link, "depth"), relation_of(link)};
}

BridgeHealth::Device read_device_health(const JsonObject& device) {
  return {count_at(device, "messages"), count_at(device, "leave_count"), count_at(device, "network_address_changes"),
          number_at(device, "messages_per_sec")};
}

void read_host_health(const JsonObject& os, BridgeHealth& health) {
  health.host_memory_percent = number_at(os, "memory_percent");
  const auto loads = array_at(os, "load_average");
  double load = 0;
  if (loads && !loads->at(0).get(load)) health.load = load;
}

void read_mqtt_health(const JsonObject& mqtt, BridgeHealth& health) {
  health.mqtt_connected = flag_at(mqtt, "connected").value_or(false);
  health.mqtt_queued = count_at(mqtt, "queued");
  health.mqtt_published = count_at(mqtt, "published");
  health.mqtt_received = count_at(mqtt, "received");
}

void read_devices_health(const JsonObject& devices, BridgeHealth& health) {
  for (const auto field : devices) {
    JsonObject device;
    const auto address = address_of(field.key);
    if (!address.empty() && !field.value.get(device)) health.devices[address] = read_device_health(device);
  }
}

}  // namespace

Result<NetworkMap> read_network_map(std::string_view data) {
  JsonTree tree;
  const auto object = tree.parse_object(data, "network map", kMaxMessageBytes);
  if (!object) return fail(object.error());
  const auto value = object_at(*object, "value");
  if (!value) return fail(ErrorCode::kInvalid, "network map: no value");
  NetworkMap map;
  if (const auto nodes = array_at(*value, "nodes")) {
    for (const auto item : *nodes) {
      JsonObject node;
      if (!item.get(node) && map.nodes.size() < kMaxNodes) map.nodes.push_back(read_node(node));
    }
  }
  if (const auto links = array_at(*value, "links")) {
    for (const auto item : *links) {
      JsonObject link;
      if (!item.get(link) && map.links.size() < kMaxLinks) map.links.push_back(read_link(link));
    }
  }
  return map;
}

Result<BridgeHealth> read_health(std::string_view payload) {
  JsonTree tree;
  const auto object = tree.parse_object(payload, "bridge/health", kMaxMessageBytes);
  if (!object) return fail(object.error());
  BridgeHealth health;
  health.time = milliseconds_at(*object, "response_time");
  if (const auto os = object_at(*object, "os")) read_host_health(*os, health);
  if (const auto process = object_at(*object, "process")) {
    health.memory_mb = number_at(*process, "memory_used_mb");
    health.uptime_seconds = number_at(*process, "uptime_sec");
  }
  if (const auto mqtt = object_at(*object, "mqtt")) read_mqtt_health(*mqtt, health);
  if (const auto devices = object_at(*object, "devices")) read_devices_health(*devices, health);
  return health;
}

}  // namespace rubicon::networks::zigbee::bridge
