#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/shared_list.h"
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
      kObject,
      kList,
      kColourXy,
      kColourHueSaturation
    };
    Form form = Form::kNumber;
    /// Of numbers: value = (json + shift) * multiply / divide, as model::UnitConversion.
    double multiply = 1, divide = 1, shift = 0;
    bool rounded = false;  ///< a command between two steps becomes the nearest step; else it is refused
    /// kBinary: off, on. kWords: the words of the type and their JSON. Numbers: presets, which may lie beyond the
    /// bounds.
    std::vector<NamedValue> words;
    std::optional<double> minimum, maximum;  ///< of the JSON number
    double step = 0;                         ///< of the JSON number; 0 = none
    std::string part;                        ///< kept for the next command of the property; empty = sent
    std::vector<Leaf> parts;                 ///< kObject: its features; kList: its item; empty = not known
    friend bool operator==(const Coding&, const Coding&) = default;
  } coding;
  friend bool operator==(const MappedPoint&, const MappedPoint&) = default;
};

/// The points of a device: every leaf becomes one, and the composite of a siren some more (sirens.h; zigbee.md, section
/// 9; the table of types is type_table.cpp, explained in docs/zigbee.md). The types are those of the catalogue; a
/// meaning that it lacks becomes an open type (docs/types.md) with the name, unit, bounds and words of the leaf.
/// `link_quality`: adds `linkquality`, which every device has in its state, where it is not exposed; groups have none.
///
/// A leaf that is a setting (category config, or a type of the catalogue's properties) becomes a property, any other
/// one that can be set an actuator, the rest sensors. Instance: the endpoint, else 1; a point that shares its
/// type with others gets a distinguishing word (`temperature-local`, `current-phase_b`), so that the instance does not
/// depend on other leaves. A property of an endpoint belongs to the actuator of that endpoint. Deterministic: the same
/// leaves give the same points, in the order of the leaves; ids are unique as keys are.
std::vector<MappedPoint> map_leaves(const std::vector<Leaf>& leaves, const TypeCatalogue& types,
                                    bool link_quality = true);

/// The points of all models: devices that are alike share theirs.
class PointsOfModels {
 public:
  explicit PointsOfModels(const TypeCatalogue& types) : types_(types) {}

  const TypeCatalogue& types() const { return types_; }
  /// map_leaves() of a device. Keeps those that a device still has.
  base::SharedList<MappedPoint> of(const std::string& model, const base::SharedList<Leaf>& leaves);

 private:
  struct Known {
    base::SharedList<Leaf> leaves;
    base::SharedList<MappedPoint> points;
  };

  const TypeCatalogue& types_;
  std::map<std::string, Known> known_;  ///< by the model
};

/// The spellings of units that are in no table, each as often as a leaf has it.
std::vector<std::string> unknown_units(const std::vector<Leaf>& leaves);

/// A JSON value of the property in a state message -> the value in the unit of the type; monostate for null. Numbers
/// may be written as strings; bounds are not applied. Objects and lists are valid JSON of at most kDeepestJson levels.
/// kInvalid names the type, the text and what was expected.
Result<Value> decode(const MappedPoint& point, std::string_view json);

/// A commanded value -> the JSON value for a set message. Words, bounds and step are checked, because Zigbee2MQTT does
/// not answer a set that it rejects: kOutOfRange, kInvalid. A share of a range (brightness) becomes its nearest step: a
/// report with the JSON that was sent confirms the command, although decode() gives other digits.
Result<std::string> encode(const MappedPoint& point, const Value& value);

}  // namespace rubicon::networks::zigbee::exposes
