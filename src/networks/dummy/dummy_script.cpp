#include "networks/dummy/dummy_script.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::networks::dummy {

namespace {

using namespace std::chrono_literals;
using model::Access;
using model::Capability;

/// More would be a mistake, and each costs memory.
constexpr std::size_t kMaxDevices = 20000;
constexpr std::int64_t kUsualRate = 1000;

/// Reads one `simulate` map.
class DeviceReader {
 public:
  DeviceReader(const TypeCatalogue& types, std::uint64_t seed) : types_(types), seed_(seed) {}

  DeviceScript read(const std::string& address, ConfigReader& options);

 private:
  const Type* type_of(const std::string& id, ConfigReader& options, Kind kind, Capability& capability);
  void read_sensors(DeviceScript& device, ConfigReader& options);
  void read_actuators(DeviceScript& device, ConfigReader& options);
  void read_followed(DeviceScript& device, ConfigReader& options, ActuatorScript& actuator);
  void read_properties(DeviceScript& device, ConfigReader& options);

  const TypeCatalogue& types_;
  std::uint64_t seed_;
};

DeviceScript DeviceReader::read(const std::string& address, ConfigReader& options) {
  DeviceScript device;
  device.address = address;
  device.name = options.text("name", "");
  device.model = options.text("model", "");
  device.type = options.text("type", "");
  device.join = options.duration("join", 0s);
  if (options.has("leave")) device.leave = options.duration("leave", 0s);
  if (options.has("rejoin")) device.rejoin = options.duration("rejoin", 0s);
  if (device.leave && *device.leave <= device.join) options.error("leave", "is not after join");
  if (device.rejoin && (!device.leave || *device.rejoin <= *device.leave))
    options.error("rejoin", "is not after leave");
  device.keep_alive = options.duration("keepalive", 10s);
  if (device.keep_alive <= 0s) options.error("keepalive", "expected more than nothing");
  read_sensors(device, options);
  read_actuators(device, options);
  read_properties(device, options);
  options.finish();
  return device;
}

/// `temperature-1`: the type up to the last `-`, then the instance.
const Type* DeviceReader::type_of(const std::string& id, ConfigReader& options, Kind kind, Capability& capability) {
  const auto dash = id.find('-');
  const Type* type = types_.find(std::string_view(id).substr(0, dash));
  if (dash == id.npos || dash + 1 == id.size())
    options.error("", "expected a type and an instance, as in temperature-1");
  else if (type == nullptr)
    options.error("", fmt::format("there is no type {}", id.substr(0, dash)));
  if (type == nullptr || dash == id.npos) return nullptr;
  capability.point = {kind, type->id, id.substr(dash + 1)};
  return type;
}

void DeviceReader::read_sensors(DeviceScript& device, ConfigReader& options) {
  for (auto& [id, reader] : options.maps("sensors")) {
    Capability capability;
    const Type* type = type_of(id, reader, Kind::kSensor, capability);
    if (type == nullptr) continue;
    device.sensors.push_back({capability, Wave::read(reader, *type, seed_of(seed_of(seed_, device.address), id))});
    reader.finish();
  }
}

void DeviceReader::read_actuators(DeviceScript& device, ConfigReader& options) {
  using Behaviour = ActuatorScript::Behaviour;
  for (auto& [id, reader] : options.maps("actuators")) {
    ActuatorScript actuator;
    const Type* type = type_of(id, reader, Kind::kActuator, actuator.capability);
    if (type == nullptr) continue;
    actuator.type = type;
    if (reader.has("value")) {
      auto value = TypeCatalogue::parse(*type, reader.text("value", ""));
      if (!value) reader.error("value", value.error().text);
      actuator.capability.initial = value.value_or(Value{});
    }
    const std::string behaviour = reader.choice("behaviour", "obey", {"obey", "ignore", "fail", "silent"});
    actuator.behaviour = behaviour == "ignore"   ? Behaviour::kIgnore
                         : behaviour == "fail"   ? Behaviour::kFail
                         : behaviour == "silent" ? Behaviour::kSilent
                                                 : Behaviour::kObey;
    actuator.capability.access = Access::kReadWrite;
    actuator.capability.deadline = 0s;
    actuator.capability.reports = actuator.behaviour != Behaviour::kSilent;
    actuator.delay = reader.duration("delay", 0s);
    read_followed(device, reader, actuator);
    reader.finish();
    device.actuators.push_back(std::move(actuator));
  }
}

void DeviceReader::read_followed(DeviceScript& device, ConfigReader& options, ActuatorScript& actuator) {
  const std::string sensor = options.text("sensor", "");
  if (sensor.empty()) return;
  Capability followed;
  if (type_of(sensor, options, Kind::kSensor, followed) == nullptr) return;
  for (const SensorScript& one : device.sensors) {
    if (one.capability.point == followed.point) actuator.sensor = followed.point;
  }
  if (!actuator.sensor) options.error("sensor", "is no sensor of this device");
}

PropertyScript property_of(const Type& type, Value value) {
  PropertyScript property;
  property.capability.point = {Kind::kProperty, type.id, {}};
  property.capability.access = Access::kReadWrite;
  property.capability.initial = std::move(value);
  property.type = &type;
  return property;
}

void DeviceReader::read_properties(DeviceScript& device, ConfigReader& options) {
  ConfigReader properties = options.map("properties");
  for (const std::string& name : properties.keys()) {
    const std::string text = properties.text(name, "");
    const Type* type = types_.find(name);
    if (type == nullptr) {
      properties.error(name, "is no type");
      continue;
    }
    auto value = TypeCatalogue::parse(*type, text);
    if (!value) properties.error(name, value.error().text);
    device.properties.push_back(property_of(*type, value.value_or(Value{})));
  }
  const Type* rate = types_.find("rate");
  if (rate != nullptr && !properties.has("rate")) device.properties.push_back(property_of(*rate, kUsualRate));
}

}  // namespace

Script read_script(const network::NetworkConfig& config) {
  Script script;
  ConfigReader& options = config.options;
  script.seed = static_cast<std::uint64_t>(options.integer("seed", 1, 0));
  DeviceReader reader(config.types, script.seed);
  auto devices = options.maps("simulate");
  if (devices.size() > kMaxDevices) {
    options.error("simulate", fmt::format("{} devices, expected at most {}", devices.size(), kMaxDevices));
    devices.clear();
  }
  for (auto& [address, device] : devices) {
    script.devices.push_back(reader.read(address, device));
    script.devices.back().written = device.here();
  }
  ConfigReader line = options.map("line");
  if (line.has("down-at")) script.down_at = line.duration("down-at", 0s);
  if (line.has("up-at")) script.up_at = line.duration("up-at", 0s);
  if (script.up_at && (!script.down_at || *script.up_at <= *script.down_at))
    line.error("up-at", "is not after down-at");
  line.finish();
  return script;
}

}  // namespace rubicon::networks::dummy
