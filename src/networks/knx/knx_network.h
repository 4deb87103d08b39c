#pragma once

#include "network/network.h"

namespace rubicon::networks::knx {

/// The devices of a KNX installation through a KNXnet/IP tunnel or by routing: see README.md.
extern const network::NetworkType kType;

}  // namespace rubicon::networks::knx
