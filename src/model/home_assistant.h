#pragma once

#include <span>
#include <string>
#include <string_view>

// How Home Assistant calls our types (specs of its MQTT integration and its classes of sensors, 2026.1 and later), for
// both directions: a bridge announces our points by this table, a network reads what others announce.
namespace rubicon::model {

/// A sensor, or the number of an actuator.
struct EntityClass {
  std::string_view type;          ///< of our catalogue
  std::string_view device_class;  ///< empty = none
  std::string_view unit;          ///< their spelling; empty = that of our unit, `-` = none
  /// measurement, measurement_angle, total or total_increasing.
  std::string_view state_class = "measurement";
  bool diagnostic = false;
  double factor = 1;  ///< their number = ours * factor
};
std::span<const EntityClass> entity_classes();
/// nullptr: the type has none, and is announced without one.
const EntityClass* entity_class_of(std::string_view type);
/// The other way round: the first type of that class whose unit fits; nullptr for what is none of ours.
const EntityClass* entity_class_by(std::string_view device_class, std::string_view unit);

/// A binary sensor.
struct BinaryClass {
  std::string_view type;
  std::string_view device_class;  ///< empty = none
  bool diagnostic = false;
  bool first_is_on = false;  ///< the first of our two words is what they call on
};
std::span<const BinaryClass> binary_classes();
const BinaryClass* binary_class_of(std::string_view type);
const BinaryClass* binary_class_by(std::string_view device_class);

/// A text with a form of its own: dates and times.
struct TextClass {
  std::string_view type;
  std::string_view platform;        ///< of a point that is written; younger than the others: 2026
  std::string_view device_class;    ///< of a sensor; empty = none
  std::string_view value_template;  ///< from our text to theirs; empty = the same
  std::string_view command_template;
};
std::span<const TextClass> text_classes();
const TextClass* text_class_of(std::string_view type);

/// A further point of an entity that is made of several.
struct EntityPart {
  std::string_view platform, role;  ///< `climate`, `preset`
  std::string_view type;
};
std::span<const EntityPart> entity_parts();

/// `Cel` -> `°C`; units that both spell alike stay; `1` -> empty.
std::string to_entity_unit(std::string_view ucum);
/// The same, the other way round; empty -> `1`. Also takes U+00B5 for micro.
std::string from_entity_unit(std::string_view unit);

}  // namespace rubicon::model
