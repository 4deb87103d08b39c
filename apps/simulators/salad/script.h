#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "networks/salad/salad_codec.h"
#include "rubicon/time.hpp"

namespace rubicon::salad_simulator {

using networks::salad::DeviceId;

/// One line of a script; `at` counts from the start of the simulator, or of the round after a `repeat`.
///
///     at 2s set 7 1                       device 7 stores 1
///     at 5s ramp 30 0 100 over 10s        from 0 to 100 in ten seconds
///     at 0s random 44 0 1 every 3s        a whole number from 0 to 1, a new one every three seconds; FROM <= TO
///     at 20s hold 44                      ends its ramp or random
///     at 25s silence 5s                   publishes nothing
///     at 30s garbage                      one datagram of each kind of bad input
///     at 60s repeat                       the script begins again
///
/// `#` begins a comment. Numbers go from -1e15 to 1e15; a ramp may go down.
struct Step {
  enum class Kind : std::uint8_t { kSet, kRamp, kRandom, kHold, kSilence, kGarbage, kRepeat };
  Duration at{};
  Kind kind = Kind::kSet;
  DeviceId id = 0;
  double from = 0, to = 0;  ///< of a ramp or a random; what is set is `to`
  Duration span{};          ///< of a ramp, a silence, or between two draws

  int line = 0;  ///< of the script, from 1

  friend bool operator==(const Step&, const Step&) = default;
};

/// The steps in the order of their times; kInvalid names the line and what was expected there.
Result<std::vector<Step>> parse_script(std::string_view text);

}  // namespace rubicon::salad_simulator
