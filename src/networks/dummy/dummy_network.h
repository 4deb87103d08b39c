#pragma once

#include "network/network.h"

namespace rubicon::networks::dummy {

/// Devices played from the configuration: values by waves, actuators that obey, ignore or fail (D1.4, DUMMY network).
extern const network::NetworkType kType;

}  // namespace rubicon::networks::dummy
