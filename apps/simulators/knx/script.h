#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "networks/knx/dpt/dpt.h"
#include "networks/knx/wire/address.h"
#include "networks/knx/wire/cemi.h"
#include "rubicon/time.hpp"

namespace rubicon::knx_simulator {

/// A group address of the bus:
///
///     group 1/0/1 1.001 off state 1/0/2                   reports what it is commanded at 1/0/2
///     group 1/2/7 9.001 21 every 5s noise 0.2             sends 20.8 to 21.2 each five seconds
///     group 1/2/8 9.004 300 every 5s wave 50 600 over 2min
///     group 1/3/1 5.010 7 write-only                      does not answer reads
struct Group {
  networks::knx::wire::GroupAddress address{};
  const networks::knx::dpt::Dpt* type = nullptr;             ///< never null once read
  networks::knx::wire::Payload value;                        ///< at the start
  std::optional<networks::knx::wire::GroupAddress> state{};  ///< repeats each value that is written here
  Duration every{};          ///< between two telegrams of a sensor; 0 = sends only on a step or a read
  double noise = 0;          ///< each of these telegrams differs by at most this, in units of the type
  double low = 0, high = 0;  ///< of a wave
  Duration period{};         ///< of a wave; 0 = none
  bool readable = true;

  friend bool operator==(const Group&, const Group&) = default;
};

/// A timed line; `at` counts from the start of the simulator, or of the round after a `repeat`.
///
///     at 2s write 1/2/7 21.5               a device of the bus sends the value
///     at 3s set 1/2/7 22                   the value changes without a telegram
///     at 4s read 1/2/7                     a device of the bus reads it
///     at 5s ramp 1/2/7 20 24 over 1min     from 20 to 24 in a minute, a telegram each second
///     at 6s silence 10s                    the bus sends nothing and answers nothing
///     at 7s disconnect                     the server ends all tunnels
///     at 8s stop 10s                       the server is gone for ten seconds
///     at 60s repeat                        the script begins again
struct Step {
  enum class Kind : std::uint8_t { kWrite, kSet, kRead, kRamp, kSilence, kDisconnect, kStop, kRepeat };
  Duration at{};
  Kind kind = Kind::kWrite;
  networks::knx::wire::GroupAddress group{};
  std::string text{};                    ///< of a write or set
  networks::knx::wire::Payload value{};  ///< the same in the type of the group
  double from = 0, to = 0;               ///< of a ramp
  Duration span{};                       ///< of a ramp, silence or stop

  int line = 0;  ///< of the file, from 1

  friend bool operator==(const Step&, const Step&) = default;
};

struct Script {
  std::vector<Group> groups;  ///< each address once; state addresses without a line of their own too
  std::vector<Step> steps;    ///< in the order of their times
};

/// `group` and `at` lines; `#` begins a comment. Values are those of `rubicon knx encode`, in one word. kInvalid names
/// the line and what was expected there.
Result<Script> parse_script(std::string_view text);

}  // namespace rubicon::knx_simulator
