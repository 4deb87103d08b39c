#pragma once

#include "network/network.h"

namespace rubicon::networks::template_network {

/// The smallest network: copy this folder, rename, and replace what the comments say.
extern const network::NetworkType kType;

}  // namespace rubicon::networks::template_network
