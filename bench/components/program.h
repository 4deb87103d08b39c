#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "components/node.h"
#include "components/processes.h"
#include "components/report.h"

namespace CLI {
class App;
}

namespace rubicon::bench {

/// A program that measures components in several processes: it starts itself again for each of them.
struct ComponentProgram {
  const char* purpose = "";
  OpenEngine open_engine = nullptr;
  /// By name, in this order.
  std::vector<std::pair<std::string, void (*)(const Plan&, Report&)>> measurements;
  /// Of its own; those of roles.h are known.
  std::map<std::string, Role> roles{};
  /// Between which `--engine` chooses; the first is the default.
  std::vector<std::string> engines{};
  std::uint32_t highest_domain = 0;  ///< of DDS; 0 = the engine has no domains
  /// The engine meets only components that somebody names: who awaits one subscribes to a tuple of it.
  bool awaits_by_name = false;
  /// Adds its own options, of the process that measures.
  void (*add_options)(CLI::App& app) = nullptr;
};

/// Makes the measurements that the command line names, in a private network if permitted, and prints one JSON object;
/// or plays a role in one of them, and prints its result. Returns the exit code.
int run_components(int count, char** values, const ComponentProgram& program);

}  // namespace rubicon::bench
