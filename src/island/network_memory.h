#pragma once

#include <string>
#include <string_view>

#include "network/supervisor.h"
#include "state/state_store.h"

namespace rubicon::island {

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
