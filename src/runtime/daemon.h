#pragma once

#include <optional>
#include <string>
#include <vector>

namespace rubicon::runtime {

/// What `rubicon-proxy run` was asked for.
struct RunOptions {
  std::string file;
  std::vector<std::string> overrides;
  std::vector<std::string> watch;  ///< patterns
  bool shell = false;
  std::string log_level = "info";
};

/// Exit codes of the program.
inline constexpr int kExitOk = 0;
inline constexpr int kExitFailed = 1;
inline constexpr int kExitConfiguration = 2;

/// Runs an island until a signal, `quit`, or the end of what it was asked to serve.
int run(const RunOptions& options);
/// Says what is wrong with a configuration, or that it is right. With `old_file` also what a reload would do to an
/// island that runs with that one; empty = the copy kept beside the state file.
int check(const std::string& file, const std::vector<std::string>& overrides,
          const std::optional<std::string>& old_file);
/// Lists the network types with their samples.
int list_networks();

}  // namespace rubicon::runtime
