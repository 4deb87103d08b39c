#include "apps/rubicon-proxy/check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "apps/rubicon-proxy/bridges_part.h"
#include "apps/rubicon-proxy/host_check.h"
#include "apps/rubicon-proxy/host_place.h"
#include "apps/rubicon-proxy/old_trust.h"
#include "base/text.h"
#include "config/carry_config.h"
#include "config/config_file.h"
#include "island/island.h"
#include "island/island_state.h"
#include "island/network_types.h"
#include "island/point_names.h"
#include "island/rights_checks.h"
#include "island/serial_lines.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "trust/site/site_operations.h"
#include "tuples/memory/memory_ecology.h"
#include "web/access/token_file.h"

namespace rubicon::daemon {

namespace {

constexpr std::size_t kMaxErrorsShown = 50;

void print(const std::vector<std::string>& lines, std::string_view before = {}) {
  for (std::size_t i = 0; i < std::min(lines.size(), kMaxErrorsShown); ++i)
    fmt::print(stderr, "{}{}\n", before, lines[i]);
  if (lines.size() > kMaxErrorsShown) fmt::print(stderr, "... and {} more\n", lines.size() - kMaxErrorsShown);
}

/// What a reload of the file would do to an island that runs with the other one.
int print_plan(const CheckOptions& options) {
  base::ConfigErrors errors;
  const auto next = load_island(options.file, options.overrides, errors);
  if (!next) return report(next.error());
  const auto path = options.against->empty() ? island::good_config_path(*next) : *options.against;
  if (path.empty()) {
    fmt::print(stderr, "--diff: no state file, so nothing is kept of the running configuration; name it: --diff OLD\n");
    return kExitConfiguration;
  }
  const auto now = load_island(path, options.overrides, errors);
  if (!now) return report(now.error());
  if (!errors.empty()) {
    print(errors.lines());
    return kExitConfiguration;
  }
  const auto plan = island::plan_reload(*now, *next);
  for (const auto& line : plan.refusals) fmt::print("refused: {}\n", line);
  for (const auto& line : plan.lines) fmt::print("{}\n", line);
  if (plan.refusals.empty() && plan.lines.empty()) fmt::print("nothing would change\n");
  const bool files = std::any_of(next->networks.begin(), next->networks.end(),
                                 [](const auto& setup) { return !setup.type->file_options.empty(); });
  if (files) fmt::print("whether files that options name have changed, `reload try` of the running island says\n");
  return plan.refusals.empty() ? kExitOk : kExitConfiguration;
}

std::vector<std::string> warnings(island::Island& island, const ConfigPlaces& places) {
  std::vector<std::string> lines;
  for (const auto& setup : island.config().networks) {
    const auto& rules = island.config().proxy.networks.at(setup.id);
    if (rules.devices.empty()) continue;
    for (const auto& lost :
         island::lost_names(rules, island.networks().find(setup.id)->listed(), island.config().types)) {
      std::vector<std::string> path{"networks", setup.key, "devices"};
      path.insert(path.end(), lost.path.begin(), lost.path.end());
      lines.push_back(fmt::format("{}: {}: {}", places.of(path), fmt::join(path, "."), lost.text));
    }
  }
  return lines;
}

std::string ids(const island::IslandConfig& config) {
  std::vector<std::string> all;
  for (const auto& setup : config.networks) all.push_back(setup.id);
  return all.empty() ? "no networks"
                     : fmt::format("{} network{} ({})", all.size(), all.size() == 1 ? "" : "s", fmt::join(all, ", "));
}

/// Names and roles of the realm; nullopt: there is none, or it cannot be read.
std::optional<std::vector<std::string>> names_of_members(const island::IslandConfig& config, WallTime now) {
  const auto folder = config.engine.mqtt ? config.engine.mqtt_space.realm_folder() : "";
  if (folder.empty()) return std::nullopt;
  const auto there = trust::site::contents_of(folder, now);
  if (!there) return std::nullopt;
  std::vector<std::string> names;
  for (const auto& one : there->members) {
    names.push_back(one.name);
    names.insert(names.end(), one.roles.begin(), one.roles.end());
  }
  return names;
}

/// What rules may name; nullopt: some of it is not known here.
std::optional<std::vector<std::string>> known_names(const island::IslandConfig& config,
                                                    transport::Transports& transports, Scheduler& scheduler) {
  auto names = names_of_members(config, scheduler.wall_now());
  if (!names || !config.web || !config.web->tokens) return names;
  const auto tokens = web::access::read_tokens(transports, base::resolve_path(config.directory, *config.web->tokens));
  if (!tokens) return std::nullopt;
  const auto more = web::access::names_of(*tokens);
  names->insert(names->end(), more.begin(), more.end());
  return names;
}

}  // namespace

int report(const Error& error) {
  fmt::print(stderr, "{}\n", error.text);
  const bool is_elsewhere = error.code == ErrorCode::kIo || error.code == ErrorCode::kDuplicate;
  return is_elsewhere ? kExitFailed : kExitConfiguration;
}

Result<island::IslandConfig> load_island(const std::string& file, const std::vector<std::string>& overrides,
                                         base::ConfigErrors& errors) {
  auto root = config::load_config(file, overrides);
  if (!root) return fail(root.error());
  auto config = island::read_island_config(std::move(*root), island::network_types(), errors);
  config.directory = std::filesystem::path(file).parent_path().string();
  hold_back_dds(config.engine);
  config.engine.closed = is_closed(config);
  island::check_rights(config, errors);
  island::check_serial_lines(config, errors);
  check_bridges(config.bridges, config.directory, errors);
  return config;
}

int check(const CheckOptions& options) {
  base::ConfigErrors errors;
  auto config = load_island(options.file, options.overrides, errors);
  if (!config) return report(config.error());
  const auto networks = ids(*config);
  std::size_t devices = 0;
  for (const auto& [id, rules] : config->proxy.networks) devices += rules.devices.size();
  // Making the networks checks their own keys; nothing is opened.
  base::NullLogSink quiet;
  transport::Loop loop;
  transport::LocalTransports transports(loop);
  tuples::MemoryEcology ecology(loop.scheduler());
  auto island = island::Island::make(std::move(*config), loop.scheduler(), transports, quiet, ecology, errors);
  if (!errors.empty()) {
    print(errors.lines());
    return kExitConfiguration;
  }
  if (!island) return report(island.error());
  const ConfigPlaces places(options.file, options.overrides);
  print((*island)->config().engine.warnings, "warning: ");
  print(warnings(**island, places), "warning: ");
  print(island::rights_warnings((*island)->config(), known_names((*island)->config(), transports, loop.scheduler())),
        "warning: ");
  print(held_back_lines((*island)->config().engine), "warning: ");
  const auto found = check_host(**island, transports, places);
  print(found.warnings, "warning: ");
  print(found.wrong);
  if (!options.elsewhere && !found.lacking.empty()) {
    print(found.lacking);
    fmt::print(stderr, "as seen on this host; `check --elsewhere` is for the files of another one\n");
    return kExitConfiguration;
  }
  if (!found.wrong.empty()) return kExitConfiguration;
  fmt::print("{}: ok: {}, {} device{} named\n", options.file, networks, devices, devices == 1 ? "" : "s");
  if (const auto open = who_may_command((*island)->config()); !open.empty()) fmt::print("{}\n", open);
  if (const auto all = config::carried((*island)->config().engine.carry); !all.empty())
    fmt::print("carries {}\n", fmt::join(all, "; "));
  return options.against ? print_plan(options) : kExitOk;
}

}  // namespace rubicon::daemon
