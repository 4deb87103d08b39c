#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace rubicon::cli {

/// Processes of this host that take part in DDS domains, by the pairs of UDP ports that are theirs (DDSI-RTPS 2.5,
/// 9.6.2.3).
std::map<unsigned, unsigned> processes_by_domain(const std::set<unsigned>& ports);
/// Of /proc/net/udp: the ports that are bound.
std::set<unsigned> ports_in(std::string_view table);
std::set<unsigned> bound_ports();

/// A datagram from this address to itself arrives.
bool passes_udp(const std::string& address);

/// What became of datagrams to the ports of a peer.
struct Probe {
  std::string error;  ///< the system's word why nothing can be sent; empty = it can
  unsigned refused = 0, silent = 0;
  bool closed_port_refused = false;  ///< one that nobody has: the host answers
};
/// `host` or `host:port`. Takes some 0.7 s; the name is asked for in the usual way of the system.
Probe probe_peer(const std::string& peer, unsigned domain);

/// Domains in which somebody announces itself by multicast on this interface, this one left out.
std::set<unsigned> domains_heard(const std::string& address, unsigned except, std::chrono::milliseconds patience);

}  // namespace rubicon::cli
