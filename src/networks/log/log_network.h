#pragma once

#include "network/network.h"

namespace rubicon::networks::log {

/// Replays recordings: our own, the original recorder's packet logs, text tables (D1.4, LOG network).
extern const network::NetworkType kType;

}  // namespace rubicon::networks::log
