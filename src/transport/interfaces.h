#pragma once

#include <string>
#include <vector>

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

}  // namespace rubicon::transport
