#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rubicon/result.hpp"

namespace rubicon::transport {

enum class AddressFamily : std::uint8_t { kAny, kIpv4 };

/// The numeric addresses of a host, IPv4 ones first, never empty. Blocks until the system's resolver answers or gives
/// up. kUnreachable with the resolver's reason.
Result<std::vector<std::string>> resolve(const std::string& host, AddressFamily family = AddressFamily::kAny);

}  // namespace rubicon::transport
