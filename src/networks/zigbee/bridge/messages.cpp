#include "networks/zigbee/bridge/messages.h"

#include <fmt/format.h>

#include "base/printable.h"
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

}  // namespace rubicon::networks::zigbee::bridge
