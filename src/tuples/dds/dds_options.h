#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "transport/interfaces.h"
#include "tuples/judge.h"

namespace rubicon::tuples::dds {

enum class DdsTransport : std::uint8_t { kUdp, kTcp };

/// How components find and reach each other.
struct DdsOptions {
  std::uint32_t domain = 0;                        ///< 0..kMaxDomain: components of other domains are not seen
  std::vector<std::string> interfaces = {"lo"};    ///< names, at most kMaxInterfaces; `lo` alone = this host only
  std::vector<std::string> peers;                  ///< HOST or HOST:PORT of hosts that multicast does not reach
  std::string tag;                                 ///< components of the domain with another tag are not seen
  base::Duration lease = std::chrono::seconds(2);  ///< others lose this component after such a silence
  DdsTransport transport = DdsTransport::kUdp;
  std::uint16_t port = 0;                  ///< TCP port to listen on; 0 = any, so that only this process can connect
  bool trust_lan = false;                  ///< accept remote sets from other hosts; without judge only
  std::shared_ptr<Judge> judge = nullptr;  ///< what the member `lan` may do here; null: read, and trust_lan decides

  friend bool operator==(const DdsOptions&, const DdsOptions&) = default;
};

inline constexpr std::size_t kMaxInterfaces = 4;  ///< limit of Cyclone DDS
inline constexpr std::uint32_t kMaxDomain = 230;  ///< higher domains would have ports above 65535
/// Processes of one host in one domain; more would use the ports of the next domain.
inline constexpr unsigned kMaxProcessesPerHost = 120;
/// A peer without a port is searched for this many processes; they find the others.
inline constexpr unsigned kProcessesSearchedOnPeer = 8;

/// UDP port to which the participants of a domain announce themselves by multicast (DDSI-RTPS 2.5, 9.6.2.3).
constexpr unsigned multicast_port_of(std::uint32_t domain) {
  return 7400 + 250 * domain;
}
/// The first of the two UDP ports of the n-th process of a host, n from 0 (as above).
constexpr unsigned port_of(std::uint32_t domain, unsigned process) {
  return multicast_port_of(domain) + 10 + 2 * process;
}
/// The domain whose process has this port as its first one; nullopt if no process has.
constexpr std::optional<std::uint32_t> domain_of_port(unsigned port) {
  if (port < port_of(0, 0)) return std::nullopt;
  const auto domain = (port - multicast_port_of(0)) / 250;
  if (domain > kMaxDomain || port < port_of(domain, 0) || (port - port_of(domain, 0)) % 2 != 0) return std::nullopt;
  return domain;
}

/// Whether all traffic stays on this host.
bool is_loopback_only(const DdsOptions& options);

/// The configuration of the domain for Cyclone DDS (https://cdds.io/config), with the present interfaces of this host.
/// Peers whose names are not resolved are left out.
std::string domain_xml(const DdsOptions& options);

/// kIo if one of options.interfaces does not exist, is down, has no address, or has no multicast where it is needed.
/// The text says what to do.
Result<void> check_interfaces(const DdsOptions& options, const std::vector<transport::Interface>& present);

/// Replaces host names (also before `:port`) by their first IPv4 addresses. Names that cannot be resolved stay and are
/// added to `unknown`. Blocks for the system's resolver; names left after the timeout count as unknown.
std::vector<std::string> with_addresses(std::vector<std::string> peers, Scheduler& scheduler, Duration timeout,
                                        std::vector<std::string>& unknown);
/// Whether the host of `peer` is a numeric IPv4 address.
bool has_address(const std::string& peer);

}  // namespace rubicon::tuples::dds
