#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rubicon/result.hpp"

namespace rubicon::transport {

/// Host name of this machine; empty if the system does not provide it.
std::string host_name();

/// 16 hex digits that are the same for all processes that share a boot of the kernel and a network namespace, and
/// differ for all others. The ids for two purposes cannot be derived from each other. Components declare the one for
/// `host` (tuples/link.h), whatever their engine.
std::string host_id(const std::string& purpose);

/// Process id and user of this process, for lists of components: `pid 4711 of anna`.
std::string own_process();

enum class AddressFamily : std::uint8_t { kAny, kIpv4 };

/// The numeric addresses of a host, IPv4 ones first, never empty. Blocks until the system's resolver answers or gives
/// up. kUnreachable with the resolver's reason.
Result<std::vector<std::string>> resolve(const std::string& host, AddressFamily family = AddressFamily::kAny);

/// Whether the text is a numeric address: IPv4 with four parts, or IPv6 without a scope.
bool is_numeric_address_text(const std::string& text);
/// Whether it is one of 127.0.0.0/8 or ::1.
bool is_loopback_address(const std::string& text);

}  // namespace rubicon::transport
