#pragma once

#include <span>

#include "network/network.h"

namespace rubicon::island {

/// The types of networks a configuration may name.
std::span<const network::NetworkType> network_types();

}  // namespace rubicon::island
