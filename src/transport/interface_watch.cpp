#include "transport/interface_watch.h"

#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "transport/own_descriptor.h"

namespace rubicon::transport {

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
