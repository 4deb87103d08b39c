#include "transport/interfaces.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <memory>

namespace rubicon::transport {

namespace {

/// Empty: no IPv4 address.
std::string ipv4_text(const sockaddr* address) {
  if (address == nullptr || address->sa_family != AF_INET) return {};
  std::array<char, INET_ADDRSTRLEN> text{};
  const auto* ipv4 = reinterpret_cast<const sockaddr_in*>(address);
  return ::inet_ntop(AF_INET, &ipv4->sin_addr, text.data(), text.size()) ? text.data() : std::string();
}

/// As the system lists them: once for each address of any family.
std::vector<Interface> listed() {
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return {};
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owner(list, ::freeifaddrs);
  std::vector<Interface> all;
  for (const auto* entry = list; entry != nullptr; entry = entry->ifa_next) {
    all.push_back({entry->ifa_name, ipv4_text(entry->ifa_addr), (entry->ifa_flags & IFF_UP) != 0,
                   (entry->ifa_flags & IFF_MULTICAST) != 0, (entry->ifa_flags & IFF_LOOPBACK) != 0,
                   (entry->ifa_flags & IFF_RUNNING) != 0, ::if_nametoindex(entry->ifa_name)});
  }
  return all;
}

}  // namespace

std::vector<Interface> interfaces() {
  std::vector<Interface> all;
  for (auto& entry : listed()) {
    const auto known = std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.name == entry.name; });
    if (known == all.end()) {
      all.push_back(std::move(entry));
    } else if (known->address.empty()) {
      known->address = std::move(entry.address);
    }
  }
  return all;
}

std::vector<Interface> ipv4_interfaces() {
  auto all = listed();
  std::erase_if(all, [](const auto& one) { return !one.is_up || one.address.empty(); });
  return all;
}

}  // namespace rubicon::transport
