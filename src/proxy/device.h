#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "model/message.h"
#include "model/point_keys.h"
#include "model/quality.h"
#include "proxy/proxy_config.h"
#include "proxy/rare_text.h"
#include "rubicon/time.hpp"
#include "rubicon/tuple_space.hpp"
#include "state/state_store.h"

namespace rubicon::proxy {

using tuples::TupleRef;

/// Never given twice, so that a number kept in a list cannot mean a device that came later.
using DeviceNumber = std::uint64_t;
using PointNumber = std::uint32_t;

/// One reading of the clocks, shared by everything that happens in a turn of the loop.
struct Moment {
  SteadyTime steady;
  WallTime wall;
};

enum class DeviceStatus : std::uint8_t { kUnknown, kReachable, kUnreachable };
std::string_view to_string(DeviceStatus status);

/// What is needed of a point seldom; apart, so that a reading touches little memory.
struct PointDetails {
  std::shared_ptr<const Capability> capability;  ///< SharedCapabilities
  std::string id;                                ///< its part of the keys: `light-window`
  RareText reason;                               ///< why the quality is what it is
  RareText command;                              ///< JSON of the last command and its state; empty = none yet
  bool set_by_user = false;                      ///< a property a user gave its value
  bool declared = true;                          ///< false: made by a value that arrived, not by a join
};

/// One sensor, actuator or property of a device, with the short names of its tuples. What a reading needs stands first.
struct Point {
  PointId id;                  ///< as the network spells it
  const Type* type = nullptr;  ///< nullptr = not in the catalogue
  TupleRef value;
  PointNumber number = 0;               ///< unique in its device
  std::uint16_t live_commands = 0;      ///< commands neither confirmed nor given up
  Quality quality = Quality::kUnknown;  ///< its own, whatever line and device are
  bool dirty = false;                   ///< its status tuple waits for the next flush
  bool unsaved = false;                 ///< its value is newer than the state file's
  std::string text;                     ///< the last good value
  SteadyTime heard_at{};                ///< of the last good value
  WallTime heard{}, changed{}, since{};
  TupleRef status, command;
  bool wanted = false;   ///< somebody subscribed actively to its value
  Duration interval{0};  ///< shortest wanted period; zero = a subscriber named none
  Duration named{0};     ///< shortest period a subscriber named; zero = none
  SteadyTime wanted_at{};
  std::unique_ptr<PointDetails> details;
};

/// What the device was last told to sample, and what it said to that.
struct Sampling {
  std::vector<PointId> points;
  std::chrono::milliseconds period{0};
  std::uint64_t request = 0;  ///< 0 = nothing outstanding
  RareText refusal;           ///< empty = accepted or not answered yet
  SteadyTime faster_at{};     ///< when the period last became shorter
  bool unsure = false;        ///< told, but not known to be accepted or refused
  bool queued = false;        ///< stands in the list of devices to be told this turn
  bool repeat = false;        ///< tell it even if nothing changed
  bool overdue = false;       ///< stands in the list of devices to be told again until they report
};

struct Network;

/// A device known to the island. Owned by its Network's map. What a reading needs stands first.
struct Device {
  DeviceNumber number = 0;
  Network* network = nullptr;
  DeviceStatus status = DeviceStatus::kUnknown;
  bool dirty = false;                       ///< some of its points wait for the next flush
  SteadyTime heard_at{};                    ///< any message; meaningless while status is unknown
  SteadyTime check_at = SteadyTime::max();  ///< when the liveness looks at it next
  SteadyTime probed_at{};                   ///< when it was last asked whether it is there; zero = never
  std::vector<Point> points;
  std::string address;  ///< as its network spells it
  std::string id;       ///< its part of the keys
  std::string key;      ///< `proxy.wsn-1.7`
  std::string type, name, model;
  RareText area;               ///< where it is: the configuration's word, else the user's
  std::string announced_name;  ///< the device's own; `name` is the configuration's or the user's where there is one
  RareText given_name, given_area;  ///< by a user at run time
  RareText wanted_id;               ///< Join::id
  WallTime joined{};                ///< Announced::joined of its last join
  WallTime since{};
  RareText reason;
  TupleRef status_tuple;
  std::chrono::milliseconds rate{1000};
  PointNumber rate_point = 0;  ///< the property that shows it; 0 = none
  PointNumber last_point = 0;
  Sampling sampling;
  state::Decision decision = state::Decision::kNone;
  std::int64_t state_row = 0;  ///< in the state file; 0 = not there
  bool record_unsaved = false, values_unsaved = false;
};

/// Finds std::string keys by string_view without a copy.
struct TextHash {
  using is_transparent = void;
  std::size_t operator()(std::string_view text) const { return std::hash<std::string_view>{}(text); }
};

/// What went wrong on a network; published as counters.
struct NetworkFaults {
  std::uint64_t refused_joins = 0;      ///< device cap, or another device has the key
  std::uint64_t refused_points = 0;     ///< key taken, too long, or too many points
  std::uint64_t unknown_devices = 0;    ///< messages of devices that never joined
  std::uint64_t undeclared_points = 0;  ///< readings of points that cannot be made from them
  std::uint64_t bad_values = 0;         ///< readings that do not fit their type
  std::uint64_t roamed_messages = 0;    ///< messages of devices that another island lists
};

/// One network of the island and its devices.
struct Network {
  std::string id;   ///< as configured
  std::string key;  ///< `proxy.wsn-1`
  NetworkRules rules;
  model::LineState line = model::LineState::kConnecting;
  bool line_known = false;  ///< a State arrived; before, whatever it delivers shows that the line works
  bool down = false;        ///< down, refused or ended; a line that is being reopened stays down until it is up
  WallTime since{};
  std::string reason;
  std::unordered_map<std::string, Device, TextHash, std::equal_to<>> devices;  ///< by address; they never move
  std::map<std::string, Device*> by_id;         ///< the reachable ones are published in this order
  std::map<std::string, std::string> reserved;  ///< configured id -> the address it is kept for
  NetworkFaults faults;
  TupleRef status_tuple, devices_tuple;
  std::map<std::string, std::string> reported;   ///< counters and texts of the network itself
  std::map<std::string, std::string> published;  ///< properties as last published
  bool devices_dirty = false;
};

inline bool can_send(const Network& network) {
  return !network.line_known || network.line == model::LineState::kUp || network.line == model::LineState::kEnded;
}

/// The property of a device that the proxy executes itself: the sampling period where nobody names one.
bool is_rate(const Point& point);
/// A usable rate; nullopt for anything that is not a whole number of milliseconds from 1 to a day.
std::optional<std::chrono::milliseconds> rate_of(const Value& value);

/// Quality as published: the line hides the device, the device hides the point.
Quality shown_quality(const Device& device, const Point& point);

model::PointKey point_key(const Device& device, const Point& point);

Point* find_point(Device& device, const PointId& id);
Point* find_point(Device& device, PointNumber number);

}  // namespace rubicon::proxy
