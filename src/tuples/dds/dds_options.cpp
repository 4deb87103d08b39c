#include "tuples/dds/dds_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace rubicon::tuples::dds {

namespace {

/// Components a host may have where they cannot find each other by multicast.
constexpr int kMostOnAHost = 120;

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

}  // namespace

bool is_loopback_only(const DdsOptions& options) {
  return std::all_of(options.interfaces.begin(), options.interfaces.end(),
                     [](const auto& name) { return name == "lo"; });
}

std::string domain_xml(const DdsOptions& options) {
  const bool alone = is_loopback_only(options);
  const bool multicast = !alone && options.peers.empty();
  std::string interfaces, peers;
  for (const auto& name : options.interfaces) {
    interfaces +=
        fmt::format("<NetworkInterface name=\"{}\"{}/>", escaped(name), multicast ? "" : " multicast=\"false\"");
  }
  if (alone) peers += "<Peer address=\"127.0.0.1\"/>";
  for (const auto& address : options.peers) peers += fmt::format("<Peer address=\"{}\"/>", escaped(address));
  const auto tag = options.tag.empty() ? std::string() : fmt::format("<Tag>{}</Tag>", escaped(options.tag));
  const auto lease = std::chrono::duration_cast<std::chrono::milliseconds>(options.lease).count();
  return fmt::format(
      "<CycloneDDS xmlns=\"https://cdds.io/config\"><Domain Id=\"any\">"
      "<General><Interfaces>{}</Interfaces><AllowMulticast>{}</AllowMulticast></General>"
      "<Discovery>{}<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>{}</MaxAutoParticipantIndex>"
      "<Peers>{}</Peers><LeaseDuration>{} ms</LeaseDuration></Discovery>"
      "</Domain></CycloneDDS>",
      interfaces, multicast ? "default" : "false", tag, kMostOnAHost, peers, lease);
}

}  // namespace rubicon::tuples::dds
