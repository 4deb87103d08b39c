#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/scheduler.h"
#include "model/point_tuples.h"
#include "proxy/device.h"

namespace rubicon::proxy {

/// The states of a command (docs/life-of-a-command.md). The first two are live, all others final.
enum class CommandState : std::uint8_t {
  kQueued,      ///< waits for the line, the device, or the acknowledgement of the network
  kSent,        ///< acknowledged by bus or firmware; the device has not reported yet
  kConfirmed,   ///< the device reported the commanded value after it was sent
  kAssumed,     ///< sent to an actuator that never reports
  kRefused,     ///< by the network or the device
  kFailed,      ///< the network could not send it
  kTimedOut,    ///< sent, and not acknowledged or reported in time
  kExpired,     ///< its time to live ended before it could be sent
  kSuperseded,  ///< replaced by a newer command
};
std::string_view to_string(CommandState state);

/// The sender of a command that came as a message: gets one Acknowledge.
struct Asker {
  Address from, about;
  std::uint64_t request = 0;
};

/// One live command, identified by its creator and the request number of the creator. Owned by the CommandDesk.
struct Command {
  DeviceNumber device = 0;
  PointNumber point = 0;
  std::string key;  ///< of its point: `proxy.wsn-1.7.actuator.led-1`
  OwnerId creator{};
  std::uint64_t creator_request = 0;
  std::string commander;       ///< commander_name() of the creator
  std::optional<Asker> asker;  ///< set if it came as a message that is not answered yet
  Value value;
  std::string text;          ///< as published: the text of the value, which may be spelled otherwise in the request
  Duration time_to_live{0};  ///< from when it was accepted
  SteadyTime accepted{}, expires{};
  CommandState state = CommandState::kQueued;
  WallTime since{};
  WallTime until{};  ///< when the state ends by itself; zero = final
  std::string reason;
  std::optional<model::Commander> by;  ///< that superseded it
  std::uint64_t request = 0;           ///< identifies it to the network and to its deadline; changes at each step
  WallTime dispatched{};               ///< when it was sent to the network; zero = it waits for line or device
  model::Outcome outcome = model::Outcome::kSent;  ///< the answer of the network
  Timer deadline;                                  ///< expiry, then the waits for acknowledgement and confirmation
};

/// The JSON of the command in the status of its point.
std::string command_text(const Command& command);

/// Parses the text of a command by the type of the point, within the range that the point declared.
Result<Value> parse_command(const Point& point, std::string_view text);

/// True if the device reports the commanded value; real numbers may differ by the rounding of a 16-bit float (0.1 %).
bool confirms(const Value& reported, const Value& commanded);

}  // namespace rubicon::proxy
