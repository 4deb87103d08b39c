#pragma once

namespace rubicon::daemon {

/// Exit codes of the program.
inline constexpr int kExitOk = 0;
inline constexpr int kExitFailed = 1;
inline constexpr int kExitConfiguration = 2;  ///< or the command line

}  // namespace rubicon::daemon
