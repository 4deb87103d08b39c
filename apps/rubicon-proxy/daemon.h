#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/rubicon-proxy/exit_codes.h"

namespace rubicon::daemon {

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

}  // namespace rubicon::daemon
