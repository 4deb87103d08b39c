#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/hash_index.h"
#include "model/message.h"
#include "model/point.h"
#include "model/point_keys.h"
#include "model/point_tuples.h"
#include "model/type_names.h"
#include "model/value.h"
#include "proxy/proxy_config.h"
#include "rubicon/time.hpp"
#include "rubicon/tuple_space.hpp"
#include "state/state_store.h"

namespace rubicon::proxy {

/// Decides whether the readings of one point can be true. A value beyond `step`, or one that falls although it should
/// rise, is believed when three readings in a row agree: the room did cool down, or the meter was replaced.
class Plausibility {
 public:
  explicit Plausibility(std::shared_ptr<const Valid> rules) : rules_(std::move(rules)) {}

  const Valid& rules() const { return *rules_; }
  /// Why the value is not believed; empty = it is, as every value that is not a number. `before`: the last good value.
  std::string objection(const Value& value, std::optional<double> before);

 private:
  std::string doubt(double value, double before) const;
  bool agrees(double value) const;

  std::shared_ptr<const Valid> rules_;
  std::optional<double> candidate_;  ///< the last doubted value
  int agreeing_ = 0;                 ///< readings in a row that agree with it
};

/// Shares equal rules: most come from the type.
class SharedRules {
 public:
  /// Different rules beyond this number are not shared.
  static constexpr std::size_t kMax = 64;

  std::shared_ptr<const Valid> of(Valid rules);

 private:
  std::vector<std::weak_ptr<const Valid>> known_;
};

/// A text that most devices and points do not have; takes eight bytes while it is empty.
class RareText {
 public:
  RareText() = default;
  RareText& operator=(std::string text) {
    text_ = text.empty() ? nullptr : std::make_unique<const std::string>(std::move(text));
    return *this;
  }

  const std::string& text() const {
    static const std::string kEmpty;
    return text_ ? *text_ : kEmpty;
  }
  bool empty() const { return !text_; }
  void clear() { text_.reset(); }

  friend bool operator==(const RareText& one, const std::string& other) { return one.text() == other; }

 private:
  std::unique_ptr<const std::string> text_;
};

/// A capability and what follows from it alone.
struct PointCapability : Capability {
  PointCapability(const Capability& capability, const TypeCatalogue& types);

 private:
  std::unique_ptr<const model::OpenType> own_type_;  ///< Capability::data

 public:
  /// By what the values are read: the type of the catalogue, else that of the capability; nullptr = none.
  const Type* const type;
  const std::string id;  ///< point_id() without a name: `light-1`
};

/// The rules of a point: its own, else those of its type in the network, with the codes known for the type. nullopt:
/// none.
std::optional<Valid> rules_of(const NetworkRules& network, const std::string& address,
                              const PointCapability& capability);

/// Shares equal capabilities: thousands of devices of one kind have the same.
class SharedCapabilities {
 public:
  /// Different capabilities beyond this number are not shared.
  static constexpr std::size_t kMax = 2048;

  explicit SharedCapabilities(const TypeCatalogue& types) : types_(types) {}
  std::shared_ptr<const PointCapability> of(const Capability& capability);

 private:
  const TypeCatalogue& types_;
  std::unordered_multimap<std::size_t, std::weak_ptr<const PointCapability>> known_;  ///< by a hash of the point
};

using tuples::TupleRef;

/// The lower half is the place of the device in the directory, the upper half counts all that ever had one: never
/// reused, so that a number kept in a list cannot name a later device.
using DeviceNumber = std::uint64_t;
using PointNumber = std::uint32_t;

/// One reading of the clocks, shared by everything that happens in a turn of the loop.
struct Moment {
  SteadyTime steady;
  WallTime wall;
};

enum class DeviceStatus : std::uint8_t { kUnknown, kReachable, kUnreachable };
std::string_view to_string(DeviceStatus status);

/// Seldom needed fields of a point; apart, so that a reading touches little memory.
struct PointDetails {
  std::shared_ptr<const PointCapability> capability;  ///< SharedCapabilities
  RareText own_id;                                    ///< id() where it is not that of the capability
  std::unique_ptr<Plausibility> plausibility;         ///< nullptr: each reading that fits the type is believed
  RareText reason;                                    ///< of the quality
  RareText last_command;                              ///< JSON of the last command and its state; empty = none yet
  RareText ended_commands;                            ///< JSON of KeptOutcomes; empty = none

  /// Its part of the keys: `light-window`.
  const std::string& id() const { return own_id.empty() ? capability->id : own_id.text(); }
  void name(const std::string& id) { own_id = id == capability->id ? std::string() : id; }
};

// The fields of a point and of a device stand in groups. Only the part of the proxy that owns a group writes to it.

/// Owned by TupleMirror.
struct PointMirror {
  TupleRef value;
  bool dirty = false;    ///< the status tuple waits for the next flush
  bool doubted = false;  ///< PointDetails::plausibility is there; DeviceDirectory sets both
  std::string text;      ///< the last good value
  TupleRef status, command;
};
/// Owned by Demand.
struct PointDemand {
  bool wanted = false;   ///< the value has an active subscriber
  Duration interval{0};  ///< shortest wanted period; zero = a subscriber named none
  Duration named{0};     ///< shortest period that a subscriber named; zero = none
  SteadyTime since{};    ///< when it became wanted
};
/// Owned by CommandDesk.
struct PointCommands {
  std::uint16_t live : 15 = 0;   ///< commands in a state that is not final
  std::uint16_t failed : 1 = 0;  ///< the last one could not be carried out
};
/// Owned by Memory; `declared` by DeviceDirectory.
struct PointStorage {
  bool unsaved : 1 = false;      ///< the value is newer than that in the state file
  bool set_by_user : 1 = false;  ///< a property that a user set
  bool declared : 1 = true;      ///< false: made from a reading, not from a join; DeviceDirectory sets it
};

/// One sensor, actuator or property of a device. What a reading needs comes first.
struct Point {
  PointId id;                  ///< as the network spells it
  const Type* type = nullptr;  ///< of its capability; nullptr = nothing is known of it
  PointNumber number = 0;      ///< unique in its device
  PointCommands commands;
  Quality quality = Quality::kUnknown;  ///< of the point alone; shown_quality() adds line and device
  PointStorage storage;
  SteadyTime heard_at{};  ///< of the last good value
  WallTime heard{}, changed{};
  PointMirror mirror;
  WallTime since{};  ///< of the quality
  PointDemand demand;
  std::unique_ptr<PointDetails> details;
};

/// The last sampling order to the device and its answer. Owned by Demand.
struct Sampling {
  std::vector<PointId> points;
  std::chrono::milliseconds period{0};
  std::uint64_t request = 0;  ///< 0 = no answer expected
  RareText refusal;           ///< empty = accepted or not answered yet
  SteadyTime faster_at{};     ///< when the period last became shorter
  bool unsure = false;        ///< sent, and neither accepted nor refused yet
  bool queued = false;        ///< in the list of devices whose order is checked in the next turn
  bool repeat = false;        ///< send the order even if nothing changed
  bool overdue = false;       ///< in the list of devices whose order is repeated until they report
};
/// Owned by Liveness.
struct DeviceLiveness {
  SteadyTime check_at = SteadyTime::max();  ///< the next check
  SteadyTime probed_at{};                   ///< the last Probe; zero = none
};
/// Owned by TupleMirror.
struct DeviceMirror {
  TupleRef status;
  bool dirty = false;  ///< some points wait for the next flush
};
/// Owned by Memory.
struct DeviceStorage {
  std::int64_t row = 0;  ///< in the state file; 0 = not stored
  state::Decision decision = state::Decision::kNone;
  bool record_unsaved = false, values_unsaved = false;
};

struct Network;

/// A device that the island lists. Owned by the table of its Network. What a reading needs comes first.
struct Device {
  DeviceNumber number = 0;
  Network* network = nullptr;
  DeviceMirror mirror;
  DeviceStatus status = DeviceStatus::kUnknown;
  bool found_unreachable = false;  ///< by its network, which still takes its commands; until it is heard
  bool unusable = false;           ///< found unreachable by a Join::problem; until a Join without one
  SteadyTime heard_at{};           ///< the last message; meaningless while status is unknown
  DeviceLiveness liveness;
  std::vector<Point> points;
  std::string address;  ///< as its network spells it
  std::string id;       ///< its part of the keys
  std::string key;      ///< `proxy.wsn-1.7`
  std::string type, name, model;
  RareText area;                    ///< where it is: from the configuration, else from a user, else announced
  std::string announced_name;       ///< by the device; `name` is the one shown: configured, else given, else this
  RareText announced_area;          ///< by its network
  RareText given_name, given_area;  ///< by a user at run time
  RareText wanted_id;               ///< Join::id
  WallTime joined{};                ///< Announced::joined of its last join
  WallTime since{};                 ///< of the status
  RareText reason;                  ///< of the status
  std::chrono::milliseconds rate{1000};
  PointNumber rate_point = 0;  ///< the property that shows the rate; 0 = none
  PointNumber last_point = 0;  ///< the last number given to a point
  Sampling sampling;
  DeviceStorage storage;
};

/// The devices of a network by address. They never move.
class DeviceTable {
 public:
  /// nullptr: there is none.
  Device* find(std::string_view address) const { return find(address, hash_of(address)); }
  /// No device may have the address yet.
  Device& add(const std::string& address);
  void remove(const Device& device);
  /// In no order.
  const std::vector<std::unique_ptr<Device>>& all() const { return devices_; }
  std::size_t size() const { return devices_.size(); }

  // The parts of find() for several addresses at once: each brings into the cache what the next one touches.
  static std::uint32_t hash_of(std::string_view address);
  void fetch_place(std::uint32_t hash) const { index_.fetch(hash); }
  void fetch_device(std::uint32_t hash) const;
  Device* find(std::string_view address, std::uint32_t hash) const;

 private:
  base::HashIndex index_;
  std::vector<std::unique_ptr<Device>> devices_;
};

/// Orders the devices of a network by their part of the keys.
struct ById {
  using is_transparent = void;
  bool operator()(const Device* one, const Device* other) const { return one->id < other->id; }
  bool operator()(const Device* one, std::string_view id) const { return one->id < id; }
  bool operator()(std::string_view id, const Device* one) const { return id < one->id; }
};

/// Errors of a network; published as counters.
struct NetworkFaults {
  std::uint64_t refused_joins = 0;       ///< device cap, or another device has the key
  std::uint64_t refused_points = 0;      ///< key taken, too long, or too many points
  std::uint64_t unknown_devices = 0;     ///< messages of devices that never joined
  std::uint64_t undeclared_points = 0;   ///< readings that name a point which was not declared and cannot be added
  std::uint64_t bad_values = 0;          ///< readings that do not fit their type
  std::uint64_t implausible_values = 0;  ///< readings that Plausibility refused
  std::uint64_t roamed_messages = 0;     ///< messages of devices that another island lists
};

/// One network of the island and its devices.
struct Network {
  std::string id;   ///< as configured
  std::string key;  ///< `proxy.wsn-1`
  NetworkRules rules;
  model::LineState line = model::LineState::kConnecting;
  bool line_known = false;  ///< a State arrived; until then any message counts as a sign that the line is up
  bool down = false;        ///< down, refused or ended; a line that is being reopened stays down until it is up
  WallTime since{};
  std::string reason, finding;
  DeviceTable devices;
  std::set<Device*, ById> by_id;                ///< the reachable ones are published in this order
  std::map<std::string, std::string> reserved;  ///< configured id -> the address it is reserved for
  NetworkFaults faults;
  TupleRef status_tuple, devices_tuple;
  std::map<std::string, std::string> reported;   ///< counters and texts of the network itself
  std::map<std::string, std::string> published;  ///< properties as last published
  bool devices_dirty = false;
};

inline bool can_send(const Network& network) {
  return !network.line_known || network.line == model::LineState::kUp || network.line == model::LineState::kEnded;
}

/// Whether commands go to the network now. A network that finds a device unreachable decides itself how long it tries.
inline bool takes_commands(const Device& device) {
  return can_send(*device.network) && (device.status != DeviceStatus::kUnreachable || device.found_unreachable);
}

/// The property of a device that the proxy executes itself: the sampling period for subscribers that name none.
bool is_rate(const Point& point);
/// A usable rate; nullopt for anything that is not a whole number of milliseconds from 1 to a day.
std::optional<std::chrono::milliseconds> rate_of(const Value& value);

/// Quality as published: a line that is down hides the quality of the device, an unreachable device that of the point.
Quality shown_quality(const Device& device, const Point& point);

model::PointKey point_key(const Device& device, const Point& point);

/// Whether its values are events: each counts, and none is in force later (docs/types.md).
bool is_event(const Point& point);
Point* find_point(Device& device, const PointId& id);
Point* find_point(Device& device, PointNumber number);
/// What find_point() touches comes into the cache meanwhile.
void fetch_points(const Device& device);

}  // namespace rubicon::proxy
