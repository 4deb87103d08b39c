#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/config_reader.h"
#include "config/audit_config.h"
#include "config/bridge_config.h"
#include "config/config_file.h"
#include "config/engine_config.h"
#include "config/history_config.h"
#include "config/recorder_config.h"
#include "config/rights_config.h"
#include "config/web_config.h"
#include "gateway/gateway.h"
#include "island/own_tuples.h"
#include "model/property_alias.h"
#include "model/type_catalogue.h"
#include "network/network.h"
#include "proxy/proxy_config.h"

namespace rubicon::island {

/// One entry of `networks:`; `options` are the plug-in's own keys.
struct NetworkSetup {
  std::string id;
  const network::NetworkType* type = nullptr;
  ConfigNode options{};
  std::string key{};   ///< in the file; differs from the id where a recording stands for another network (`as`)
  std::string kept{};  ///< the options once they were read (base::packed); empty = not yet

  /// The tree was read: only what a reload compares is kept of it.
  void release_options();
};

/// The keys of a network that are no plug-in's own.
inline constexpr std::string_view kCommonNetworkKeys[] = {"type",    "silence", "rate",    model::kSamplingRate,
                                                          "devices", "as",      "roaming", "valid"};

/// Where the options of one network differ, at most `limit` paths.
std::vector<std::string> differences(const NetworkSetup& before, const NetworkSetup& now, std::size_t limit);

/// `state:`; an empty file = nothing is remembered.
struct StateSetup {
  std::string file;
  std::uint64_t max_bytes = 256ULL << 20;
};

/// A whole configuration file, checked except for the plug-ins' own keys.
struct IslandConfig {
  IslandId id{};
  std::string directory;  ///< of the file; relative paths in it start there
  proxy::ProxyConfig proxy;
  gateway::GatewayLimits limits;
  TypeCatalogue types;
  std::vector<NetworkSetup> networks;
  config::EngineSetup engine;
  StateSetup state;
  /// The sections that a running island cannot change, as the file has them.
  std::vector<std::pair<std::string, ConfigNode>> fixed;
  std::vector<config::RecorderSetup> recorders;
  std::vector<config::BridgeSetup> bridges;     ///< what the daemon keeps beside the island
  std::optional<config::HistorySetup> history;  ///< what the daemon keeps beside the island
  std::optional<config::WebSetup> web;          ///< what the daemon serves beside the island
  std::optional<config::RightsSetup> rights;    ///< of others; without it members with the role admin may do everything
  config::AuditSetup audit;                     ///< of what others ask for, where they are judged
  std::vector<OwnTuple> tuples;                 ///< of the command line
  /// The whole as YAML without secrets, at most SettingsTuples::kMostText, until the island shows it.
  std::string shown;
  /// Where the file names the devices of a network; until the island has taken them.
  std::map<std::string, std::map<std::string, ConfigPlace>> device_places;
};

/// Reads the shape of docs/architecture.md, section 5. Everything wrong is in `errors`; the result is then only good
/// for finding more errors.
IslandConfig read_island_config(ConfigNode root, std::span<const network::NetworkType> types,
                                base::ConfigErrors& errors);

}  // namespace rubicon::island
