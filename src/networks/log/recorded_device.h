#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/compare_text.h"
#include "base/prefetch.h"
#include "model/message.h"
#include "model/point_tuples.h"
#include "model/type_catalogue.h"
#include "model/type_names.h"
#include "model/units.h"

namespace rubicon::networks::log {

/// Type numbers for types that this island's catalogue does not have: the recorded number if it is free, else another.
class ForeignTypes {
 public:
  static constexpr std::size_t kMaxInKeys = 500;

  explicit ForeignTypes(const TypeCatalogue& types) : types_(types) {}

  const Type* known(std::string_view name) const { return types_.find(name); }
  /// The type of the catalogue; nullptr if it has none, `id` is then changed to a free number.
  const Type* find(const std::string& name, TypeId& id);
  /// Whether there is a number left for this name; a hostile recording must not use them up.
  bool has_room(const std::string& name) const;
  /// The same for a name in keys; remembers it.
  bool take_key_type(std::string_view name);

 private:
  bool is_free(TypeId id) const;

  const TypeCatalogue& types_;
  static constexpr std::size_t kMaxForeign = 1000, kMaxName = 255;
  std::map<std::string, TypeId> given_;
  std::set<std::string, std::less<>> in_keys_;
  std::uint16_t next_ = 0xffff;
};

/// The status of a point as recorded.
struct RecordedStatus {
  Quality quality = Quality::kUnknown;
  WallTime heard{};  ///< zero = never

  /// Whether the quality belongs to the value itself, and not to the line or the device, or to a point without a value.
  bool is_live() const {
    return quality == Quality::kBad || quality == Quality::kStale || quality >= Quality::kAssumed;
  }
  /// Whether the value recorded before it was heard when it was written, not stored from before.
  bool is_heard(WallTime written) const;
};

/// One sensor, actuator or property of a recording. What a value of it touches comes first, in two cache lines.
struct alignas(64) RecordedPoint {
  const Type* type = nullptr;
  std::uint64_t session = 0;   ///< of the recorder, for the three below
  std::uint64_t sequence = 0;  ///< of the last value taken
  WallTime write_time{};
  std::optional<RecordedStatus> status;
  Kind kind = Kind::kSensor;
  bool alive = false;                       ///< its value tuple exists
  bool joined = false;                      ///< by the last join of its device
  std::unique_ptr<model::Reading> waiting;  ///< held until the join, or until the status shows that it was heard
  std::unique_ptr<const model::UnitConversion> unit{};  ///< of recorded values into the unit of the type
  Capability capability;                                ///< from the description; without one, from the id at the join
  std::shared_ptr<const model::OpenType> own_type{};    ///< of an open type: `type` points to it
  std::string id;                                       ///< in the key: `light-window`
  std::string text;                                     ///< its description as recorded; empty = none

  /// What a value of it touches comes into the cache meanwhile.
  void fetch() const {
    base::prefetch(this);
    base::prefetch(&capability.point);
  }
};

/// One device of a recording. Its points never move. What a value touches comes first, in a cache line.
struct alignas(64) RecordedDevice {
  using PointKey = std::pair<Kind, std::string>;

  std::string joined_as;        ///< address of its last join; empty = not joined
  std::uint64_t confirmed = 0;  ///< the snapshot that named it last
  bool changed = false;         ///< since its last join
  bool deferred = false;        ///< until the end of the turn
  std::string id;               ///< in the keys
  std::string text;             ///< its description as recorded; empty = none
  std::string address, name, model, type;
  std::array<std::vector<std::string>, 3> listed;  ///< ids by kind, in order
  std::vector<std::string> capabilities;           ///< types in the order of their first point
  std::map<PointKey, RecordedPoint> points;

  /// Memory that the description takes.
  std::size_t text_cost() const;
  bool joined() const { return !joined_as.empty(); }
  /// Its description and those of all points in it are known.
  bool complete() const;
};

/// Reads the descriptions of points. Thousands of points have the same one, so that it keeps some.
class PointDescriptions {
 public:
  /// nullptr: it is not a description. Valid until the next call.
  const model::PointDescription* read(std::string_view text);

 private:
  static constexpr std::size_t kMaxKept = 64, kMaxText = 1024;
  base::ByText<model::PointDescription> kept_;
  std::optional<model::PointDescription> last_;  ///< one that is too long to be kept
};

/// Reads the JSON of a `.description` tuple (docs/tuple-keys.md); false, and nothing changes, if it is not a
/// description.
bool describe(RecordedDevice& device, std::string_view text);
bool describe(RecordedPoint& point, std::string_view text, ForeignTypes& types, PointDescriptions& descriptions);

/// The Join that makes a proxy publish these descriptions; marks its points as joined. Held values without a user time
/// become initial values.
model::Join join_of(RecordedDevice& device, ForeignTypes& types);

/// `light-window` -> `light`.
std::string_view type_part(std::string_view id);

/// Reads the JSON of a `.status` tuple (docs/tuple-keys.md); nullopt if it is not a status.
std::optional<RecordedStatus> recorded_status(std::string_view text);

/// Converts a value from the unit of its description to that of its type.
Value in_unit_of_type(const RecordedPoint& point, Value value);

/// The value whose text was recorded; kInvalid if the type does not have it.
Result<Value> recorded_value(const Type* type, std::string_view text, std::string_view media_type);

}  // namespace rubicon::networks::log
