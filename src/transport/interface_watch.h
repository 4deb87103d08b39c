#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "rubicon/result.hpp"
#include "transport/descriptor_watch.h"
#include "transport/interfaces.h"

namespace rubicon::transport {

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
