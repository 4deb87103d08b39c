#include "tuples/dds/dds_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "tuples/dds/host.h"

namespace rubicon::tuples::dds {

namespace {

/// Between announcements to those who are not there (yet, or any more): how soon a mended cable is noticed.
constexpr int kAnnounceMs = 2000;
/// A TCP connection that takes nothing holds up everybody for this long, then it is closed.
constexpr int kTcpPatienceMs = 500;

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

/// Of a host that names no port the first processes are looked for.
std::string peer_elements(const DdsOptions& options) {
  std::string out;
  for (const auto& host : options.peers) {
    if (host.find(':') != host.npos) {
      out += peer(host);
      continue;
    }
    for (unsigned i = 0; i < kSoughtOnAPeer; ++i) {
      out += peer(fmt::format("{}:{}", host, port_of(options.domain, i)));
    }
  }
  return out;
}

/// Where multicast does not bring together the processes of this host either.
std::string own_addresses(const DdsOptions& options) {
  std::string out;
  for (const auto& one : interfaces()) {
    const bool used = std::count(options.interfaces.begin(), options.interfaces.end(), one.name) > 0;
    if (used && !one.address.empty()) out += peer(one.address);
  }
  return out;
}

/// Sockets of DDS hear all interfaces: without it a sender elsewhere could speak to those who use loopback only.
std::string tag_of(const DdsOptions& options) {
  if (!is_loopback_only(options)) return options.tag;
  return fmt::format("{}@{}", options.tag, host_id("tag"));
}

std::string discovery(const DdsOptions& options, bool multicast) {
  const bool tcp = options.transport == DdsTransport::kTcp;
  const auto tag = tag_of(options);
  const auto lease = std::chrono::duration_cast<std::chrono::milliseconds>(options.lease).count();
  return fmt::format(
      "<Discovery>{}{}<Peers>{}{}</Peers><LeaseDuration>{} ms</LeaseDuration><SPDPInterval>{} ms</SPDPInterval>"
      "</Discovery>",
      tag.empty() ? std::string() : fmt::format("<Tag>{}</Tag>", escaped(tag)),
      tcp ? std::string("<ParticipantIndex>none</ParticipantIndex>")
          : fmt::format(
                "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>{}</MaxAutoParticipantIndex>",
                kMostOnAHost),
      multicast || tcp ? std::string() : own_addresses(options), peer_elements(options), lease, kAnnounceMs);
}

}  // namespace

bool is_loopback_only(const DdsOptions& options) {
  return std::all_of(options.interfaces.begin(), options.interfaces.end(),
                     [](const auto& name) { return name == "lo"; });
}

unsigned port_of(std::uint32_t domain, unsigned process) {
  return 7410 + 250 * domain + 2 * process;
}

std::string domain_xml(const DdsOptions& options) {
  const bool tcp = options.transport == DdsTransport::kTcp;
  const bool multicast = !is_loopback_only(options) && options.peers.empty() && !tcp;
  std::string names;
  for (const auto& name : options.interfaces) {
    names += fmt::format("<NetworkInterface name=\"{}\"{}/>", escaped(name), multicast ? "" : " multicast=\"false\"");
  }
  const auto transport =
      tcp ? fmt::format("<TCP><Port>{}</Port><WriteTimeout>{} ms</WriteTimeout></TCP>", options.port, kTcpPatienceMs)
          : std::string();
  return fmt::format(
      "<CycloneDDS xmlns=\"https://cdds.io/config\"><Domain Id=\"any\">"
      "<General><Interfaces>{}</Interfaces><AllowMulticast>{}</AllowMulticast>{}</General>{}{}</Domain></CycloneDDS>",
      names, multicast ? "default" : "false", tcp ? "<Transport>tcp</Transport>" : "", transport,
      discovery(options, multicast));
}

}  // namespace rubicon::tuples::dds
