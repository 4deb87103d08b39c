#include "apps/rubicon-proxy/check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/rubicon-proxy/engine_setup.h"
#include "apps/rubicon-proxy/parts.h"
#include "base/config_reader.h"
#include "base/text.h"
#include "config/config_file.h"
#include "config/engine_config.h"
#include "config/yaml.h"
#include "island/config_checks.h"
#include "island/island.h"
#include "island/island_state.h"
#include "island/network_types.h"
#include "island/rights_checks.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "trust/site/site_operations.h"
#include "tuples/dds/dds_options.h"
#include "tuples/memory/memory_ecology.h"
#include "tuples/peis/peis_ecology.h"
#include "web/access/token_file.h"
#include "web/web_service.h"

namespace rubicon::daemon {

/// Places of keys in a configuration file that was read before. Reads it again when it is first asked: only who found
/// something wrong needs it.
class ConfigPlaces {
 public:
  ConfigPlaces(std::string file, std::vector<std::string> overrides)
      : file_(std::move(file)), overrides_(std::move(overrides)) {}

  /// `home.yaml:3:7` of the deepest part of the path that is there.
  std::string of(const std::vector<std::string>& path) const;

 private:
  std::string file_;
  std::vector<std::string> overrides_;
  mutable std::optional<ConfigNode> root_;
};

/// Lines for the user, each with its place.
struct HostCheck {
  /// What the configuration names and this host does not have: recordings, folders that are written to, interfaces,
  /// certificates.
  std::vector<std::string> lacking;
  std::vector<std::string> wrong;  ///< on each host, such as the password of a file
  std::vector<std::string> warnings;
};
HostCheck check_host(island::Island& island, transport::Transports& transports, const ConfigPlaces& places);

namespace {

namespace fs = std::filesystem;
using Kind = network::Missing::Kind;

class Findings {
 public:
  explicit Findings(const ConfigPlaces& places) : places_(places) {}

  void add(const std::vector<std::string>& path, std::string_view text, Kind kind = Kind::kOnHost) {
    auto& lines = kind == Kind::kOnHost ? found_.lacking : kind == Kind::kWrong ? found_.wrong : found_.warnings;
    lines.push_back(fmt::format("{}: {}: {}", places_.of(path), fmt::join(path, "."), text));
  }
  /// A file is to be made there. Folders that this user may not read are not checked: the user of the island can.
  void need_folder(const std::vector<std::string>& path, const fs::path& file) {
    const auto folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    std::error_code error;
    const bool there = fs::is_directory(folder, error);
    if (there || (error && error != std::errc::no_such_file_or_directory && error != std::errc::not_a_directory))
      return;
    add(path, fmt::format("there is no folder {}", folder.string()));
  }

  HostCheck take() { return std::move(found_); }

 private:
  const ConfigPlaces& places_;
  HostCheck found_;
};

/// `broker.tls.ca` is an option of an option.
std::vector<std::string> path_of(const std::string& network, const std::string& option) {
  std::vector<std::string> path{"networks", network};
  for (std::size_t begin = 0, end = 0; end != option.npos; begin = end + 1) {
    end = option.find('.', begin);
    path.push_back(option.substr(begin, end - begin));
  }
  return path;
}

}  // namespace

std::string ConfigPlaces::of(const std::vector<std::string>& path) const {
  if (!root_) {
    root_.emplace();
    if (auto root = config::load_config(file_, overrides_)) root_ = std::move(*root);
    config::number_networks(*root_);
  }
  const ConfigNode* node = &*root_;
  ConfigPlace place(file_, 0, 0);
  for (const auto& part : path) {
    node = node->find(part);
    if (!node) break;
    place = node->key_place();
  }
  return to_string(place);
}

HostCheck check_host(island::Island& island, transport::Transports& transports, const ConfigPlaces& places) {
  Findings findings(places);
  const auto& config = island.config();
  for (const auto& setup : config.networks) {
    for (const auto& one : island.networks().find(setup.id)->missing())
      findings.add(path_of(setup.key, one.option), one.text, one.kind);
  }
  if (config.engine.dds) {
    const auto good = tuples::dds::check_interfaces(config.engine.options, transport::interfaces());
    if (!good) findings.add({"tuples", "interfaces"}, good.error().text);
  } else if (config.engine.peis) {
    const auto good = tuples::peis::select_interfaces(config.engine.peis_options, transport::ipv4_interfaces());
    if (!good) findings.add({"tuples", "interfaces"}, good.error().text);
  }
  if (!config.state.file.empty()) findings.need_folder({"state", "file"}, island::state_path(config));
  if (config.history) findings.need_folder({"history", "file"}, fs::path(config.directory) / config.history->file);
  for (const auto& recorder : config.recorders)
    findings.need_folder({"recorders", recorder.name, "file"}, fs::path(config.directory) / recorder.file);
  if (config.web) {
    for (const auto& [key, text] : web::faults_of_files(transports, *config.web, config.directory))
      findings.add({"web", key}, text);
  }
  return findings.take();
}

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
    fmt::print(
        stderr,
        "--diff: the running configuration is kept only beside a state file, and there is none; name it: --diff OLD\n");
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

/// Names and roles of the realm; none without a broker. nullopt: the broker has them, or the realm cannot be read.
std::optional<std::vector<std::string>> names_of_members(const island::IslandConfig& config, WallTime now) {
  if (!config.engine.mqtt) return std::vector<std::string>();
  const auto folder = config.engine.mqtt_space.realm_folder();
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

namespace {

island::IslandConfig island_of(ConfigNode root, const std::string& file, base::ConfigErrors& errors) {
  island::check_ports(root, errors);
  auto config = island::read_island_config(std::move(root), island::network_types(), errors);
  config.directory = std::filesystem::path(file).parent_path().string();
  hold_back_dds(config.engine);
  config.engine.closed = is_closed(config);
  island::check_rights(config, errors);
  island::check_serial_lines(config, errors);
  check_bridges(config.bridges, config.directory, errors);
  return config;
}

}  // namespace

Result<island::IslandConfig> load_island(const std::string& file, const std::vector<std::string>& overrides,
                                         base::ConfigErrors& errors) {
  auto root = config::load_config(file, overrides);
  return root ? Result<island::IslandConfig>(island_of(std::move(*root), file, errors)) : fail(root.error());
}

Result<island::IslandConfig> load_island_text(std::string_view text, const std::string& file,
                                              const std::vector<std::string>& overrides, base::ConfigErrors& errors) {
  auto root = config::parse_yaml(text, file);
  if (!root) return fail(root.error());
  for (const auto& assignment : overrides) {
    if (auto applied = config::apply_override(*root, assignment); !applied) return fail(applied.error());
  }
  return island_of(std::move(*root), file, errors);
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
