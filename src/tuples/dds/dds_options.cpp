#include "tuples/dds/dds_options.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <string_view>

#include "transport/host_names.h"
#include "transport/interfaces.h"

namespace rubicon::tuples::dds {

namespace {

/// Interval of announcements to peers that are not present: a repaired connection is noticed after this.
constexpr int kAnnounceMs = 2000;
/// A TCP connection that accepts no data blocks all others for this long, then it is closed.
constexpr int kTcpWriteTimeoutMs = 500;

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += c;
    }
  }
  return out;
}

std::string peer(std::string_view address) {
  return fmt::format("<Peer address=\"{}\"/>", escaped(address));
}

/// The processes to search on a host without a port.
std::string first_of(const std::string& host, std::uint32_t domain) {
  std::string out;
  for (unsigned i = 0; i < kProcessesSearchedOnPeer; ++i) out += peer(fmt::format("{}:{}", host, port_of(domain, i)));
  return out;
}

/// All processes of this host, by the addresses of the interfaces in use.
std::string own_addresses(const DdsOptions& options) {
  std::string out;
  for (const auto& one : transport::interfaces()) {
    const bool used = std::count(options.interfaces.begin(), options.interfaces.end(), one.name) > 0;
    if (used && !one.address.empty()) out += peer(one.address);
  }
  return out;
}

std::string peer_elements(const DdsOptions& options) {
  // Multicast on loopback finds all processes; where it does not work, the first ones of the host find each other.
  if (is_loopback_only(options) && options.transport == DdsTransport::kUdp)
    return first_of("127.0.0.1", options.domain);
  std::string out;
  if (!options.peers.empty() && options.transport == DdsTransport::kUdp) out += own_addresses(options);
  for (const auto& host : options.peers) {
    if (has_address(host)) out += host.find(':') == host.npos ? first_of(host, options.domain) : peer(host);
  }
  return out;
}

/// Value of AllowMulticast. On loopback multicast serves discovery only.
const char* multicast(const DdsOptions& options) {
  if (options.transport == DdsTransport::kTcp || !options.peers.empty()) return "false";
  return is_loopback_only(options) ? "spdp" : "true";
}

/// Cyclone's sockets receive on all interfaces. On loopback a secret part of the tag keeps out senders on other hosts.
std::string tag_of(const DdsOptions& options) {
  if (!is_loopback_only(options)) return options.tag;
  return fmt::format("{}@{}", options.tag, transport::host_id("tag"));
}

/// After which a writer asks who has not acknowledged; the default of Cyclone is kMinInterval. On loopback, 80
/// components on two processors asked so often that they never saw each other: a long lease spaces the questions. These
/// also mend losses, so a second is the most; on a LAN, where losses are common, the default stays.
Duration heartbeat_interval(const DdsOptions& options) {
  constexpr Duration kMinInterval = std::chrono::milliseconds(100), kMaxInterval = std::chrono::seconds(1);
  return is_loopback_only(options) ? std::clamp<Duration>(options.lease / 20, kMinInterval, kMaxInterval)
                                   : kMinInterval;
}

/// The longest frame is that of a value of 1 MiB. Cyclone's own bound is 2 GiB, for strangers too: it collects the
/// fragments of a sample before anybody is asked who sent them. A packet that waits for an earlier one keeps its whole
/// receive buffer, 1 MiB as Cyclone has it: one in a thousand is enough to keep all that arrives. A buffer has room for
/// the longest datagram. The deletion of a writer would wait a second for receivers that are cut off;
/// DdsLink::leave() waits for all of them together. With several threads that receive, the end of a domain wakes each
/// by a datagram to the own address: where that is gone, they do not end (0.10.2). That of loopback stays, and there a
/// single thread costs up to 20 us a message.
std::string internal(const DdsOptions& options) {
  return fmt::format(
      "<Internal><MaxSampleSize>4 MiB</MaxSampleSize><WriterLingerDuration>0 s</WriterLingerDuration>"
      "<HeartbeatInterval>{} ms</HeartbeatInterval>{}</Internal>"
      "<Sizing><ReceiveBufferSize>66 KiB</ReceiveBufferSize><ReceiveBufferChunkSize>66 "
      "KiB</ReceiveBufferChunkSize></Sizing>",
      std::chrono::duration_cast<std::chrono::milliseconds>(heartbeat_interval(options)).count(),
      is_loopback_only(options) ? "" : "<MultipleReceiveThreads>false</MultipleReceiveThreads>");
}

std::string discovery(const DdsOptions& options) {
  const auto tag = tag_of(options);
  const auto lease = std::chrono::duration_cast<std::chrono::milliseconds>(options.lease).count();
  const auto index =
      options.transport == DdsTransport::kTcp
          ? std::string("<ParticipantIndex>none</ParticipantIndex>")
          : fmt::format(
                "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>{}</MaxAutoParticipantIndex>",
                kMaxProcessesPerHost);
  return fmt::format(
      "<Discovery><ExternalDomainId>{}</ExternalDomainId>{}{}<Peers>{}</Peers><LeaseDuration>{} "
      "ms</LeaseDuration><SPDPInterval>{} "
      "ms</SPDPInterval></Discovery>",
      options.domain, tag.empty() ? std::string() : fmt::format("<Tag>{}</Tag>", escaped(tag)), index,
      peer_elements(options), lease, kAnnounceMs);
}

std::string names_of(const std::vector<transport::Interface>& all) {
  std::vector<std::string_view> names;
  for (const auto& one : all) names.push_back(one.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

Result<void> check_one(const transport::Interface& one, bool needs_multicast) {
  if (!one.is_up) {
    return fail(ErrorCode::kIo, fmt::format("DDS: interface '{0}' is down: bring it up (ip link set {0} up){1}",
                                            one.name, one.name == "lo" ? ", or set tuples.engine: memory" : ""));
  }
  if (one.address.empty())
    return fail(ErrorCode::kIo, fmt::format("DDS: interface '{}' has no IPv4 address", one.name));
  if (needs_multicast && !one.has_multicast) {
    return fail(ErrorCode::kIo,
                fmt::format("DDS: interface '{}' has no multicast: name the other hosts in tuples.peers", one.name));
  }
  return {};
}

}  // namespace

bool is_loopback_only(const DdsOptions& options) {
  return std::all_of(options.interfaces.begin(), options.interfaces.end(),
                     [](const auto& name) { return name == "lo"; });
}

std::string domain_xml(const DdsOptions& options) {
  const std::string_view allowed = multicast(options);
  std::string names;
  for (const auto& name : options.interfaces) {
    names += fmt::format("<NetworkInterface name=\"{}\" multicast=\"{}\"/>", escaped(name),
                         allowed == "false" ? "false" : "true");
  }
  std::string transport, tcp;
  if (options.transport == DdsTransport::kTcp) {
    transport = "<Transport>tcp</Transport>";
    tcp = fmt::format("<TCP><Port>{}</Port><WriteTimeout>{} ms</WriteTimeout></TCP>", options.port, kTcpWriteTimeoutMs);
  }
  return fmt::format(
      "<CycloneDDS xmlns=\"https://cdds.io/config\"><Domain Id=\"any\">"
      "<General><Interfaces>{}</Interfaces><AllowMulticast>{}</AllowMulticast>{}</General>{}{}{}</Domain></"
      "CycloneDDS>",
      names, allowed, transport, tcp, internal(options), discovery(options));
}

Result<void> check_interfaces(const DdsOptions& options, const std::vector<transport::Interface>& present) {
  const bool needs_multicast =
      !is_loopback_only(options) && options.peers.empty() && options.transport == DdsTransport::kUdp;
  for (const auto& name : options.interfaces) {
    const auto found = std::find_if(present.begin(), present.end(), [&](const auto& one) { return one.name == name; });
    if (found == present.end()) {
      return fail(ErrorCode::kIo,
                  fmt::format("DDS: there is no interface '{}' on this host; there are: {}", name, names_of(present)));
    }
    if (auto good = check_one(*found, needs_multicast); !good) return good;
  }
  return {};
}

bool has_address(const std::string& peer) {
  in_addr address{};
  return ::inet_pton(AF_INET, peer.substr(0, peer.find(':')).c_str(), &address) == 1;
}

std::vector<std::string> with_addresses(std::vector<std::string> peers, Scheduler& scheduler, Duration timeout,
                                        std::vector<std::string>& unknown) {
  const auto end = scheduler.now() + timeout;
  for (auto& peer : peers) {
    if (has_address(peer)) continue;
    const auto colon = std::min(peer.find(':'), peer.size());
    Result<std::vector<std::string>> found = fail(ErrorCode::kExpired, "no time left");
    if (scheduler.now() < end) found = transport::resolve(peer.substr(0, colon), transport::AddressFamily::kIpv4);
    if (found) {
      peer.replace(0, colon, found->front());
    } else {
      unknown.push_back(peer);
    }
  }
  return peers;
}

}  // namespace rubicon::tuples::dds
