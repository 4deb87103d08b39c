#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/scheduler.h"
#include "networks/zigbee/device/state_message.h"
#include "networks/zigbee/exposes/mapping.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::zigbee::device {

/// What is known of the value of a property.
struct KnownValue {
  std::string text{};     ///< JSON, as last taken; empty = never seen
  WallTime changed{};     ///< when the device had it first, as far as known
  SteadyTime asked_at{};  ///< zero = never
  bool unproven = false;  ///< an echo: the device did not report it yet
  bool stored = false;    ///< as Zigbee2MQTT remembered it at its start: a message that repeats it proves nothing
  bool due = false;       ///< shown as stale or stored: delivered once more when the device is heard
  bool asked = false;     ///< by a poll that was not answered yet
};

/// A property of the state messages of a device. Several points may share one: colour as x and y and as hue and
/// saturation.
struct Property : KnownValue {
  bool published = false, settable = false, gettable = false;
  bool event = false;     ///< each message counts once
  std::string_view name;  ///< as its points have it

  /// Differs in each message, whatever caused it: no news of the other properties.
  bool of_the_link() const { return name == "linkquality"; }
};
static_assert(sizeof(Property) == 72);  // a device has dozens

/// The properties of a device by their JSON key. The points must outlive them.
class Properties {
 public:
  /// `before`: the points until now. A property whose points are the same keeps what is known of it, and so does one
  /// whose value is not proven. The others count as never seen: the next message delivers them. All indexes change.
  void set_points(const std::vector<exposes::MappedPoint>& before, const std::vector<exposes::MappedPoint>& points);

  /// nullptr if no point has this key.
  Property* find(std::string_view key);
  Property& operator[](std::size_t index) { return all_[index]; }
  std::size_t index_of(const Property& property) const { return static_cast<std::size_t>(&property - all_.data()); }
  std::size_t of_point(std::size_t point) const { return of_point_[point]; }
  std::vector<std::size_t> points_of(const Property& property) const;
  std::vector<Property>& all() { return all_; }

 private:
  void add(const std::vector<exposes::MappedPoint>& points);
  static Property* find(std::vector<Property>& all, const std::vector<std::uint32_t>& by_name, std::string_view key);

  std::vector<Property> all_;
  std::vector<std::uint32_t> by_name_;  ///< the properties in the order of their names
  std::vector<std::uint32_t> of_point_;
};

/// Finds out which of the values that Zigbee2MQTT published without a report the device really has. It asks for one
/// property at a time, because an answer does not name its question; where asking is impossible, a later message must
/// do. A message proves nothing if other values changed in it: it may be a report of those, with the echo beside them.
/// The message by which the device acknowledges a set proves nothing either.
///
/// One error remains: a device ignores a command, does not answer our get, and reports its old values within a second.
/// Then the value that Zigbee2MQTT published counts as confirmed.
class Verification {
 public:
  /// A message that was only heard may overtake the answer to a get: a value counts if no other one follows so soon.
  static constexpr Duration kSettling = std::chrono::milliseconds(100);
  /// A message with the same last_seen, give or take this, belongs to the same exchange with the device.
  static constexpr Duration kSameExchange = std::chrono::milliseconds(5);

  /// Whose value is to be proven.
  enum class Cause : std::uint8_t {
    kEcho,       ///< the echo of our command: asked 0.3 s, 1 s and 3 s later
    kForeign,    ///< a change that the device did not report, a command of another client: asked likewise
    kNoEchoYet,  ///< our set has no echo: asked once after 2 s, as some converters publish none
    kNoEchoes,   ///< Zigbee2MQTT is configured to publish none for this device: asked as after an echo
  };
  struct Callbacks {
    /// Publishes a get for the property; false: not now, try later. `own`: it belongs to a command of ours.
    std::function<bool(std::size_t property, bool own)> ask;
    /// The device has the value that is known of the property; `seen` = last_seen of the message that proves it.
    std::function<void(std::size_t property, std::optional<WallTime> seen)> proven;
  };
  Verification(Scheduler& scheduler, Callbacks calls);

  /// Starts for a property, in place of what was under way for it. `seen`: newest last_seen of the device so far;
  /// `before`: the one known when the command was published.
  void start(std::size_t property, Cause cause, bool can_ask, std::optional<WallTime> seen,
             std::optional<WallTime> before);
  /// A set was published: the device acknowledges it by a message in which no value changes.
  void set_published();
  /// The device reported a value that differs from the known one. `ends`: it is the wanted value.
  void reported(std::size_t property, bool ends);
  /// Call for each message that is not a copy, after reported().
  void message(const Heard& heard);
  bool is_running(std::size_t property) const;
  /// The device was asked for the property because a command had its echo, and the answer may still come.
  bool asks(std::size_t property) const;
  void clear();

 private:
  struct Item {
    std::size_t property = 0;
    Cause cause = Cause::kEcho;
    bool can_ask = false;
    unsigned asked = 0;  ///< how often
    SteadyTime start{}, due{};
    bool heard = false;                    ///< the device was, since it was asked
    bool begun = false;                    ///< by an earlier message
    std::optional<WallTime> not_before{};  ///< a passive proof has a later last_seen
    bool answering = false;  ///< it was heard of since the command: the next exchange is news of the device
    SteadyTime candidate_until = SteadyTime::max();
    std::optional<WallTime> candidate_seen{};
  };
  void step();
  void settle_candidates();
  void ask_next();
  bool ask(Item& item);
  SteadyTime quiet_from() const;
  void schedule();
  bool acknowledges_set(const Heard& heard);
  void consider(Item& item, const Heard& heard, bool acknowledges);
  bool may_prove(Item& item, const Heard& heard, bool acknowledges) const;
  Item* find(std::size_t property);

  Scheduler& scheduler_;
  Callbacks callbacks_;
  std::vector<Item> items_;
  std::optional<std::size_t> open_;  ///< asked, not answered
  SteadyTime open_until_{};
  unsigned acknowledgements_ = 0;  ///< of sets, which are still to come
  SteadyTime set_at_ = SteadyTime::min();
  base::Deadline deadline_;
};

}  // namespace rubicon::networks::zigbee::device
