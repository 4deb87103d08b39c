#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "base/virtual_scheduler.h"
#include "config/yaml.h"
#include "console/shell.h"
#include "fuzz_target.h"
#include "island/island.h"
#include "island/network_types.h"
#include "support/memory/memory_transports.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::fuzz::shell_fuzz {

namespace {

constexpr std::string_view kIsland =
    "island: {id: 1}\nnetworks:\n  dummy: {type: dummy, simulate: {a: {sensors: {light-1: {}}, actuators: {lamp-1: "
    "{}}}}}\n";

std::unique_ptr<island::Island> make_island(VirtualScheduler& time, transport::MemoryTransports& files,
                                            base::LogSink& log, tuples::MemoryEcology& ecology) {
  static const auto tree = config::parse_yaml(kIsland, "island.yaml");
  base::ConfigErrors errors;
  auto config = island::read_island_config(tree.value(), island::network_types(), errors);
  return std::move(island::Island::make(std::move(config), time, files, log, ecology, errors).value());
}

/// Every line a shell writes is one JSON object.
void check(const std::string& line) {
  const auto json = nlohmann::json::parse(line, nullptr, false);
  if (!json.is_object() || line.find('\n') != line.npos) __builtin_trap();
}

}  // namespace

/// Lines of a shell on a living island; time passes between them.
FUZZ_TARGET(shell) {
  if (size > 16384) return 0;
  VirtualScheduler time;
  transport::MemoryTransports files;
  base::NullLogSink log;
  tuples::MemoryEcology ecology(time);
  const auto island = make_island(time, files, log, ecology);
  const auto link = ecology.join(OwnerId(65536)).value();
  TupleSpace space(OwnerId(65536), time, *link);
  island->start();
  console::Shell shell(time, space, OwnerId(1), "proxy", check, check, [] {});
  time.run_for(std::chrono::milliseconds(10));
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  while (!rest.empty()) {
    const auto end = rest.find('\n');
    shell.line(rest.substr(0, end));
    time.run_for(std::chrono::milliseconds(1));
    rest.remove_prefix(end == rest.npos ? rest.size() : end + 1);
  }
  bool idle = false;
  shell.when_idle([&idle] { idle = true; });
  time.run_for(std::chrono::seconds(6));
  if (!idle) __builtin_trap();
  return 0;
}

}  // namespace rubicon::fuzz::shell_fuzz
