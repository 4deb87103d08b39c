#include "config/bridge_config.h"

#include <fmt/format.h>

#include "rubicon/key.hpp"

namespace rubicon::config {

namespace {

/// It is a part of a key, and of the names of rules.
constexpr std::size_t kMaxName = 40;

}  // namespace

std::vector<BridgeSetup> read_bridges(ConfigReader& root) {
  std::vector<BridgeSetup> all;
  for (auto& [name, bridge] : root.maps("bridges")) {
    if (name != model::to_key_part(name) || name.size() > kMaxName)
      bridge.error("", fmt::format("a bridge's name has [A-Za-z0-9_-]+, at most {} characters", kMaxName));
    if (all.size() == kMaxBridges) bridge.error("", fmt::format("expected at most {} bridges", kMaxBridges));
    const auto type = bridge.required_text("type", "mqtt");
    all.push_back({name, type, bridge.here(), base::packed(bridge.here())});
  }
  return all;
}

}  // namespace rubicon::config
