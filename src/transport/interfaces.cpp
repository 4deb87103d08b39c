#include "transport/interfaces.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

#include "transport/descriptor_watch.h"

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

namespace {

/// Messages taken in one turn; the rest follows in the next one.
constexpr int kMaxMessages = 64;

class NetlinkWatch final : public InterfaceWatch {
 public:
  NetlinkWatch(OwnDescriptor socket, const WatchDescriptor& watch, std::function<void()> changed)
      : socket_(std::move(socket)), changed_(std::move(changed)) {
    watch_ = watch(socket_.get(), {[this] { readable(); }, nullptr});
    watch_->await_readable();
  }

  std::vector<Interface> interfaces() const override { return transport::interfaces(); }

 private:
  /// What they say is read from the system anew: after a message was lost (ENOBUFS) the others are not enough.
  void readable() {
    std::array<char, 4096> message{};
    for (int count = 0; count < kMaxMessages; ++count) {
      const auto size = ::recv(socket_.get(), message.data(), message.size(), MSG_DONTWAIT);
      if (size < 0 && errno != ENOBUFS && errno != EINTR) break;
    }
    watch_->await_readable();
    const auto changed = changed_;  // it may destroy this
    changed();
  }

  OwnDescriptor socket_;
  std::function<void()> changed_;
  std::unique_ptr<DescriptorWatch> watch_;  // ends before the socket
};

}  // namespace

WatchInterfaces netlink_interfaces(WatchDescriptor watch) {
  return [watch = std::move(watch)](std::function<void()> changed) -> Result<std::unique_ptr<InterfaceWatch>> {
    const auto cannot = [] {
      return fail(ErrorCode::kIo, "interfaces cannot be watched: " + std::generic_category().message(errno));
    };
    OwnDescriptor socket(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_ROUTE));
    if (socket.get() < 0) return cannot();
    sockaddr_nl own{};
    own.nl_family = AF_NETLINK;
    own.nl_groups = RTMGRP_LINK | RTMGRP_IPV4_IFADDR;
    if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0) return cannot();
    return std::make_unique<NetlinkWatch>(std::move(socket), watch, std::move(changed));
  };
}

}  // namespace rubicon::transport
