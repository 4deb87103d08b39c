#pragma once

#include "network/network.h"

namespace rubicon::networks::salad {

/// The devices of Tecnalia's SALAD middleware, over UDP (D1.4, Salad Tecnalia Middleware; salad.md).
extern const network::NetworkType kType;

}  // namespace rubicon::networks::salad
