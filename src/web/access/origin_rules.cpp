#include "web/access/origin_rules.h"

#include <arpa/inet.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <optional>

#include "base/host_port.h"

namespace rubicon::web::access {

namespace {

constexpr std::uint16_t kHttp = 80;
constexpr std::uint16_t kHttps = 443;

std::string lowered(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

bool is_ip_address(const std::string& host) {
  in6_addr room{};
  return ::inet_pton(AF_INET, host.c_str(), &room) == 1 || ::inet_pton(AF_INET6, host.c_str(), &room) == 1;
}

bool has_member(const std::vector<std::string>& list, const std::string& lower) {
  return std::any_of(list.begin(), list.end(), [&](const auto& one) { return lowered(one) == lower; });
}

}  // namespace

bool OriginRules::is_own_host(std::string_view host) const {
  const auto parsed = base::parse_host_port(lowered(host), kHttp);
  if (!parsed) return false;
  return parsed->host == "localhost" || is_ip_address(parsed->host) || has_member(hosts, parsed->host);
}

bool OriginRules::is_own_origin(std::string_view origin, std::string_view host, bool secure) const {
  if (is_listed(origin)) return true;
  const std::string_view scheme = secure ? "https://" : "http://";
  const auto text = lowered(origin);
  if (!text.starts_with(scheme)) return false;
  const auto port = secure ? kHttps : kHttp;
  const auto theirs = base::parse_host_port(std::string_view(text).substr(scheme.size()), port);
  const auto ours = base::parse_host_port(lowered(host), port);
  return theirs && ours && *theirs == *ours;
}

bool OriginRules::is_listed(std::string_view origin) const {
  return has_member(origins, lowered(origin));
}

}  // namespace rubicon::web::access
