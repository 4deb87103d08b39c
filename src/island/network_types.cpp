#include "island/network_types.h"

// The build makes this header from src/networks/networks.cmake.
#include "networks/all_networks.h"

namespace rubicon::island {

std::span<const network::NetworkType> network_types() {
  static const auto kTypes = networks::all_types();
  return kTypes;
}

}  // namespace rubicon::island
