#pragma once

#include <span>

#include "network/network.h"

namespace rubicon::runtime {

/// The types of networks a configuration may name.
std::span<const network::NetworkType> network_types();

}  // namespace rubicon::runtime
