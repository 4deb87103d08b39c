#include "config/service_config.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "rubicon/key.hpp"

namespace rubicon::config {

namespace {

constexpr const char* kLoopbackAddress = "127.0.0.1";
constexpr std::uint8_t kLoopbackNetwork = 127;
constexpr std::size_t kMaxNameCount = 64;

bool is_ip_loopback(const std::string& host) {
  in_addr four{};
  in6_addr six{};
  if (::inet_pton(AF_INET, host.c_str(), &four) == 1) return (ntohl(four.s_addr) >> 24U) == kLoopbackNetwork;
  return ::inet_pton(AF_INET6, host.c_str(), &six) == 1 && IN6_IS_ADDR_LOOPBACK(&six);
}

bool is_numeric(const std::string& host) {
  in6_addr room{};
  return ::inet_pton(AF_INET, host.c_str(), &room) == 1 || ::inet_pton(AF_INET6, host.c_str(), &room) == 1;
}

bool is_host_name(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-';
  });
}

/// `https://hall.lan` or `http://hall.lan:8080` (RFC 6454, section 6.2).
bool is_origin(std::string_view text) {
  for (const std::string_view scheme : {"https://", "http://"}) {
    if (!text.starts_with(scheme)) continue;
    const auto rest = base::parse_host_port(text.substr(scheme.size()), 1);
    return rest && (is_host_name(rest->host) || is_numeric(rest->host));
  }
  return false;
}

void read_names(ConfigReader& web, const std::string& key, std::vector<std::string>& names,
                bool (*fits)(std::string_view), std::string_view expected) {
  names = web.texts(key);
  if (names.size() > kMaxNameCount)
    web.error(key, fmt::format("has {} names, expected at most {}", names.size(), kMaxNameCount));
  for (const auto& name : names) {
    if (!fits(name)) web.error(key, fmt::format("'{}': expected {}", name, expected));
  }
}

void read_tls(ConfigReader& web, WebSetup& setup) {
  auto tls = web.map("tls");
  if (web.has("tls"))
    setup.tls = {tls.required_text("certificate", "a PEM file, such as web.pem"),
                 tls.required_text("key", "a PEM file, such as web.key")};
  tls.finish();
  auto tokens = web.map("tokens");
  if (web.has("tokens"))
    setup.tokens = tokens.required_text("file", "a file that `rubicon token` writes, such as web.tokens");
  if (tokens.has("file") && setup.tokens->empty()) tokens.error("file", "empty path, expected a file");
  tokens.finish();
}

void read_metrics(ConfigReader& web, WebSetup& setup) {
  auto metrics = web.map("metrics");
  for (const auto& text : metrics.texts("patterns")) {
    auto pattern = Pattern::parse(text);
    if (pattern) {
      setup.metrics.push_back(std::move(*pattern));
    } else {
      metrics.error("patterns", pattern.error().text);
    }
  }
  metrics.finish();
}

}  // namespace

std::optional<base::HostPort> parse_web_listen(std::string_view text) {
  const auto colon = text.rfind(':');
  const auto port = base::parse_number<std::uint16_t>(colon == text.npos ? text : text.substr(colon + 1));
  if (!port) return std::nullopt;
  if (colon == text.npos || colon == 0) return base::HostPort{kLoopbackAddress, *port};
  auto both = base::parse_host_port(text.substr(0, colon), 1);
  if (!both) return std::nullopt;
  if (both->host == "localhost") both->host = kLoopbackAddress;
  if (!is_numeric(both->host)) return std::nullopt;
  return base::HostPort{both->host, *port};
}

std::string web_exposure(const WebSetup& setup) {
  if (is_ip_loopback(setup.listen.host) || setup.trust_lan || (setup.tls && setup.tokens)) return {};
  return fmt::format(
      "{} can be reached by other hosts: expected tls: {{certificate: web.pem, key: web.key}} and tokens: {{file: "
      "web.tokens}}; "
      "`trust_lan: yes` gives everybody there everything without both",
      setup.listen.host);
}

std::optional<WebSetup> read_web(ConfigReader& root) {
  if (!root.has("web")) return std::nullopt;
  auto web = root.map("web");
  WebSetup setup;
  const auto listen = parse_web_listen(web.text("listen", fmt::format("{}:{}", kLoopbackAddress, kWebPort)));
  if (listen) {
    setup.listen = *listen;
  } else {
    web.error("listen", "expected an IP address and a port, such as 127.0.0.1:8642, [::1]:8642 or 0.0.0.0:8642");
  }
  read_tls(web, setup);
  read_names(web, "hosts", setup.hosts, is_host_name, "a name of this host, such as hall.lan");
  read_names(web, "origins", setup.origins, is_origin, "the beginning of an address, such as https://hall.lan");
  read_metrics(web, setup);
  setup.files = web.text("files", "");
  setup.compress = web.boolean("compress", false);
  setup.trust_lan = web.boolean("trust_lan", false);
  if (const auto wrong = web_exposure(setup); !wrong.empty()) web.error(web.has("listen") ? "listen" : "", wrong);
  web.finish();
  return setup;
}

namespace {

/// It is a part of a key, and of the names of rules.
constexpr std::size_t kMaxName = 40;

}  // namespace

std::vector<BridgeSetup> read_bridges(ConfigReader& root) {
  std::vector<BridgeSetup> all;
  for (auto& [name, bridge] : root.maps("bridges")) {
    if (name != model::to_key_part(name) || name.size() > kMaxName)
      bridge.error("", fmt::format("a bridge's name has [A-Za-z0-9_-]+, at most {} characters", kMaxName));
    if (all.size() == kMaxBridges) bridge.error("", fmt::format("expected at most {} bridges", kMaxBridges));
    const auto type = bridge.required_text("type", "mqtt");
    all.push_back({name, type, bridge.here(), base::packed(bridge.here())});
  }
  return all;
}

}  // namespace rubicon::config
