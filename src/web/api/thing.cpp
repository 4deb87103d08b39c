#include "web/api/thing.h"

#include <fmt/format.h>

#include "client/json_forms.h"
#include "model/point_keys.h"
#include "web/api/route.h"

namespace rubicon::web::api {

namespace {

using Json = nlohmann::ordered_json;

/// TD 1.1, section 5.3.2.1: the JSON type of the data. Values travel as text, `21.5`.
std::string_view json_type(const model::PointDescription& about) {
  if (about.data_type == "integer") return "integer";
  if (about.data_type == "real") return "number";
  if (about.data_type == "json") return "object";
  return "string";
}

Json schema_of(const model::PointDescription& about) {
  Json schema;
  schema["type"] = json_type(about);
  if (!about.unit.empty() && about.unit != "1") schema["unit"] = about.unit;
  if (about.minimum) schema["minimum"] = *about.minimum;
  if (about.maximum) schema["maximum"] = *about.maximum;
  if (!about.words.empty()) {
    for (const auto& word : about.words) schema["enum"].push_back(word.text);
  }
  return schema;
}

std::string tuple_path(OwnerId island, const std::string& key) {
  return fmt::format("/api/v1/tuples/{}/{}", number(island), key);
}

Json stream_form(OwnerId island, const std::string& key, const char* begin, const char* end) {
  Json form;
  form["op"] = {begin, end};
  form["href"] = "/api/v1/tuples?pattern=" + percent_encoded(fmt::format("{}:{}", number(island), key));
  form["subprotocol"] = "sse";
  form["contentType"] = "text/event-stream";
  return form;
}

Json property_of(OwnerId island, const model::PointKey& key, const model::PointDescription& about, bool is_actuator) {
  auto property = schema_of(about);
  const bool can_read = about.access.find("read") != about.access.npos || about.access.empty();
  const bool can_write = is_actuator || about.access.find("write") != about.access.npos;
  property["readOnly"] = !can_write;
  property["writeOnly"] = !can_read;
  property["observable"] = can_read;
  property["forms"] = Json::array();
  if (can_read) {
    property["forms"].push_back({{"op", {"readproperty"}},
                                 {"href", tuple_path(island, key.value())},
                                 {"htv:methodName", "GET"},
                                 {"contentType", "text/plain"}});
    property["forms"].push_back(stream_form(island, key.value(), "observeproperty", "unobserveproperty"));
  }
  if (can_write) {
    property["forms"].push_back({{"op", {"writeproperty"}},
                                 {"href", tuple_path(island, key.command())},
                                 {"htv:methodName", "PUT"},
                                 {"contentType", "text/plain"}});
  }
  return property;
}

Json event_of(OwnerId island, const model::PointKey& key, const model::PointDescription& about) {
  Json event;
  event["data"] = schema_of(about);
  event["forms"] = {stream_form(island, key.value(), "subscribeevent", "unsubscribeevent")};
  return event;
}

}  // namespace

PointDescriptions point_descriptions(const std::vector<client::Tuple>& tuples, OwnerId island) {
  PointDescriptions points;
  for (const auto& tuple : tuples) {
    const auto key = model::point_of(tuple.key);
    if (tuple.owner != island || !key || !tuple.key.ends_with(".description")) continue;
    if (auto about = model::point_description_from_json(tuple.value)) points[key->text] = std::move(*about);
  }
  return points;
}

Json thing_description(const client::Device& device, const PointDescriptions& points, bool needs_token) {
  const std::string security = needs_token ? "bearer_sc" : "nosec_sc";
  Json thing;
  thing["@context"] = {"https://www.w3.org/2022/wot/td/v1.1", {{"htv", "http://www.w3.org/2011/http#"}}};
  thing["@type"] = "Thing";
  thing["id"] = fmt::format("urn:rubicon:{}:{}", number(device.island), device.key());
  thing["title"] = device.name.empty() ? device.id : device.name;
  if (!device.model.empty()) thing["description"] = device.model;
  thing["securityDefinitions"][security] = {{"scheme", needs_token ? "bearer" : "nosec"}};
  thing["security"] = {security};
  thing["properties"] = Json::object();
  thing["events"] = Json::object();
  for (const auto& place : client::places_of(device)) {
    const auto key = model::DeviceKey{device.key()}.point(place.kind, place.id);
    const auto about = points.find(key.text);
    if (about == points.end()) continue;
    const auto name = fmt::format("{}.{}", to_string(place.kind), place.id);
    if (about->second.report == "event" && place.kind == Kind::kSensor) {
      thing["events"][name] = event_of(device.island, key, about->second);
    } else {
      thing["properties"][name] = property_of(device.island, key, about->second, place.kind == Kind::kActuator);
    }
  }
  return thing;
}

}  // namespace rubicon::web::api
