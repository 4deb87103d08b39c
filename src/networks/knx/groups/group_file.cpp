#include "networks/knx/groups/group_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "base/text.h"
#include "model/value.h"
#include "networks/knx/groups/infer_points.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::knx::groups {

namespace {

constexpr std::string_view kStore = "store ";
constexpr std::size_t kMaxNameBytes = 64;
constexpr std::uint8_t kNumberBits = 0x3f, kStoreBit = 0x80;

bool stores(dpt::DptId type) {
  return type.main == 18;
}

}  // namespace

bool has_scenes(dpt::DptId type) {
  return type.main == 17 || type.main == 18;
}

std::string_view scene_name_fault(std::string_view name) {
  if (name.empty() || name.size() > kMaxNameBytes) return "expected a name of 1 to 64 bytes";
  if (model::plain_word(name).empty()) return "expected a name with a letter or digit";
  if (base::parse_number<double>(name)) return "expected a name, which is not a number";
  const auto first = name.substr(0, kStore.size());
  if (model::same_word(first, kStore)) return "expected a name that does not begin with 'store'";
  return {};
}

std::vector<model::Word> scene_words(dpt::DptId type, const SceneNames& names) {
  std::vector<model::Word> words;
  for (const auto& [number, name] : names) words.push_back({number, name});
  for (std::uint32_t number = 1; stores(type) && number <= kMaxScenes; ++number) {
    const auto name = names.find(static_cast<std::uint8_t>(number));
    words.push_back(
        {kStores + number, std::string(kStore) + (name == names.end() ? std::to_string(number) : name->second)});
  }
  return words;
}

std::uint32_t most_scene_number(dpt::DptId type) {
  return stores(type) ? kStores + kMaxScenes : kMaxScenes;
}

Value scene_value(dpt::DptId type, const std::vector<model::Word>& words, std::uint8_t byte) {
  const bool is_stored = stores(type) && (byte & kStoreBit) != 0;
  const auto number = (byte & kNumberBits) + 1U + (is_stored ? kStores : 0U);
  const auto word = std::find_if(words.begin(), words.end(), [&](const auto& one) { return one.value == number; });
  return word == words.end() ? Value(std::int64_t{number}) : Value(word->text);
}

Result<wire::Payload> scene_payload(dpt::DptId type, const std::vector<model::Word>& words, const Value& value) {
  const auto* whole = std::get_if<std::int64_t>(&value);
  const auto* text = std::get_if<std::string>(&value);
  auto number = text ? model::value_of_word(words, *text) : std::nullopt;
  if (whole && *whole >= 0 && *whole <= most_scene_number(type)) number = static_cast<std::uint32_t>(*whole);
  const auto scene = number ? *number & (kStores - 1) : 0U;
  const bool is_stored = number && *number > kStores;
  if (scene < 1 || scene > kMaxScenes || *number > most_scene_number(type))
    return fail(text ? ErrorCode::kInvalid : ErrorCode::kOutOfRange,
                fmt::format("{} is not a scene, expected a name or a number from 1 to {}{}",
                            model::quoted(model::to_text(value)), kMaxScenes,
                            stores(type) ? ", or 'store' and one of both" : ""));
  return wire::Payload{{static_cast<std::uint8_t>((scene - 1) | (is_stored ? kStoreBit : 0U))}, false};
}

namespace {

using NamesByGroup = std::map<std::string, std::string>;

/// One entry of `groups`.
class PointReader {
 public:
  PointReader(ConfigErrors& errors, const NamesByGroup& names, std::string path)
      : errors_(errors), names_(names), path_(std::move(path)) {}

  std::optional<GroupPoint> read(std::string_view key, const ConfigPlace& place, const ConfigNode& node) {
    const auto before = errors_.lines().size();
    GroupPoint point;
    if (const auto address = wire::parse_group(key)) {
      point.address = *address;
    } else {
      errors_.add(place, path_, address.error().text);
    }
    take_group_names(point);
    if (node.kind == ConfigNode::Kind::kScalar) {
      point.dpt = type(node.place, path_, node.text);
      point.kind = kind_of_type(point.dpt);
    } else {
      ConfigReader reader(node, path_, errors_);
      read_map(reader, point);
      reader.finish();
    }
    if (errors_.lines().size() != before) return {};
    return point;
  }

 private:
  void take_group_names(GroupPoint& point) const {
    const auto value = number(point.address);
    const auto main = names_.find(fmt::format("{}", value >> 11));
    const auto middle = names_.find(fmt::format("{}/{}", value >> 11, value >> 8 & 7));
    if (main != names_.end()) point.main_group = main->second;
    if (middle != names_.end()) point.middle_group = middle->second;
  }

  std::optional<dpt::DptId> type(const ConfigPlace& place, const std::string& path, const std::string& text) {
    const auto id = dpt::parse_dpt(text);
    const auto* known = id ? dpt::find_dpt(*id) : nullptr;
    if (known && (known->id.sub != dpt::DptId::kMainOnly || id->sub == dpt::DptId::kMainOnly)) return *id;
    errors_.add(place, path,
                known
                    ? fmt::format("type {} is not known, expected one of main type {}, or {}.* for any of it",
                                  to_string(*id), id->main, id->main)
                    : fmt::format("{} is not a data point type, expected one like 9.001 or 9.*", model::quoted(text)));
    return {};
  }

  std::optional<wire::GroupAddress> address(ConfigReader& reader, const std::string& key, const std::string& text) {
    const auto address = wire::parse_group(text);
    if (address) return *address;
    reader.error(key, address.error().text);
    return {};
  }

  void read_map(ConfigReader& reader, GroupPoint& point) {
    if (const auto* node = reader.node("dpt")) {
      point.dpt = type(node->place, reader.path() + ".dpt", reader.text("dpt", ""));
    }
    if (reader.has("state")) point.state = address(reader, "state", reader.required_text("state"));
    point.state_name = reader.text("state-name", "");
    if (!point.state && reader.has("state-name")) reader.error("state-name", "is given without 'state'");
    const auto by_type = point.state ? Kind::kActuator : kind_of_type(point.dpt);
    const auto kind = reader.choice("kind", to_string(by_type), {"sensor", "actuator"});
    point.kind = kind == "actuator" ? Kind::kActuator : Kind::kSensor;
    if (point.state && point.kind == Kind::kSensor)
      reader.error("state", "is only for actuators: the values of a sensor come from its address");
    if (point.state == point.address)
      reader.error("state", "is the address of the point, expected another one or none");
    for (const auto& text : reader.texts("listen")) {
      if (const auto heard = address(reader, "listen", text)) point.listen.push_back(*heard);
    }
    point.device = key_part(reader, "device", "");
    point.device_name = reader.text("device-name", "");
    point.instance = key_part(reader, "instance", "1");
    point.name = reader.text("name", "");
    point.description = reader.text("description", "");
    point.room = reader.text("room", "");
    point.main_group = reader.text("main", point.main_group);
    point.middle_group = reader.text("middle", point.middle_group);
    const auto rule = parse_read_rule(reader.text("read", "demand"));
    if (!rule) reader.error("read", "expected demand, init, never, expire 60min or every 5min");
    point.read = rule.value_or(ReadRule{});
    if (reader.has("scenes")) point.scenes = read_scenes(reader, point.dpt);
  }

  /// `{1: evening, 2: cinema}`; none are named by `{}`.
  static SceneNames read_scenes(ConfigReader& reader, const std::optional<dpt::DptId>& type) {
    SceneNames names;
    std::set<std::string> words;
    if (!type || !has_scenes(*type)) reader.error("scenes", "is only for the types 17.001 and 18.001");
    auto map = reader.map("scenes");
    for (const auto& key : map.keys()) {
      const auto name = map.text(key, "");
      const auto number = base::parse_number<std::uint8_t>(key);
      if (!number || *number < 1 || *number > kMaxScenes)
        map.error(key, "is not a number of a scene, expected 1 to 64, as ETS shows it");
      if (const auto fault = scene_name_fault(name); !fault.empty())
        map.error(key, fmt::format("is {}: {}", model::quoted(name), fault));
      if (!words.insert(model::plain_word(name)).second)
        map.error(key, fmt::format("{} is the name of another scene too", model::quoted(name)));
      if (number) names.emplace(*number, name);
    }
    return names;
  }

  static std::string key_part(ConfigReader& reader, const std::string& key, std::string_view otherwise) {
    auto text = reader.text(key, otherwise);
    const bool individual = key == "device" && wire::parse_individual(text).has_value();
    if (reader.has(key) && !individual && text != model::to_key_part(text))
      reader.error(key, fmt::format("is {}, expected at most 64 letters, digits, - and _", model::quoted(text)));
    return text;
  }

  ConfigErrors& errors_;
  const NamesByGroup& names_;
  std::string path_;
};

/// Finds conflicts between points.
class Claims {
 public:
  /// The conflict of a point with those before it; if there is none (empty), the point is added to them.
  std::string take(const GroupPoint& point) {
    const auto mine = to_string(point.address);
    if (addresses_.contains(point.address)) return fmt::format("{} is already in the list", mine);
    if (point.state) {
      if (const auto first = states_.find(*point.state); first != states_.end())
        return fmt::format("{} is already the state address of {}", to_string(*point.state), to_string(first->second));
    }
    if (const auto first = keys_.find(key_of(point)); first != keys_.end())
      return fmt::format(
          "has the same device, kind, type and instance as {}: both would have the same key, give one of them "
          "another instance",
          to_string(first->second));
    addresses_.insert(point.address);
    if (point.state) states_.emplace(*point.state, point.address);
    keys_.emplace(key_of(point), point.address);
    return {};
  }

 private:
  using Key = std::tuple<std::string, Kind, TypeId, std::string>;

  static Key key_of(const GroupPoint& point) {
    const auto* type = point.dpt ? dpt::find_dpt(*point.dpt) : nullptr;
    const auto id = !type                           ? TypeId{}
                    : point.scenes                  ? kNamedScene
                    : point.kind == Kind::kActuator ? type->actuator
                                                    : type->sensor;
    return {point.device.empty() ? wire::to_key_part(point.address) : point.device, point.kind, id, point.instance};
  }

  std::set<wire::GroupAddress> addresses_;
  std::map<wire::GroupAddress, wire::GroupAddress> states_;
  std::map<Key, wire::GroupAddress> keys_;
};

NamesByGroup read_group_names(ConfigReader& reader) {
  NamesByGroup names;
  auto map = reader.map("group-names");
  for (const auto& key : map.keys()) names.emplace(key, map.text(key, ""));
  return names;
}

}  // namespace

void read_groups(ConfigReader& reader, std::vector<GroupPoint>& out) {
  const auto names = read_group_names(reader);
  auto map = reader.map("groups");
  const auto& groups = map.here();
  auto& errors = reader.errors();
  Claims claims;
  for (const auto& [key, node] : groups.entries) {
    const auto path = map.path() + "." + key;
    auto point = PointReader(errors, names, path).read(key, node.key_place(), node);
    if (!point) continue;
    if (const auto wrong = claims.take(*point); !wrong.empty()) {
      errors.add(node.key_place(), path, wrong);
    } else {
      out.push_back(std::move(*point));
    }
  }
}

std::optional<wire::Notation> read_notation(ConfigReader& reader) {
  if (!reader.has("notation")) return {};
  const auto word = reader.choice("notation", "three-level", {"three-level", "two-level", "free"});
  return word == "two-level" ? wire::Notation::kTwoLevel
         : word == "free"    ? wire::Notation::kFree
                             : wire::Notation::kThreeLevel;
}

std::vector<std::string> conflicts(const std::vector<GroupPoint>& points) {
  Claims claims;
  std::vector<std::string> all;
  for (const auto& point : points) {
    if (const auto wrong = claims.take(point); !wrong.empty())
      all.push_back(fmt::format("{}: {}", to_string(point.address), wrong));
  }
  return all;
}

std::optional<ReadRule> parse_read_rule(std::string_view text) {
  using When = ReadRule::When;
  if (text == "demand") return ReadRule{When::kDemand, {}};
  if (text == "init") return ReadRule{When::kInit, {}};
  if (text == "never") return ReadRule{When::kNever, {}};
  const auto blank = std::min(text.find(' '), text.size());
  const auto word = text.substr(0, blank);
  if (word != "expire" && word != "every") return {};
  const auto period = base::parse_duration(text.substr(std::min(blank + 1, text.size())));
  if (!period || *period <= Duration{}) return {};
  return ReadRule{word == "every" ? When::kEvery : When::kExpire, *period};
}

}  // namespace rubicon::networks::knx::groups
