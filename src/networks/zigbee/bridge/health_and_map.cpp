#include "networks/zigbee/bridge/device_record.h"
#include "networks/zigbee/bridge/json_tree.h"
#include "networks/zigbee/bridge/messages.h"

namespace rubicon::networks::zigbee::bridge {
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
