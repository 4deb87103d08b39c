#pragma once

#include <cstdint>
#include <string>

#include "rubicon/time.hpp"

/// What the `.status` tuples of points, devices and networks say (docs/tuple-keys.md). What they do not say is empty or
/// zero.
namespace rubicon::model {

/// `<prefix>.<network>.<device>.<kind>.<id>.status`.
struct PointStatus {
  std::string quality;  ///< the words of docs/tuple-keys.md#quality; empty = none is said
  std::string reason;
  WallTime since{};     ///< when the quality became what it is
  WallTime heard{};     ///< when the last good value came; zero = never
  WallTime changed{};   ///< when its text last differed from the one before
  std::string command;  ///< state of the last command (docs/life-of-a-command.md); empty = there was none

  friend bool operator==(const PointStatus&, const PointStatus&) = default;
};

/// `<prefix>.<network>.<device>.status`.
struct DeviceCondition {
  std::string status;  ///< unknown, reachable or unreachable; empty = none is said
  std::string reason;
  WallTime since{};

  friend bool operator==(const DeviceCondition&, const DeviceCondition&) = default;
};

/// `<prefix>.<network>.status`.
struct LineStatus {
  std::string line;  ///< down, connecting, refused, up or ended; empty = none is said
  std::string reason;
  WallTime since{};
  std::uint64_t attempts = 0;  ///< to open the line since the island started
  WallTime next_attempt{};     ///< zero = none is planned

  /// The line works, or has worked to its end (a recording).
  bool works() const { return line == "up" || line == "ended"; }

  friend bool operator==(const LineStatus&, const LineStatus&) = default;
};

}  // namespace rubicon::model

namespace rubicon {
using model::DeviceCondition;
using model::LineStatus;
using model::PointStatus;
}  // namespace rubicon
