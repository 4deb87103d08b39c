#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/shared_list.h"
#include "model/message.h"
#include "networks/zigbee/device/commands.h"
#include "networks/zigbee/device/known_values.h"
#include "networks/zigbee/device/state_message.h"

namespace rubicon::networks::zigbee::device {

/// What the state messages of one device prove. A message holds all values that Zigbee2MQTT remembers, so a value in it
/// proves nothing by itself (zigbee.md, section 5). A value is new if it changed or was asked for, and is neither the
/// echo of a command nor a copy of an old value.
class Reports {
 public:
  /// Older values than that are copies that Zigbee2MQTT repeats, unless its clock is wrong.
  static constexpr Duration kOld = std::chrono::seconds(10);

  /// What the device is; changes with its record.
  struct Traits {
    bool can_ask = false;    ///< has mains power: it answers gets
    bool group = false;      ///< its state follows commands, not reports (zigbee.md, section 7)
    bool optimistic = true;  ///< Zigbee2MQTT publishes echoes of commands
  };
  /// Readings of one message, ready to deliver.
  struct Found {
    std::vector<model::Reading> readings;  ///< reported just now
    std::vector<model::Reading> stored;    ///< remembered by Zigbee2MQTT; they do not make the device reachable
    bool heard = false;                    ///< the device itself was
  };

  Reports(Scheduler& scheduler, const base::SharedList<exposes::MappedPoint>& points, Properties& properties,
          Commands& commands, Verification& verification);

  Found take(std::span<const Member> members, bool retained);
  /// The device has the value that is known of the property.
  Found proven(std::size_t property, std::optional<WallTime> seen);
  /// A command was published: its value may come back as an echo.
  void commanded(const Command& command);
  /// The line is back. `repeats`: what Zigbee2MQTT publishes soon after this moment without last_seen may be
  /// old, because it or the broker was started again.
  void line_up(bool repeats);
  /// The line is lost, or the device is out of reach: its values count again when it is heard. Until then what
  /// Zigbee2MQTT changes by itself (a timer, the echo of a group) is only stored.
  void interrupted();
  /// The bridge reports that the device is there.
  void reached() { alive_ = true; }
  /// The points are others: forgets what was commanded, and asks again for what is not proven. Call after traits().
  void points_changed();

  void traits(Traits traits) { traits_ = traits; }
  /// The newest last_seen, else the arrival of the last live message; zero = none came.
  WallTime last_seen() const { return seen_; }
  const Traits& traits() const { return traits_; }

 private:
  struct Change {
    Property* property = nullptr;
    std::string_view json;
    bool own = false;  ///< the value of a command of ours that waited for its echo
  };
  /// The members of a message that differ from what is known, and those that do not.
  struct Compared {
    std::vector<Change> changes, same;
  };
  /// The last command for a point, until another value is reported: a report of the same value means the commanded one,
  /// which may have lost digits.
  struct Commanded {
    std::size_t point = 0, property = 0;
    Value value, wanted;
    std::string json;
    WallTime published{};
    std::optional<WallTime> known_before{};
  };
  enum class Verdict : std::uint8_t {
    kReport,    ///< of the device
    kEcho,      ///< of a command of ours, not proven
    kUnproven,  ///< of a command of another client, perhaps
    kStored,    ///< what Zigbee2MQTT remembers
    kNoNews,    ///< older than what is known
  };

  bool take_echoes(Compared& compared, const Heard& heard, Found& found);
  void note_last_seen(const Heard& heard);
  bool is_commanded(std::size_t property, std::string_view json) const;
  /// Whether the JSON that was reported is what a command (of type Command or Commanded) wanted.
  template <class Sent>
  bool means(std::string_view json, const Sent& command) const;
  Heard heard(std::span<const Member> members, bool retained);
  void date(Heard& heard) const;
  Compared compare(std::span<const Member> members, Heard& heard, Found& found);
  Verdict judge(const Change& change, const Heard& heard, bool beside_own) const;
  void apply(const Change& change, const Heard& heard, Verdict verdict, Found& found);
  bool is_asked(const Property& property) const;
  void doubt(Property& property, Verification::Cause cause, const Heard& heard);
  /// Whether the message has the value of a command that waits for its echo; answers that command.
  bool take_echo(Property& property, std::string_view json, const Heard& heard);
  void unchanged(Property& property, const Heard& heard, Found& found);
  void readings(const Property& property, std::string_view json, WallTime time, std::vector<model::Reading>& out);
  Value as_commanded(std::size_t point, std::string_view json, Value value);
  void event(const Property& property, std::string_view json, const Heard& heard, Found& found);
  /// When the device had the value, as user time; zero = not known.
  WallTime time_of(std::size_t property, std::optional<WallTime> seen) const;
  const Commanded* last_command(std::size_t property) const;
  bool can_ask(const Property& property) const { return traits_.can_ask && property.gettable; }

  Scheduler& scheduler_;
  const base::SharedList<exposes::MappedPoint>& points_;
  Properties& properties_;
  Commands& commands_;
  Verification& verification_;
  Traits traits_;
  std::vector<Commanded> commanded_;
  std::optional<WallTime> newest_{};
  WallTime seen_{};
  Duration newest_age_{};  ///< of the newest last_seen, when it arrived
  SteadyTime copies_until_{};
  bool alive_ = false;  ///< reached since it was interrupted
};

/// Whether a reported JSON number of the point is the wanted one: whole numbers exactly, others to less than half a
/// step, or to a millionth where there is no step. nullopt: not both are numbers.
std::optional<bool> is_same_number(const exposes::MappedPoint& point, std::string_view reported,
                                   std::string_view wanted);
/// Whether a reported value that is not a number is the wanted one. Objects may have further members; parts of colours
/// may differ by 0.1 % and 0.002, other real numbers by a millionth.
bool is_same_value(const exposes::MappedPoint& point, const Value& reported, const Value& wanted);

}  // namespace rubicon::networks::zigbee::device
