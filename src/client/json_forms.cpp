#include "client/json_forms.h"

#include "model/json_members.h"
#include "model/point_keys.h"
#include "tuples/tuple_json.h"

namespace rubicon::client {

using Line = nlohmann::ordered_json;

Line device_json(const Device& device) {
  Line line;
  line["island"] = number(device.island);
  line["key"] = device.key();
  line["network"] = device.network;
  line["id"] = device.id;
  line["name"] = device.name;
  line["area"] = device.area;
  line["model"] = device.model;
  line["type"] = device.type;
  line["address"] = device.address;
  line["status"] = device.status;
  line["since"] = base::to_seconds(device.since);
  line["reason"] = device.reason;
  line["line"] = device.line.line;
  line["line_reason"] = device.line.reason;
  line["sensors"] = device.sensors;
  line["actuators"] = device.actuators;
  line["properties"] = device.properties;
  return line;
}

std::vector<Place> places_of(const Device& device) {
  std::vector<Place> points;
  for (const auto& id : device.sensors) points.push_back({Kind::kSensor, id});
  for (const auto& id : device.actuators) points.push_back({Kind::kActuator, id});
  for (const auto& id : device.properties) points.push_back({Kind::kProperty, id});
  return points;
}

Line place_json(const Device& device, const Place& place, const PlaceTexts& texts) {
  Line line;
  line["kind"] = to_string(place.kind);
  line["id"] = place.id;
  line["key"] = model::DeviceKey{device.key()}.point(place.kind, place.id).text;
  line["value"] = texts.value;
  line["status"] = model::object_of(texts.status);
  line["description"] = model::object_of(texts.description);
  return line;
}

Line whole_tuple_json(const Tuple& tuple) {
  auto line = tuples::tuple_json({tuple.owner, tuple.key, tuple.value, tuple.media_type, tuple.creator, tuple.sequence,
                                  tuple.write_time, tuple.user_time, tuple.expire_time, tuple.owner_present});
  line["creator"] = number(tuple.creator);
  line["expire"] = base::to_seconds(tuple.expire_time);
  if (!tuple.owner_present) line["present"] = false;
  return line;
}

}  // namespace rubicon::client
