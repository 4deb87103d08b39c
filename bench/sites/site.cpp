#include "sites/site.h"

#include <fmt/format.h>

#include <chrono>

#include "components/node.h"
#include "model/point_tuples.h"

namespace rubicon::bench::sites {

namespace {

constexpr int kOneLampOf = 10;
constexpr const char* kNetwork = "proxy.zigbee";

bool is_lamp(int device) {
  return device % kOneLampOf == 0;
}

std::string device_key(int device) {
  return fmt::format("{}.0x00124b0024c{:05x}", kNetwork, device);
}

void set(TupleSpace& space, const std::string& key, const std::string& value) {
  SetOptions options;
  if (value.starts_with('{')) options.media_type = "application/json";
  if (const auto done = space.set(key, value, options); !done) give_up(done.error().text);
}

void add_point(TupleSpace& space, const std::string& key, const std::string& value, bool is_lamp) {
  model::PointDescription about;
  about.type = is_lamp ? "lamp" : "temperature";
  about.quantity = is_lamp ? "switch" : "temperature";
  about.unit = is_lamp ? "1" : "degC";
  about.data_type = is_lamp ? "bool" : "number";
  about.access = is_lamp ? "write" : "read";
  about.report = "state";
  about.instance = "1";
  set(space, key + ".value", value);
  set(space, key + ".status",
      R"({"quality":"good","since":1790000000.125,"heard":1790000123.5,"changed":1790000123.5,"reason":""})");
  set(space, key + ".description", model::point_description_to_json(about));
  if (is_lamp) set(space, key + ".command", "");
}

void add_device(TupleSpace& space, int device) {
  const auto key = device_key(device);
  const bool lamp = is_lamp(device);
  const std::string point = lamp ? "lamp-1" : "temperature-1";
  model::DeviceDescription about;
  about.name = fmt::format("{} of room {}", lamp ? "Lamp" : "Thermometer", device);
  about.area = fmt::format("Room {}", device);
  about.model = lamp ? "TRADFRI bulb E27 WS" : "WSDCGQ11LM";
  about.type = about.model;
  about.address = key.substr(key.rfind('.') + 1);
  about.network = "zigbee";
  about.capabilities = {lamp ? "lamp" : "temperature"};
  (lamp ? about.actuators : about.sensors) = {point};
  set(space, key + ".description", model::device_description_to_json(about));
  set(space, key + ".status", R"({"status":"reachable","since":1790000000.125,"reason":""})");
  add_point(space, fmt::format("{}.{}.{}", key, lamp ? "actuator" : "sensor", point), lamp ? "off" : "21.5", lamp);
}

}  // namespace

Site::Site(TupleSpace& space, int devices) {
  for (int device = 0; device < devices; ++device) add_device(space, device);
  set(space, std::string(kNetwork) + ".status",
      R"({"line":"up","since":1790000000.125,"reason":"","attempts":1,"next_attempt":0})");
  lamps_ = space.add_policy({space.self(), "proxy.*.*.actuator.*.command"},
                            [](const tuples::RemoteSet&) { return tuples::SetDecision::applied(); });
  Summary summary;
  summary.name = fmt::format("Site {}", number(space.self()));
  summary.host = fmt::format("host-{}", number(space.self()));
  summary.program = "rubicon-proxy 0.1.0";
  summary.prefix = "proxy";
  summary.networks["zigbee"] = static_cast<std::uint64_t>(devices);
  if (const auto done = space.describe(model::to_json(summary)); !done) give_up(done.error().text);
}

int Site::thermometers(int devices) {
  return devices - (devices + kOneLampOf - 1) / kOneLampOf;
}

std::string Site::lamp_command() {
  return device_key(0) + ".actuator.lamp-1.command";
}

}  // namespace rubicon::bench::sites
