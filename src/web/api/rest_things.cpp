#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "client/json_forms.h"
#include "client/points.h"
#include "model/point_keys.h"
#include "model/point_tuples.h"
#include "rubicon/client.hpp"
#include "web/api/route.h"
#include "web/exchange.h"

namespace rubicon::web::api {

/// The descriptions of points, by the key of the point.
using PointDescriptions = std::map<std::string, model::PointDescription, std::less<>>;
/// The tuples of one island.
PointDescriptions point_descriptions(const std::vector<client::Tuple>& tuples, OwnerId island);

/// The device as a W3C Web of Things Thing Description 1.1: points with a state are properties, points with events are
/// events. Addresses are relative to the address of the description.
nlohmann::ordered_json thing_description(const client::Device& device, const PointDescriptions& points,
                                         bool needs_token);

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

namespace {

constexpr const char* kThingType = "application/td+json";

std::string id_of_thing(const client::Device& device) {
  return fmt::format("{}:{}", number(device.island), device.key());
}

}  // namespace

std::unique_ptr<Exchange> list_things(Call& call) {
  const auto range = read_range(call.query);
  if (auto good = call.may_read({std::nullopt, "**"}); !good) return call.refuse(good.error());
  auto patterns = device_patterns({});
  patterns.push_back({std::nullopt, model::any_point().description()});
  for (const auto& pattern : patterns) call.context.recent_reads.keep(pattern);
  const bool needs_token = call.context.access.rules().needs_token;
  return call.read(patterns, [range, needs_token, request = call.request](const std::vector<client::Tuple>& tuples) {
    std::map<OwnerId, PointDescriptions> points;
    const auto describe = [&](const client::Device& device) {
      const auto known = points.find(device.island);
      if (known == points.end()) points[device.island] = point_descriptions(tuples, device.island);
      return thing_description(device, points[device.island], needs_token);
    };
    return json_response(page_of("things", client::devices_from(tuples, {}), request, range, id_of_thing, describe));
  });
}

std::unique_ptr<Exchange> describe_thing(Call& call) {
  std::string_view id = call.parts[0];
  constexpr std::string_view kUrn = "urn:rubicon:";
  if (id.starts_with(kUrn)) id.remove_prefix(kUrn.size());
  const auto device = Pattern::parse(id);
  if (!device || !device->owner || !device->exact())
    return call.refuse(
        {ErrorCode::kInvalid, fmt::format("thing {}: expected an id such as 6541:proxy.wsn-1.7", model::quoted(id))});
  const Pattern all{device->owner, device->key + ".**"};
  if (auto good = call.may_read(all); !good) return call.refuse(good.error());
  const bool needs_token = call.context.access.rules().needs_token;
  return call.read(std::vector{all}, [needs_token, id = *device](const std::vector<client::Tuple>& tuples) {
    const auto found = client::devices_from(tuples, {});
    if (found.size() != 1 || found.front().key() != id.key)
      return error_response({ErrorCode::kNotFound, fmt::format("no thing {}", to_string(id))});
    auto thing = thing_description(found.front(), point_descriptions(tuples, *id.owner), needs_token);
    auto response = json_response(thing);
    response.content_type = kThingType;
    return response;
  });
}

}  // namespace rubicon::web::api
