#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "model/point.h"
#include "networks/zigbee/exposes/leaf.h"

namespace rubicon::networks::zigbee::exposes {

/// A point of a device, and how its values are written in state and set messages.
struct MappedPoint {
  Capability capability;
  std::string property;  ///< JSON key in state and set
  LeafAccess access;
  bool event = false;  ///< never cached by Zigbee2MQTT (`action`): each message counts once (zigbee.md, section 5)
  // How a JSON value of the property becomes a value of the type: owned by mapping.cpp and values.cpp.
  struct Coding {
    enum class Form : std::uint8_t {
      kNumber,
      kInteger,
      kBinary,
      kWords,
      kText,
      kJson,
      kColourXy,
      kColourHueSaturation
    };
    Form form = Form::kNumber;
    double factor = 1, offset = 0;  ///< value = json * factor + offset
    std::vector<NamedValue> words;  ///< kBinary: off, on; kWords: the words of the type and their JSON
    double step = 0;                ///< of the JSON number; 0 = none
    friend bool operator==(const Coding&, const Coding&) = default;
  } coding;
  friend bool operator==(const MappedPoint&, const MappedPoint&) = default;
};

/// The points of a device: every leaf becomes at least one (zigbee.md, section 9; the table of types is
/// docs/zigbee.md). The types are those of the catalogue; a meaning that it lacks becomes an open type (docs/types.md)
/// with the name, unit, bounds and words of the leaf. Instance = endpoint, else 1. Deterministic: the same leaves give
/// the same points.
std::vector<MappedPoint> map_leaves(const std::vector<Leaf>& leaves, const TypeCatalogue& types);

/// A JSON value of the property in a state message -> the value in the unit of the type; monostate for null. kInvalid
/// names the property, the text and what was expected.
Result<Value> decode(const MappedPoint& point, std::string_view json);

/// A commanded value -> the JSON value for a set message. Words, bounds and step are checked, because Zigbee2MQTT does
/// not answer a set that it rejects: kOutOfRange, kInvalid.
Result<std::string> encode(const MappedPoint& point, const Value& value);

}  // namespace rubicon::networks::zigbee::exposes
