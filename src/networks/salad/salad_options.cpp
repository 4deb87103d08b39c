#include "networks/salad/salad_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/text.h"
#include "networks/salad/properties_reader.h"
#include "rubicon/key.hpp"
#include "transport/transports.h"

namespace rubicon::networks::salad {

namespace {

constexpr std::size_t kMaxFile = 1 << 20;
constexpr std::size_t kMaxName = 40;
constexpr std::string_view kDevice = "device_";
/// Keys of the original's file (salad.md, section 5). Two of them have no effect: the original never applied the first,
/// and the supervisor decides how long to wait between attempts.
constexpr std::string_view kNoEffect[] = {"socket_accept_timeout_milliseconds", "socket_init_retry_milliseconds"};
constexpr std::string_view kOriginalKeys[] = {"salad_host", "salad_port", "rubicon_port", "socket_buffer_size_bytes",
                                              kNoEffect[0], kNoEffect[1]};

/// SALAD's types (salad.md, section 5.1) and what they are in the catalogue.
struct TypeName {
  std::string_view salad, catalogue;
};
constexpr TypeName kTypes[] = {
    {"sensor.switch", "switch"},
    {"sensor.motion", "motion"},
    {"sensor.pressure", "pressureRaw"},
    {"sensor.soundrecognition", "soundRecognition"},
    {"sensor.soundrecognition.confidence", "soundRecognitionConfidence"},
    {"sensor.status", "status"},
    {"actuator.light", "lamp"},
    {"actuator.relay", "relay"},
    {"actuator.status", "status"},
};

/// Consecutive commas are one; tokens are trimmed.
std::vector<std::string_view> tokens_of(std::string_view line) {
  std::vector<std::string_view> tokens;
  while (!line.empty()) {
    const auto comma = std::min(line.find(','), line.size());
    if (comma > 0) tokens.push_back(base::trimmed(line.substr(0, comma)));
    line.remove_prefix(std::min(comma + 1, line.size()));
  }
  return tokens;
}

std::string known_types() {
  std::string names;
  for (const auto& type : kTypes) names += fmt::format("{}{}", names.empty() ? "" : ", ", type.salad);
  return names;
}

/// SALAD's nine types, and `sensor.` or `actuator.` before any type of the catalogue.
const Type* type_of(std::string_view name, const TypeCatalogue& types) {
  const auto* known =
      std::find_if(std::begin(kTypes), std::end(kTypes), [&](const auto& t) { return t.salad == name; });
  if (known != std::end(kTypes)) return types.find(known->catalogue);
  for (const std::string_view kind : {"sensor.", "actuator."}) {
    if (name.starts_with(kind)) return types.find(name.substr(kind.size()));
  }
  return nullptr;
}

/// Whether it has none of the characters that end a field of a datagram.
bool can_be_sent(std::string_view actuator) {
  return actuator.size() <= 64 && std::all_of(actuator.begin(), actuator.end(), [](char c) {
           return c > ' ' && c < 0x7f && c != ':' && c != '#' && c != ';';
         });
}

/// Adds devices to the options, and their mistakes to the errors.
class Table {
 public:
  Table(SaladOptions& options, const TypeCatalogue& types, ConfigErrors& errors)
      : options_(options), types_(types), errors_(errors) {}

  void add(std::string_view id_text, std::string_view line, const ConfigPlace& place, const std::string& path) {
    const auto id = read_id(base::trimmed(id_text));
    if (!id) {
      errors_.add(place, path, fmt::format("is {}, expected a device id from 1 to 65535", model::quoted(id_text)));
      return;
    }
    auto device = read_device(line, types_);
    if (!device) return errors_.add(place, path, device.error().text);
    const auto [other, fresh] = places_.emplace(*id, place);
    if (!fresh)
      return errors_.add(place, path, fmt::format("device {} is already defined at {}", *id, to_string(other->second)));
    options_.devices.emplace(*id, std::move(*device));
  }

 private:
  SaladOptions& options_;
  const TypeCatalogue& types_;
  ConfigErrors& errors_;
  std::map<DeviceId, ConfigPlace> places_;
};

ConfigNode scalar(std::string text, ConfigPlace place) {
  ConfigNode node;
  node.kind = ConfigNode::Kind::kScalar;
  node.text = std::move(text);
  node.place = std::move(place);
  return node;
}

/// Adds the devices of the file to the table, and its other known keys to the options that do not have them.
void read_file(const std::string& path, std::string_view text, ConfigNode& merged, Table& table, SaladOptions& out,
               ConfigErrors& errors) {
  std::map<std::string, ConfigNode> found;  // the last of two equal keys counts, as in Java
  for (auto& [line, key, value, fault] : read_properties(text)) {
    const ConfigPlace place{path, line, 1};
    if (!fault.empty()) {
      errors.add(place, "", fault);
    } else if (key.starts_with(kDevice)) {
      table.add(key.substr(kDevice.size()), value, place, key);
    } else if (std::find(std::begin(kOriginalKeys), std::end(kOriginalKeys), key) != std::end(kOriginalKeys)) {
      found[key] = scalar(std::string(base::trimmed(value)), place);
    } else if (key != "name") {
      out.unknown_keys.push_back(key);
    }
  }
  for (auto& [key, node] : found) {
    if (merged.find(key) == nullptr) merged.entries.emplace_back(key, std::move(node));
  }
}

/// `7: "FRIDGE, sensor.switch"` or `7: [FRIDGE, sensor.switch]`.
void read_table(ConfigReader& options, Table& table) {
  const auto nested = options.map("table");
  for (const auto& [id, node] : nested.here().entries) {
    const auto path = nested.path() + "." + id;
    std::string line = node.text;
    bool good = node.kind == ConfigNode::Kind::kScalar;
    if (node.kind == ConfigNode::Kind::kList) {
      good = std::all_of(node.items.begin(), node.items.end(),
                         [](const auto& item) { return item.kind == ConfigNode::Kind::kScalar; });
      for (const auto& item : node.items) line += (line.empty() ? "" : ",") + item.text;
    }
    if (good) {
      table.add(id, line, node.place, path);
    } else {
      options.errors().add(node.place, path, "expected name, type and, if it has one, actuator id");
    }
  }
}

void read_line(ConfigReader& options, SaladOptions& out) {
  out.host = base::trimmed(options.text("salad_host", out.host));
  if (const auto fault = base::host_fault(out.host); !fault.empty()) options.error("salad_host", fault);
  out.port = static_cast<std::uint16_t>(options.integer("salad_port", out.port, 1, 65535));
  out.own_port = static_cast<std::uint16_t>(options.integer("rubicon_port", out.own_port, 0, 65535));
  out.buffer = static_cast<std::size_t>(
      options.integer("socket_buffer_size_bytes", static_cast<std::int64_t>(out.buffer), 16, 65536));
  for (const auto key : kNoEffect) options.integer(std::string(key), 1000, 0, 1'000'000'000);
}

}  // namespace

Result<SaladDevice> read_device(std::string_view line, const TypeCatalogue& types) {
  const auto tokens = tokens_of(line);
  if (tokens.size() > 3)
    return fail(ErrorCode::kInvalid,
                fmt::format("has {} parts, expected name, type and at most an actuator id", tokens.size()));
  if (tokens.empty() || tokens[0].empty()) return fail(ErrorCode::kInvalid, "its name is missing");
  if (tokens.size() < 2 || tokens[1].empty()) return fail(ErrorCode::kInvalid, "its type is missing");
  SaladDevice device{std::string(tokens[0]), std::string(tokens[1]), {}, {}, !tokens[1].starts_with("actuator.")};
  if (device.name != model::to_key_part(device.name, kMaxName))
    return fail(ErrorCode::kInvalid, fmt::format("its name is {}, expected at most {} of [A-Za-z0-9_-]",
                                                 model::quoted(device.name), kMaxName));
  const auto* type = type_of(device.type, types);
  if (type == nullptr)
    return fail(ErrorCode::kInvalid,
                fmt::format("its type is {}, expected one of: {}", model::quoted(device.type), known_types()));
  device.type_id = type->id;
  if (tokens.size() < 3) return device;
  device.actuator = tokens[2];
  if (device.actuator.empty() || !can_be_sent(device.actuator))
    return fail(ErrorCode::kInvalid,
                fmt::format("its actuator id is {}, expected printable characters without blank, :, ; and #",
                            model::quoted(device.actuator)));
  return device;
}

SaladOptions read_salad_options(const network::NetworkConfig& config, transport::Transports& transports) {
  ConfigReader& options = config.options;
  auto& errors = options.errors();
  SaladOptions out;
  Table table(out, config.types, errors);
  ConfigNode merged = options.here();
  const auto name = options.text("properties", "");
  if (!name.empty()) {
    const auto path = std::filesystem::path(base::resolve_path(config.directory, name)).lexically_normal().string();
    const auto text = transport::read_text(transports, path, kMaxFile);
    if (text) {
      read_file(path, *text, merged, table, out, errors);
    } else {
      options.error("properties", text.error().text);
    }
  }
  read_table(options, table);
  ConfigReader line(merged, options.path(), errors);
  read_line(line, out);
  for (const auto key : kOriginalKeys) options.node(std::string(key));  // known, and read above
  out.any_source = options.boolean("any_source", false);
  out.start_again = options.duration_or_never("start-again-after", out.start_again);
  if (out.start_again && *out.start_again < std::chrono::milliseconds(100))
    options.error("start-again-after", "expected at least 100ms, or never");
  if (out.devices.empty() && errors.empty())
    options.error("", "has no devices, expected 'table', or 'properties' with the path of a file");
  return out;
}

namespace {

using model::PointId;

/// The symbolic name in lower case: `fridge` (salad.md, section 7).
std::string instance_of(const SaladDevice& device) {
  std::string instance = device.name;
  for (char& c : instance) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return instance;
}

PointId point_of(const SaladDevice& device, Kind kind) {
  return {kind, device.type_id, instance_of(device)};
}

bool is_actuator(const SaladDevice& device) {
  return !device.sensor || !device.actuator.empty();
}

Value typed(const Type& type, const Value& value) {
  const auto* whole = std::get_if<std::int64_t>(&value);
  if (type.data == model::DataType::kBoolean && whole && (*whole == 0 || *whole == 1)) return Value(*whole == 1);
  const auto* digits = std::get_if<std::string>(&value);
  if (type.data != model::DataType::kReal || !digits) return value;
  return Value(base::parse_number<double>(*digits).value_or(0));
}

}  // namespace

model::Join join_of(const SaladDevice& device) {
  model::Join join;
  join.name = device.name;
  join.model = "SALAD " + device.type;
  join.heard = false;
  if (device.sensor) join.capabilities.emplace_back().point = point_of(device, Kind::kSensor);
  if (!is_actuator(device)) return join;
  auto& actuator = join.capabilities.emplace_back();
  actuator.point = point_of(device, Kind::kActuator);
  actuator.access = device.actuator.empty() ? model::Access::kRead : model::Access::kReadWrite;
  return join;
}

model::Updates updates_of(const SaladDevice& device, const Type& type, const Value& value) {
  model::Updates updates;
  if (device.sensor) updates.readings.push_back({point_of(device, Kind::kSensor), typed(type, value), {}});
  if (is_actuator(device)) updates.readings.push_back({point_of(device, Kind::kActuator), typed(type, value), {}});
  return updates;
}

Result<std::int64_t> command_of(const SaladDevice& device, const Type& type, const model::Actuate& command) {
  if (command.point != point_of(device, Kind::kActuator) || !is_actuator(device))
    return fail(ErrorCode::kNotFound, fmt::format("{} has no such actuator", device.name));
  if (device.actuator.empty())
    return fail(ErrorCode::kRefused,
                fmt::format("{} has no actuator id, so SALAD takes no commands for it", device.name));
  if (auto fits = TypeCatalogue::check(type, command.value); !fits) return fail(fits.error());
  if (const auto* on = std::get_if<bool>(&command.value)) return *on ? 1 : 0;
  if (const auto* whole = std::get_if<std::int64_t>(&command.value)) return *whole;
  const auto* real = std::get_if<double>(&command.value);
  if (real && std::floor(*real) == *real && std::abs(*real) < 1e15) return static_cast<std::int64_t>(*real);
  return fail(ErrorCode::kOutOfRange, fmt::format("{}: SALAD takes whole numbers only", device.name));
}

}  // namespace rubicon::networks::salad
