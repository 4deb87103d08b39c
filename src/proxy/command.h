#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/scheduler.h"
#include "model/point_tuples.h"
#include "proxy/device.h"

namespace rubicon::proxy {

/// What became of a command (docs/life-of-a-command.md). The first two are under way, all others are final.
enum class CommandState : std::uint8_t {
  kQueued,      ///< waits for the line, the device, or the network's acknowledgement
  kSent,        ///< acknowledged by bus or firmware; no report of the device yet
  kConfirmed,   ///< the device reported the commanded value after the sending
  kAssumed,     ///< sent to an actuator that never reports
  kRefused,     ///< the network or the device said no
  kFailed,      ///< the network tried and could not
  kTimedOut,    ///< sent, but nothing came back in time
  kExpired,     ///< its time ended before it could be sent
  kSuperseded,  ///< a newer command took its place
};
std::string_view to_string(CommandState state);

/// Who sent a command as a message, and waits for one Acknowledge.
struct Asker {
  Address from, about;
  std::uint64_t request = 0;
};

/// One command on its way, named by its creator and the creator's request number. Owned by the command desk.
struct Command {
  DeviceNumber device = 0;
  PointNumber point = 0;
  std::string key;  ///< of its point: `proxy.wsn-1.7.actuator.led-1`
  OwnerId creator{};
  std::uint64_t creator_request = 0;
  std::string commander;       ///< commander_name() of the creator
  std::optional<Asker> asker;  ///< if it came as a message and is not answered yet
  Value value;
  std::string text;          ///< as published: the value's own text, not the commander's spelling
  Duration time_to_live{0};  ///< from the acceptance on
  SteadyTime accepted{}, expires{};
  CommandState state = CommandState::kQueued;
  WallTime since{};
  WallTime until{};  ///< when the state ends by itself; zero = final
  std::string reason;
  std::optional<model::Commander> by;  ///< who superseded it
  std::uint64_t request = 0;           ///< names it to the network and to its deadline; a new one at each step
  WallTime handed_over{};              ///< to the network; zero = it waits for line or device
  model::Outcome outcome = model::Outcome::kSent;  ///< what the network answered
  Timer deadline;                                  ///< expiry, then the waits for acknowledgement and confirmation
};

/// As it stands in the status of its point.
std::string command_text(const Command& command);

/// A commander's text -> value: by the type and within the range the point itself declared.
Result<Value> parse_command(const Point& point, std::string_view text);

/// The device reports what was commanded; real numbers may differ by what a 16-bit float loses (0.1 %).
bool confirms(const Value& reported, const Value& commanded);

}  // namespace rubicon::proxy
