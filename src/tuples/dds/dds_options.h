#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rubicon/time.hpp"

namespace rubicon::tuples::dds {

enum class DdsTransport : std::uint8_t { kUdp, kTcp };

/// How components find and reach each other.
struct DdsOptions {
  std::uint32_t domain = 0;                        ///< 0..230: who has another one is not there
  std::vector<std::string> interfaces = {"lo"};    ///< names, at most kMostInterfaces; `lo` alone = this host only
  std::vector<std::string> peers;                  ///< host or host:port, where multicast does not reach them
  std::string tag;                                 ///< who has another one is not there, in the same domain too
  base::Duration lease = std::chrono::seconds(2);  ///< silence after which others lose us
  DdsTransport transport = DdsTransport::kUdp;
  std::uint16_t port = 0;  ///< of TCP: where this process listens; 0 = anywhere, others cannot call it first
  bool trust_lan = false;  ///< remote sets of other hosts are taken

  friend bool operator==(const DdsOptions&, const DdsOptions&) = default;
};

inline constexpr std::size_t kMostInterfaces = 4;  ///< of Cyclone
/// Processes of one host in one domain: the ports of more would be those of the next domain (DDSI-RTPS 2.5, 9.6.2.3).
inline constexpr unsigned kMostOnAHost = 120;
/// How many processes of a host in `peers` are looked for where it names no port; they find the others.
inline constexpr unsigned kSoughtOnAPeer = 8;

/// The first of the two UDP ports of the n-th process of a host (from 0), as above.
unsigned port_of(std::uint32_t domain, unsigned process);

/// Nothing leaves this host.
bool is_loopback_only(const DdsOptions& options);

/// Cyclone's own configuration of the domain (https://cdds.io/config), made for this host as it is now. Peers whose
/// names are not resolved yet are left out.
std::string domain_xml(const DdsOptions& options);

}  // namespace rubicon::tuples::dds
