#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "base/log.h"
#include "island/island_config.h"
#include "network/supervisor.h"
#include "state/state_store.h"

namespace rubicon::island {

/// Where the configuration wants its state file; empty = nowhere.
std::string state_path(const island::IslandConfig& config);

/// Opens the state file; nullptr if the configuration names none. A damaged one is set aside and a new one begun,
/// loudly. The errors of StateStore::open otherwise.
Result<std::unique_ptr<state::StateStore>> open_state(const island::IslandConfig& config, const Log& log, WallTime now);

/// The copy of the last configuration that worked: beside the state file, `<state file>.good.yaml`.
std::string good_config_path(const island::IslandConfig& config);
/// Keeps that copy of `file`, where there is a state file. kIo otherwise.
Result<void> keep_good_config(const island::IslandConfig& config, const std::string& file);

/// Keeps what networks remember in the state file (docs/state.md).
class NetworkMemory final : public network::NetworkMemory {
 public:
  /// The store must outlive it; nullptr: there is none.
  explicit NetworkMemory(state::StateStore* store) : store_(store) {}

  Result<void> remember(const std::string& network, std::string_view name, ByteView value, network::Keep keep) override;
  Result<std::optional<Bytes>> remembered(const std::string& network, std::string_view name) override;

 private:
  state::StateStore* store_;
};

}  // namespace rubicon::island
