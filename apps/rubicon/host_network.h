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

/// Whether a datagram from this address to itself arrives.
bool passes_udp(const std::string& address);

/// The result of sending datagrams to the ports of a peer.
struct Probe {
  std::string error;  ///< the system's text why nothing can be sent; empty = sent
  unsigned refused = 0, silent = 0;
  bool closed_port_refused = false;  ///< an unused port refused: the host answers
};
/// `host` or `host:port`. Takes about 0.7 s; blocks while the system resolves the name.
Probe probe_peer(const std::string& peer, unsigned domain);

/// Domains other than `except` whose components announce themselves by multicast on this interface.
std::set<unsigned> domains_heard(const std::string& address, unsigned except, std::chrono::milliseconds patience);

}  // namespace rubicon::cli
