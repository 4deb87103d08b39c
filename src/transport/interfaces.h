#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "rubicon/result.hpp"
#include "transport/descriptor_watch.h"

namespace rubicon::transport {

/// A network interface of this machine.
struct Interface {
  std::string name;     ///< `eth0`
  std::string address;  ///< IPv4, `192.168.1.5`; empty = none
  bool is_up = false;
  bool has_multicast = false;
  bool is_loopback = false;
  bool has_link = false;  ///< a cable, or a Wi-Fi that it has joined
  unsigned index = 0;     ///< of this appearance of the interface: one that was unplugged comes back with another one

  friend bool operator==(const Interface&, const Interface&) = default;
};

/// All interfaces with their first IPv4 addresses, in the system's order; empty if the system does not list them.
std::vector<Interface> interfaces();

/// The interfaces that are up, once for each of their IPv4 addresses.
std::vector<Interface> ipv4_interfaces();

/// The network interfaces of this machine while they are watched. Destroying it ends the calls.
class InterfaceWatch {
 public:
  virtual ~InterfaceWatch() = default;
  /// As transport::interfaces(), at this moment.
  virtual std::vector<Interface> interfaces() const = 0;
};

/// How a loop watches them: `changed` is called in a later turn when an interface, its link or an IPv4 address came,
/// went or changed; once for many changes, and now and then for nothing. It may destroy the watch. kIo: the system
/// does not tell.
using WatchInterfaces = std::function<Result<std::unique_ptr<InterfaceWatch>>(std::function<void()> changed)>;

/// By what the kernel multicasts on a routing socket (netlink(7), rtnetlink(7)), for which `watch` waits.
WatchInterfaces netlink_interfaces(WatchDescriptor watch);

}  // namespace rubicon::transport
