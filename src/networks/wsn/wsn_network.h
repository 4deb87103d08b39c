#pragma once

#include "network/network.h"

namespace rubicon::networks::wsn {

/// `type: wsn`: the motes behind one sink (docs/motes.md).
extern const network::NetworkType kType;

}  // namespace rubicon::networks::wsn
