#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace rubicon::base {

struct HostPort {
  std::string host;        ///< a name or a numeric address, without brackets; may be empty where `text` was `:PORT`
  std::uint16_t port = 0;  ///< 1..65535

  friend bool operator==(const HostPort&, const HostPort&) = default;
};

/// `HOST:PORT`; an IPv6 address stands in brackets (RFC 3986, 3.2.2): `[::1]:9002`. nullopt for everything else, such
/// as a port 0 or an IPv6 address without brackets.
std::optional<HostPort> parse_host_port(std::string_view text);

/// The same, or only `HOST`, which then has the default port.
std::optional<HostPort> parse_host_port(std::string_view text, std::uint16_t default_port);

/// Why a text is no host to connect to, a name or a numeric address; empty = it may be one. `expected ...` or what it
/// is.
std::string host_fault(std::string_view text);

}  // namespace rubicon::base
