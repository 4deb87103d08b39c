#pragma once

#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/message.h"
#include "model/quality.h"
#include "model/type_catalogue.h"
#include "model/units.h"

namespace rubicon::networks::log {

/// Numbers for types this island's catalogue does not know: the recorded one if it is free, else one of its own.
class ForeignTypes {
 public:
  static constexpr std::size_t kMaxInKeys = 500;

  explicit ForeignTypes(const TypeCatalogue& types) : types_(types) {}

  const Type* known(std::string_view name) const { return types_.find(name); }
  /// The type called so; if there is none, `id` becomes a number for it.
  const Type* find(const std::string& name, TypeId& id);
  /// Whether find() has a number for this name; a hostile recording must not use them up.
  bool has_room(const std::string& name) const;
  /// The same for a name that stands in keys, which is remembered.
  bool take_key_type(std::string_view name);

 private:
  bool is_free(TypeId id) const;

  const TypeCatalogue& types_;
  static constexpr std::size_t kMaxForeign = 1000, kMaxName = 255;
  std::map<std::string, TypeId> given_;
  std::set<std::string, std::less<>> in_keys_;
  std::uint16_t next_ = 0xffff;
};

/// What the status tuple of a point says of its value.
struct RecordedStatus {
  Quality quality = Quality::kUnknown;
  WallTime heard{};  ///< zero = never

  /// It shows the quality of the value, not that of line or device, nor that nothing was heard yet.
  bool is_live() const {
    return quality == Quality::kBad || quality == Quality::kStale || quality >= Quality::kAssumed;
  }
  /// Whether the value in front of it was heard when it was written, or stored from before.
  bool is_heard(WallTime written) const;
};

/// What a recording says of one sensor, actuator or property.
struct RecordedPoint {
  Kind kind = Kind::kSensor;
  std::string id;         ///< its part of the key: `light-window`
  std::string text;       ///< its description as recorded; empty = none
  Capability capability;  ///< from the description; where none was recorded, from the id at the Join
  const Type* type = nullptr;
  std::optional<model::UnitConversion> unit{};  ///< of recorded values into the unit of the type
  bool alive = false;                           ///< its value tuple is there
  bool joined = false;                          ///< it was in its device's last Join
  std::uint64_t session = 0;                    ///< of the recorder: what follows is of it
  std::uint64_t sequence = 0;                   ///< of the last value taken
  WallTime write_time{};
  std::optional<RecordedStatus> status;
  std::optional<model::Reading> waiting;  ///< came before the Join, or before its status says whether it was heard
};

/// What a recording says of one device. Its points never move.
struct RecordedDevice {
  using PointKey = std::pair<Kind, std::string>;

  std::string id;    ///< its part of the keys
  std::string text;  ///< its description as recorded; empty = none
  std::string address, name, model, type;
  std::array<std::vector<std::string>, 3> listed;  ///< ids by kind, in order
  std::vector<std::string> capabilities;           ///< types in the order of their first point
  std::map<PointKey, RecordedPoint> points;
  bool changed = false;         ///< since its last Join
  bool deferred = false;        ///< until the end of the turn
  std::string joined_as;        ///< address of its last Join; empty = it is not joined
  std::uint64_t confirmed = 0;  ///< the snapshot that named it last

  std::size_t text_cost() const;
  bool joined() const { return !joined_as.empty(); }
  /// Its description and those of all points in it are known.
  bool complete() const;
};

/// Takes the JSON of a `.description` tuple (docs/tuple-keys.md); false if it is none.
bool describe(RecordedDevice& device, std::string_view text);
bool describe(RecordedPoint& point, std::string_view text, ForeignTypes& types);

/// The Join that makes a proxy publish these descriptions; marks the points in it as joined. Values without a user time
/// that wait become initial ones.
model::Join join_of(RecordedDevice& device, ForeignTypes& types);

/// `light-window` -> `light`.
std::string_view type_part(std::string_view id);

/// Takes the JSON of a `.status` tuple (docs/tuple-keys.md); nothing if it is none.
std::optional<RecordedStatus> recorded_status(std::string_view text);

/// A recorded value in the unit of its type, where its description named another one.
Value in_unit_of_type(const RecordedPoint& point, Value value);

/// The text of a value tuple as the value it was made of; kInvalid if the type has no such value.
Result<Value> recorded_value(const Type* type, std::string_view text, std::string_view media_type);

}  // namespace rubicon::networks::log
