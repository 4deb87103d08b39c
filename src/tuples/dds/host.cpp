#include "tuples/dds/host.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>

namespace rubicon::tuples::dds {

namespace {

std::string address_of(const sockaddr& address) {
  if (address.sa_family != AF_INET) return {};
  std::array<char, INET_ADDRSTRLEN> text{};
  const auto& ipv4 = reinterpret_cast<const sockaddr_in&>(address);
  return ::inet_ntop(AF_INET, &ipv4.sin_addr, text.data(), text.size()) ? text.data() : std::string();
}

Interface& find_or_add(std::vector<Interface>& all, const std::string& name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.name == name; });
  return found == all.end() ? all.emplace_back(Interface{name, {}, false, false}) : *found;
}

std::string names_of(const std::vector<Interface>& all) {
  std::vector<std::string_view> names;
  for (const auto& one : all) names.push_back(one.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// Empty: no such host.
std::string resolved(const std::string& name) {
  addrinfo wanted{};
  wanted.ai_family = AF_INET;
  wanted.ai_socktype = SOCK_DGRAM;
  addrinfo* list = nullptr;
  if (::getaddrinfo(name.c_str(), nullptr, &wanted, &list) != 0) return {};
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(list, &::freeaddrinfo);
  return list ? address_of(*list->ai_addr) : std::string();
}

Result<void> check(const Interface& one, bool needs_multicast) {
  if (!one.is_up) {
    return fail(ErrorCode::kIo, fmt::format("DDS: interface '{0}' is down: bring it up (ip link set {0} up){1}",
                                            one.name, one.name == "lo" ? ", or set tuples.engine: memory" : ""));
  }
  if (one.address.empty())
    return fail(ErrorCode::kIo, fmt::format("DDS: interface '{}' has no IPv4 address", one.name));
  if (needs_multicast && !one.has_multicast) {
    return fail(ErrorCode::kIo,
                fmt::format("DDS: interface '{}' has no multicast: name the other hosts in tuples.peers", one.name));
  }
  return {};
}

}  // namespace

std::vector<Interface> interfaces() {
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> owner(list, &::freeifaddrs);
  std::vector<Interface> all;
  for (const auto* one = list; one; one = one->ifa_next) {
    auto& known = find_or_add(all, one->ifa_name);
    known.is_up = (one->ifa_flags & IFF_UP) != 0;
    known.has_multicast = (one->ifa_flags & IFF_MULTICAST) != 0;
    if (one->ifa_addr && known.address.empty()) known.address = address_of(*one->ifa_addr);
  }
  return all;
}

Result<void> check_interfaces(const DdsOptions& options, const std::vector<Interface>& there) {
  const bool needs_multicast =
      !is_loopback_only(options) && options.peers.empty() && options.transport == DdsTransport::kUdp;
  for (const auto& name : options.interfaces) {
    const auto found = std::find_if(there.begin(), there.end(), [&](const auto& one) { return one.name == name; });
    if (found == there.end()) {
      return fail(ErrorCode::kIo,
                  fmt::format("DDS: there is no interface '{}' on this host; there are: {}", name, names_of(there)));
    }
    if (auto good = check(*found, needs_multicast); !good) return good;
  }
  return {};
}

bool has_address(const std::string& peer) {
  in_addr address{};
  return ::inet_pton(AF_INET, peer.substr(0, peer.find(':')).c_str(), &address) == 1;
}

std::vector<std::string> with_addresses(std::vector<std::string> peers, Scheduler& scheduler, Duration patience,
                                        std::vector<std::string>& unknown) {
  const auto end = scheduler.now() + patience;
  for (auto& peer : peers) {
    if (has_address(peer)) continue;
    const auto colon = std::min(peer.find(':'), peer.size());
    const auto address = scheduler.now() < end ? resolved(peer.substr(0, colon)) : std::string();
    if (address.empty()) {
      unknown.push_back(peer);
    } else {
      peer.replace(0, colon, address);
    }
  }
  return peers;
}

std::string host_id(const std::string& purpose) {
  std::string boot;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), boot);
  std::array<char, 64> space{};
  const auto length = ::readlink("/proc/self/ns/net", space.data(), space.size());
  const auto text =
      purpose + '\n' + boot + '\n' + std::string(space.data(), length > 0 ? static_cast<std::size_t>(length) : 0);
  std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return fmt::format("{:016x}", hash);
}

}  // namespace rubicon::tuples::dds
