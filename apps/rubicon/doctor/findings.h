#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/client.hpp"
#include "transport/interfaces.h"
#include "tuples/dds/dds_options.h"

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

/// The result of one check of `rubicon doctor`.
struct Finding {
  enum class Grade { kGood, kNote, kProblem };
  std::string check;  ///< its name, also in JSON
  Grade grade = Grade::kGood;
  std::string what;
  std::string fix{};  ///< what to do about it; member `mend` in JSON
};
std::string_view to_string(Finding::Grade grade);

using Findings = std::vector<Finding>;

// Pure functions of what was observed. Each returns findings of one check.

/// `no-multicast`: interfaces that do not exist, are down, or cannot discover others.
Findings check_interfaces(const client::Options& options, const std::vector<transport::Interface>& there);
/// `folder`: where the programs of this host meet, and which of them do not answer.
Findings check_folder(const client::HostView& view);
/// `participant-index`: no free index for one more process in the domain.
Finding check_places(std::uint32_t domain, unsigned processes);
/// `firewall`, of a peer.
Finding check_peer(const std::string& peer, std::uint32_t domain, const Probe& probe);
/// `version`: components that speak another version of the protocol.
Findings check_versions(const std::vector<client::ComponentStart>& seen, unsigned ours);
/// `clock`: whether the clock of this host was set, and those of components that are present were when they started.
Findings check_clocks(const std::vector<client::ComponentStart>& seen, WallTime now);
/// A warning that this program got during the check.
Finding check_complaint(const std::string& text);
/// `silent`: participants of the DDS domain that showed no component.
Findings check_silent_participants(std::size_t silent, unsigned domain);
/// `island-twice`: ids with several starts, present at the same time or one after the other.
Findings check_twins(const std::vector<client::ComponentStart>& seen);

}  // namespace rubicon::cli
