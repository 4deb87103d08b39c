#pragma once

#include <string>
#include <vector>

#include "base/config_reader.h"

namespace rubicon::config {

/// One entry of `bridges:`; `options` are those of its type, which reads them.
struct BridgeSetup {
  std::string name, type;
  ConfigNode options{};
  std::string packed{};  ///< the options (base::packed), to compare

  friend bool operator==(const BridgeSetup& a, const BridgeSetup& b) {
    return a.name == b.name && a.packed == b.packed;
  }
};

inline constexpr std::size_t kMaxBridges = 16;

/// Reads `bridges:`; what is wrong stands in the reader's errors.
std::vector<BridgeSetup> read_bridges(ConfigReader& root);

}  // namespace rubicon::config
