#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "model/value.h"
#include "rubicon/result.hpp"

namespace rubicon::model {

/// Number of a sensor, actuator or property type (D1.4, Implementation: a 2-byte short number). 0 = none.
enum class TypeId : std::uint16_t {};
/// Types from here on are the site's own, declared in its configuration.
inline constexpr std::uint16_t kFirstSiteType = 0x8000;
/// Types from here to kFirstSiteType are open: a device names them and the catalogue does not know them
/// (docs/types.md).
inline constexpr std::uint16_t kFirstOpenType = 0x4000;
/// The number of an open type, made from its name: the same on every island.
TypeId open_type(std::string_view name);

enum class DataType : std::uint8_t { kBoolean, kInteger, kReal, kEnumeration, kText, kJson, kBytes };
std::string_view to_string(DataType type);
/// nullopt for every other word.
std::optional<DataType> parse_data_type(std::string_view word);

/// State: the newest value is all that counts. Event: each one counts and keeps its place (button, scene, dim step).
enum class Report : std::uint8_t { kState, kEvent };

/// What every network means by one type name.
struct Type {
  TypeId id{};
  std::string_view name;      ///< camelCase, `[A-Za-z][A-Za-z0-9_]*`, never a `-`; a view into the catalogue
  std::string_view quantity;  ///< `temperature`, `illuminance`, ...
  std::string_view unit;      ///< UCUM code (case sensitive), `1` where there is none
  DataType data = DataType::kReal;
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  Report report = Report::kState;
  /// Comma separated, first = 0: of enumerations, and the off,on words of a boolean. An enumeration without words takes
  /// those of each point (Capability::words): any word, or a number from minimum to maximum.
  std::string_view words;
};

/// A Type with text of its own: how YAML declares one.
struct SiteType {
  std::uint16_t id = 0;
  std::string name, quantity, unit = "1";
  DataType data = DataType::kReal;
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  Report report = Report::kState;
  std::string words;
};

enum class Kind : std::uint8_t { kSensor, kActuator, kProperty };
/// `sensor`, `actuator`, `property`: a part of keys.
std::string_view to_string(Kind kind);
/// nullopt for every other word.
std::optional<Kind> parse_kind(std::string_view word);

enum class Access : std::uint8_t { kRead = 1, kWrite = 2, kReadWrite = 3 };
std::string_view to_string(Access access);

/// A property that devices of one type have. It belongs to the device, or to one sensor or actuator type of it.
struct PropertyOfDevice {
  std::string_view property;  ///< a type name
  Access access = Access::kReadWrite;
  std::string_view belongs_to;  ///< empty = the device; else a sensor or actuator type name
};

struct DeviceType {
  std::uint16_t id = 0;
  std::string_view name;
  std::span<const PropertyOfDevice> properties;
};

/// All types an island knows: the built-in ones, equal everywhere, and the site's own. Types never move or vanish.
class TypeCatalogue {
 public:
  TypeCatalogue();
  ~TypeCatalogue();
  TypeCatalogue(TypeCatalogue&&) noexcept;
  TypeCatalogue& operator=(TypeCatalogue&&) noexcept;

  const Type* find(TypeId id) const;
  const Type* find(std::string_view name) const;
  std::span<const Type* const> all() const;

  /// kDuplicate if name or id is taken, kOutOfRange below 0x8000, kInvalid for a bad name.
  Result<void> declare(const SiteType& type);

  static std::span<const DeviceType> device_types();

  /// Text of a user or a file -> value, by type: boolean words (and on/off, true/false, 1/0), enumeration words or
  /// their number, decimal numbers within the range (no hex, no NaN, no blanks inside). Errors name type, text,
  /// expectation.
  static Result<Value> parse(const Type& type, std::string_view text);

  /// The same for what a device reported: of an enumeration any word or number (docs/types.md).
  static Result<Value> parse_reading(const Type& type, std::string_view text);
  /// Whether the word is one of the type's own.
  static bool names(const Type& type, std::string_view word);

  /// Whether a value a device reported fits (kind of data and range). Of an enumeration any word and any number does:
  /// devices report more than they declare.
  static Result<void> check(const Type& type, const Value& value);

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace rubicon::model

namespace rubicon {

using model::Kind;
using model::Type;
using model::TypeCatalogue;
using model::TypeId;

}  // namespace rubicon

namespace rubicon::model {

/// For a configuration that names a type which the catalogue does not have: `unknown type 'temprature'; did you mean
/// 'temperature'? expected ...`.
std::string unknown_type_text(const TypeCatalogue& types, std::string_view name);

}  // namespace rubicon::model
