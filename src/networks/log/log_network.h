#pragma once

#include "network/network.h"

namespace rubicon::networks::log {

/// Replays recordings: the original recorder's packet logs and text tables (D1.4, LOG network).
extern const network::NetworkType kType;

}  // namespace rubicon::networks::log
