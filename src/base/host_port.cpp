#include "base/host_port.h"

#include <algorithm>

#include "base/text.h"

namespace rubicon::base {

namespace {

/// The host before the colon, without its brackets; nullopt if the brackets or colons are wrong.
std::optional<std::string> host_in(std::string_view text) {
  if (text.starts_with('[')) {
    if (text.size() < 3 || !text.ends_with(']')) return std::nullopt;
    text = text.substr(1, text.size() - 2);
    if (text.find(':') == text.npos) return std::nullopt;
  } else if (text.find(':') != text.npos) {
    return std::nullopt;
  }
  if (text.find_first_of("[] \t") != text.npos) return std::nullopt;
  return std::string(text);
}

/// Four numbers up to 255.
bool is_ipv4(std::string_view text) {
  for (int part = 0; part < 4; ++part) {
    const auto dot = text.find('.');
    if ((dot == text.npos) != (part == 3) || !parse_number<std::uint8_t>(text.substr(0, dot))) return false;
    text.remove_prefix(dot == text.npos ? text.size() : dot + 1);
  }
  return true;
}

}  // namespace

std::string host_fault(std::string_view text) {
  if (text.empty() || text.find_first_of("/@ \t") != text.npos) return "expected a host name or an address";
  if (text.find_first_not_of("0123456789.") == text.npos && !is_ipv4(text)) return "is no IPv4 address";
  const auto colon = text.find(':');
  const bool has_port =
      colon != text.npos && colon == text.rfind(':') && text.find_first_not_of("0123456789", colon + 1) == text.npos;
  return has_port ? "names a port too, which stands in 'port'" : "";
}

std::optional<HostPort> parse_host_port(std::string_view text) {
  const auto colon = text.rfind(':');
  if (colon == text.npos) return std::nullopt;
  const auto port = parse_number<std::uint16_t>(text.substr(colon + 1));
  auto host = host_in(text.substr(0, colon));
  if (!port || *port == 0 || !host) return std::nullopt;
  return HostPort{std::move(*host), *port};
}

std::optional<HostPort> parse_host_port(std::string_view text, std::uint16_t default_port) {
  if (auto both = parse_host_port(text)) return both;
  auto host = host_in(text);
  if (!host || host->empty()) return std::nullopt;
  return HostPort{std::move(*host), default_port};
}

}  // namespace rubicon::base
