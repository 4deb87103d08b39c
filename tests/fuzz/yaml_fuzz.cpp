#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/virtual_scheduler.h"
#include "config/config_file.h"
#include "config/yaml.h"
#include "fuzz_target.h"
#include "island/island.h"
#include "island/network_types.h"
#include "support/memory/memory_transports.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::fuzz::yaml_fuzz {

namespace {

/// Anything that parses must also be checked to the end, down to the keys of the plug-ins.
void check(const ConfigNode& tree) {
  VirtualScheduler time;
  transport::MemoryTransports files;
  base::NullLogSink log;
  tuples::MemoryEcology ecology(time);
  base::ConfigErrors errors;
  auto config = island::read_island_config(tree, island::network_types(), errors);
  const auto island = island::Island::make(std::move(config), time, files, log, ecology, errors);
  if (island.has_value() != errors.empty()) __builtin_trap();
}

}  // namespace

/// A file, and behind a NUL one override of the command line.
FUZZ_TARGET(yaml) {
  if (size > 65536) return 0;
  const std::string_view all(reinterpret_cast<const char*>(data), size);
  const auto nul = all.find('\0');
  auto tree = config::parse_yaml(all.substr(0, nul), "fuzz.yaml");
  if (!tree) {
    if (tree.error().text.empty()) __builtin_trap();
    return 0;
  }
  if (nul != all.npos) {
    if (const auto applied = config::apply_override(*tree, all.substr(nul + 1)); !applied) return 0;
  }
  check(*tree);
  return 0;
}

}  // namespace rubicon::fuzz::yaml_fuzz
