#include "networks/dummy/dummy_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "base/text.h"
#include "model/type_catalogue.h"
#include "model/type_names.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::dummy {

namespace {

constexpr std::size_t kMaxDigits = 9;

std::optional<std::size_t> whole_number(std::string_view text) {
  return text.size() > kMaxDigits ? std::nullopt : base::parse_number<std::size_t>(text);
}

}  // namespace

Result<DeviceRange> DeviceRange::parse(std::string_view key) {
  DeviceRange range;
  const auto open = key.find('{');
  const auto dots = key.find("..", open);
  const auto close = key.find('}', dots);
  if (open == key.npos || dots == key.npos || close == key.npos) {
    range.before_ = key;
    return range;
  }
  const auto from = key.substr(open + 1, dots - open - 1);
  const auto to = key.substr(dots + 2, close - dots - 2);
  const auto first = whole_number(from), last = whole_number(to);
  if (!first || !last || *first > *last || key.find('{', close) != key.npos)
    return fail(
        ErrorCode::kInvalid,
        fmt::format("is {}, expected one range of whole numbers, for example room-{{1..100}}", model::quoted(key)));
  range.before_ = key.substr(0, open);
  range.after_ = key.substr(close + 1);
  range.first_ = *first;
  range.last_ = *last;
  range.digits_ = from.starts_with('0') ? from.size() : 0;
  range.is_range_ = true;
  return range;
}

std::string DeviceRange::number(std::size_t index) const {
  return fmt::format("{:0{}}", first_ + index, digits_);
}

std::string DeviceRange::name(const std::string& text, std::size_t index) const {
  const auto at = text.find("{n}");
  if (!is_range_ || at == text.npos) return text;
  return text.substr(0, at) + number(index) + text.substr(at + 3);
}

namespace {

using namespace std::chrono_literals;
using model::Access;
using model::Capability;

constexpr std::int64_t kDefaultRate = 1000;

/// Reads one entry of `simulate`.
class DeviceReader {
 public:
  explicit DeviceReader(const TypeCatalogue& types) : types_(types) {}

  DeviceScript read(ConfigReader& options);

 private:
  const Type* type_of(const std::string& id, ConfigReader& options, Kind kind, Capability& capability);
  void read_sensors(DeviceScript& device, ConfigReader& options);
  void read_actuators(DeviceScript& device, ConfigReader& options);
  void read_followed(DeviceScript& device, ConfigReader& options, ActuatorScript& actuator);
  void read_properties(DeviceScript& device, ConfigReader& options);

  const TypeCatalogue& types_;
};

DeviceScript DeviceReader::read(ConfigReader& options) {
  DeviceScript device;
  device.model = options.text("model", "");
  device.type = options.text("type", "");
  device.join = options.duration("join", 0s);
  if (options.has("leave")) device.leave = options.duration("leave", 0s);
  if (options.has("rejoin")) device.rejoin = options.duration("rejoin", 0s);
  if (device.leave && *device.leave <= device.join) options.error("leave", "is not after join");
  if (device.rejoin && (!device.leave || *device.rejoin <= *device.leave))
    options.error("rejoin", "is not after leave");
  device.keep_alive = options.duration("keepalive", 10s);
  if (device.keep_alive <= 0s) options.error("keepalive", "expected more than 0s");
  read_sensors(device, options);
  read_actuators(device, options);
  read_properties(device, options);
  options.finish();
  device.digest = std::hash<std::string>()(base::packed(options.here()));
  return device;
}

/// `temperature-1`: the type up to the last `-`, then the instance.
const Type* DeviceReader::type_of(const std::string& id, ConfigReader& options, Kind kind, Capability& capability) {
  const auto dash = id.find('-');
  const Type* type = types_.find(std::string_view(id).substr(0, dash));
  if (dash == id.npos || dash + 1 == id.size())
    options.error("", "expected a type and an instance, as in temperature-1");
  else if (type == nullptr)
    options.error("", model::unknown_type_text(types_, std::string_view(id).substr(0, dash)));
  if (type == nullptr || dash == id.npos) return nullptr;
  capability.point = {kind, type->id, id.substr(dash + 1)};
  return type;
}

void DeviceReader::read_sensors(DeviceScript& device, ConfigReader& options) {
  for (auto& [id, reader] : options.maps("sensors")) {
    Capability capability;
    const Type* type = type_of(id, reader, Kind::kSensor, capability);
    if (type == nullptr) continue;
    const bool twice = std::any_of(device.sensors.begin(), device.sensors.end(),
                                   [&](const SensorScript& one) { return one.capability.point == capability.point; });
    if (twice) reader.error("", fmt::format("is a second {}-{} of the device", type->name, capability.point.instance));
    device.sensors.push_back({id, capability, Wave::read(reader, *type)});
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
  if (!actuator.sensor) options.error("sensor", "is not a sensor of this device");
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
    const Type* type = types_.find(name == model::kSamplingRate ? "rate" : name);
    if (type == nullptr) {
      properties.error(name, model::unknown_type_text(types_, name));
      continue;
    }
    auto value = TypeCatalogue::parse(*type, text);
    if (!value) properties.error(name, value.error().text);
    device.properties.push_back(property_of(*type, value.value_or(Value{})));
  }
  const Type* rate = types_.find("rate");
  const bool named = properties.has("rate") || properties.has(std::string(model::kSamplingRate));
  if (rate != nullptr && !named) device.properties.push_back(property_of(*rate, kDefaultRate));
}

void add_devices(const DeviceRange& range, DeviceReader& reader, ConfigReader& options, Script& script,
                 std::set<std::string>& taken) {
  const auto name = options.text("name", "");
  const auto shared = std::make_shared<const DeviceScript>(reader.read(options));
  for (std::size_t i = 0; i < range.count(); ++i) {
    auto address = range.address(i);
    if (!taken.insert(address).second) {
      options.error("", fmt::format("a second device has the address {}", address));
      return;
    }
    const auto share = static_cast<Duration::rep>(i + 1);
    const auto first = shared->keep_alive / static_cast<Duration::rep>(range.count()) * share;
    const auto seed = seed_of(script.seed, address);
    script.devices.push_back({std::move(address), range.name(name, i), seed, shared, first});
  }
}

}  // namespace

Script read_script(const network::NetworkConfig& config) {
  Script script;
  ConfigReader& options = config.options;
  script.seed = static_cast<std::uint64_t>(options.integer("seed", 1, 0));
  DeviceReader reader(config.types);
  std::set<std::string> taken;
  for (auto& [key, device] : options.maps("simulate")) {
    const auto range = DeviceRange::parse(key);
    if (!range) {
      device.error("", range.error().text);
    } else if (range->count() > 1 && range->count() + script.devices.size() > config.most_devices) {
      device.error("", fmt::format("{} devices beside {} others, expected at most limits.devices, {}", range->count(),
                                   script.devices.size(), config.most_devices));
    } else {
      add_devices(*range, reader, device, script, taken);
    }
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
