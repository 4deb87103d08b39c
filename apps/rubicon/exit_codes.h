#pragma once

#include <string_view>

namespace rubicon::cli {

/// Exit codes of the program; the same table is in `rubicon --help` and docs/cli.md.
enum ExitCode : int {
  kGood = 0,
  kFailed = 1,      ///< the network, a file, or (doctor) something is wrong
  kUsage = 2,       ///< the command line is wrong, or several tuples fit
  kRefused = 3,     ///< 3 to 7: how a command ended
  kNotDone = 4,     ///< failed
  kTimedOut = 5,    ///< timed-out
  kExpired = 6,     ///< expired
  kSuperseded = 7,  ///< superseded
  kNotThere = 8,    ///< no such owner, tuple or device
  kPartly = 9,      ///< `knx import`: the rest of the file was imported
  kNotGood = 10     ///< `get`: the value was shown, its quality is not good
};

/// The exit code of an outcome (docs/life-of-a-command.md); kFailed for an unknown word.
int exit_code_of(std::string_view state);

inline constexpr const char* kExitCodes =
    "Exit codes: 0 good; 1 failed; 2 wrong command line, or several tuples fit; how a command ended: 3 refused,\n"
    "4 failed, 5 timed-out, 6 expired, 7 superseded; 8 no such component, tuple or device; 9 a file was imported\n"
    "without the lines that have errors; 10 the value is shown, but its quality is not good.";

}  // namespace rubicon::cli
