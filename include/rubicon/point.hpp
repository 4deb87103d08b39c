#pragma once

#include <cstdint>
#include <string>

#include "rubicon/time.hpp"

/// Values of the `.status` tuples of points, devices and networks (docs/tuple-keys.md). Members that the tuple does not
/// have are empty or zero.
namespace rubicon::model {

/// `<prefix>.<network>.<device>.<kind>.<id>.status`
struct PointStatus {
  std::string quality;  ///< one of docs/tuple-keys.md#quality
  std::string reason;
  WallTime since{};     ///< start of the present quality
  WallTime heard{};     ///< last good value received; zero = never
  WallTime changed{};   ///< last time the value differed from the one before
  std::string command;  ///< state of the last command (docs/life-of-a-command.md); empty = no command yet

  friend bool operator==(const PointStatus&, const PointStatus&) = default;
};

/// `<prefix>.<network>.<device>.status`
struct DeviceCondition {
  std::string status;  ///< unknown, reachable or unreachable
  std::string reason;
  WallTime since{};

  friend bool operator==(const DeviceCondition&, const DeviceCondition&) = default;
};

/// `<prefix>.<network>.status`
struct LineStatus {
  std::string line;  ///< down, connecting, refused, up or ended
  std::string reason;
  WallTime since{};
  std::uint64_t attempts = 0;  ///< attempts to open the line since the island started
  WallTime next_attempt{};     ///< zero = none scheduled
  std::string finding{};       ///< a word for the reason (docs/errors.md#findings); empty = there is none

  /// The line is up, or is a recording that was replayed to its end.
  bool works() const { return line == "up" || line == "ended"; }

  friend bool operator==(const LineStatus&, const LineStatus&) = default;
};

}  // namespace rubicon::model

namespace rubicon {
using model::DeviceCondition;
using model::LineStatus;
using model::PointStatus;
}  // namespace rubicon
