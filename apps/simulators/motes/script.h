#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::motes_simulator {

/// Selects motes: an address, at all sinks or at the one where the mote started (`7@2`), or `all`.
struct MotePattern {
  std::uint16_t address = 0;  ///< 0 = all
  std::uint16_t sink = 0;     ///< 0 = any

  friend bool operator==(const MotePattern&, const MotePattern&) = default;
};

/// One line of a script; `at` counts from the start of the world, or from the last `repeat`.
///
///     at 2s  reboot 7                          mote 7 (or 7@2, or all) is switched off and on
///     at 2s  reboot all over 4s               one after the other
///     at 3s  kill 7                            it is switched off until a `reboot`
///     at 4s  move 7 to 2                       it hears only sink 2; `to 1,2`: both, `to none`: none
///     at 5s  stall 7                           its transmit queue stops until a `reboot`
///     at 6s  set 7 light 500                   raw counts; names as in wsn.md 6
///     at 6s  ramp 7 temperature 6500 7000 over 60s
///     at 6s  sine all light 100 900 every 5min
///     at 6s  walk 7 humidity 1000 1400 every 2s
///     at 6s  count 7 light                     as in the recordings: one step each reading
///     at 10s loss 20                           percent of all radio messages; `loss 20 of 7` of one mote's
///     at 10s duplicates 5                      percent
///     at 10s delay 30ms                        on the radio
///     at 12s sink-reboot 1                     it has its compiled-in island id again
///     at 13s unplug 1 for 5s                   its port is closed, and it is switched off
///     at 60s repeat                            the script starts again
///
/// `#` begins a comment.
struct Step {
  enum class Kind : std::uint8_t {
    kReboot,
    kKill,
    kMove,
    kStall,
    kSet,
    kRamp,
    kSine,
    kWalk,
    kCount,
    kLoss,
    kLossOf,
    kDuplicates,
    kDelay,
    kSinkReboot,
    kUnplug,
    kRepeat
  };
  Duration at{};
  Kind kind = Kind::kReboot;
  MotePattern motes;
  std::vector<std::uint16_t> sinks;  ///< that a mote moves to, or the sink of the step
  std::size_t sensor = 0;            ///< index in kSensors
  double from = 0, to = 0;           ///< counts; a share of 1 in `to` for percents
  Duration span{};
  int line = 0;  ///< of the script, from 1; not compared

  friend bool operator==(const Step& a, const Step& b);
};

/// Parses a script; the steps are sorted by time. kInvalid names the line and what was expected there. Steps after a
/// `repeat` would never run and are errors.
Result<std::vector<Step>> parse_script(std::string_view text);

}  // namespace rubicon::motes_simulator
