#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/config_reader.h"
#include "base/text.h"
#include "rubicon/key.hpp"

namespace rubicon::config {

inline constexpr std::uint16_t kWebPort = 8642;

/// Files of a server, as configured: its certificate with those that lead to its authority, and its key (PEM).
struct WebTls {
  std::string certificate, key;

  friend bool operator==(const WebTls&, const WebTls&) = default;
};

/// `web:`: the page in a browser, and its API.
struct WebSetup {
  base::HostPort listen{"127.0.0.1", kWebPort};  ///< numeric address; port 0 = any free one
  std::optional<WebTls> tls{};
  std::optional<std::string> tokens{};  ///< file, as configured; nullopt = every caller may do everything
  std::vector<std::string> hosts{};     ///< names of this server besides IP addresses and localhost
  std::vector<std::string> origins{};   ///< `https://hall.lan`: pages of other servers that may use this one
  std::vector<Pattern> metrics{};       ///< values in /metrics
  std::string files{};                  ///< folder with the page, as configured; empty = the one in the program
  bool compress = false;                ///< WebSockets (RFC 7692)
  bool trust_lan = false;               ///< no TLS and no tokens although others reach the port

  friend bool operator==(const WebSetup&, const WebSetup&) = default;
};

/// `HOST:PORT` with a numeric address or `localhost`, which becomes 127.0.0.1; `:PORT` and `PORT` for loopback.
std::optional<base::HostPort> parse_web_listen(std::string_view text);
/// Why nothing may listen like this; empty if it may. Others than this host need TLS and tokens.
std::string web_exposure(const WebSetup& setup);

/// Reads `web:`; nullopt if there is none. What is wrong stands in the reader's errors.
std::optional<WebSetup> read_web(ConfigReader& root);

/// One entry of `bridges:`; `options` are those of its type, which reads them.
struct BridgeSetup {
  std::string name, type;
  ConfigNode options{};
  std::string packed{};  ///< the options (base::packed), to compare

  friend bool operator==(const BridgeSetup& a, const BridgeSetup& b) {
    return a.name == b.name && a.packed == b.packed;
  }
};

inline constexpr std::size_t kMaxBridges = 16;

/// Reads `bridges:`; what is wrong stands in the reader's errors.
std::vector<BridgeSetup> read_bridges(ConfigReader& root);

}  // namespace rubicon::config
