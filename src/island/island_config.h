#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/config_reader.h"
#include "config/config_file.h"
#include "config/engine_config.h"
#include "config/rights_config.h"
#include "config/service_config.h"
#include "config/storage_config.h"
#include "gateway/gateway.h"
#include "model/type_catalogue.h"
#include "model/type_names.h"
#include "network/network.h"
#include "proxy/proxy_config.h"
#include "rubicon/result.hpp"
#include "rubicon/tuple_space.hpp"

namespace rubicon::island {

/// A tuple that the island owns because its start said so: `--tuple KEY=VALUE`.
struct OwnTuple {
  std::string key, value;
};

/// Reads `KEY=VALUE` one by one (the value may be empty and hold further equals signs). kInvalid for what is none,
/// names a key twice, or names a key that the island keeps itself (below `prefix`, GATEWAY, ROAMING).
Result<std::vector<OwnTuple>> read_own_tuples(const std::vector<std::string>& texts, std::string_view prefix);

/// Keeps them in the space: text/plain, without expiry, and others may set them (as the original's command line does).
class OwnTuples {
 public:
  OwnTuples(TupleSpace& space, std::vector<OwnTuple> tuples) : space_(space), tuples_(std::move(tuples)) {}

  /// Publishes all of them.
  void start();

 private:
  TupleSpace& space_;
  std::vector<OwnTuple> tuples_;
  std::vector<tuples::Handle> judges_;
};

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
  /// The whole as YAML without secrets, at most SettingsTuples::kMaxTextCount, until the island shows it.
  std::string shown;
  /// Where the file names the devices of a network; until the island has taken them.
  std::map<std::string, std::map<std::string, ConfigPlace>> device_places;
};

/// Reads the shape of docs/architecture.md, section 5. Everything wrong is in `errors`; the result is then only good
/// for finding more errors.
IslandConfig read_island_config(ConfigNode root, std::span<const network::NetworkType> types,
                                base::ConfigErrors& errors);

}  // namespace rubicon::island
