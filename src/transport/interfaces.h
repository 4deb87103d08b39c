#pragma once

#include <string>
#include <vector>

namespace rubicon::transport {

/// An IPv4 address of this machine and the interface that has it.
struct Interface {
  std::string name;     ///< `eth0`
  std::string address;  ///< `192.168.1.5`
  bool loopback = false;
  bool multicast = false;

  friend bool operator==(const Interface&, const Interface&) = default;
};

/// Of the interfaces that are up, in the system's order; empty if the system does not say.
std::vector<Interface> ipv4_interfaces();

}  // namespace rubicon::transport
