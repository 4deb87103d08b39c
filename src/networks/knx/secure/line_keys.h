#pragma once

#include <cstdint>
#include <optional>

#include "networks/knx/secure/passwords.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::knx::secure {

/// What a client needs for a tunnel through KNX IP Secure.
struct SessionKeys {
  /// 1 is the management user; tunnels have 2 to 127. Other numbers are reserved.
  std::uint8_t user = 2;
  PasswordKey user_key;
  /// nullopt: the client cannot verify that the server is the device that it expects.
  std::optional<PasswordKey> device_code{};
};

/// What a client needs for secure routing.
struct RoutingKeys {
  Key backbone;
  Duration latency = std::chrono::seconds(2);  ///< tolerance, 1 ms to 8 s
};

}  // namespace rubicon::networks::knx::secure
