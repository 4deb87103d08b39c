#pragma once

#include <optional>
#include <string>
#include <vector>

namespace rubicon::daemon {

/// Exit codes of the program.
inline constexpr int kExitOk = 0;
inline constexpr int kExitFailed = 1;
inline constexpr int kExitConfiguration = 2;  ///< or the command line

/// What `rubicon-proxy run` was asked for.
struct RunOptions {
  std::string file;
  std::vector<std::string> overrides;
  std::vector<std::string> watch;   ///< patterns
  std::vector<std::string> tuples;  ///< KEY=VALUE: own tuples from the start
  bool shell = false;
  std::string log_level = "info";
};

/// Runs an island until a signal, `quit`, or the end of what it was asked to serve.
int run(const RunOptions& options);
/// Lists the network types with their samples.
int list_networks();

/// The program rubicon-proxy: does what its command line says. Returns its exit code.
int run_program(int argc, char** argv);

}  // namespace rubicon::daemon
