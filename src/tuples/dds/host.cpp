#include "tuples/dds/host.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "transport/resolve.h"

namespace rubicon::tuples::dds {

namespace {

std::string names_of(const std::vector<transport::Interface>& all) {
  std::vector<std::string_view> names;
  for (const auto& one : all) names.push_back(one.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

Result<void> check(const transport::Interface& one, bool needs_multicast) {
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

Result<void> check_interfaces(const DdsOptions& options, const std::vector<transport::Interface>& present) {
  const bool needs_multicast =
      !is_loopback_only(options) && options.peers.empty() && options.transport == DdsTransport::kUdp;
  for (const auto& name : options.interfaces) {
    const auto found = std::find_if(present.begin(), present.end(), [&](const auto& one) { return one.name == name; });
    if (found == present.end()) {
      return fail(ErrorCode::kIo,
                  fmt::format("DDS: there is no interface '{}' on this host; there are: {}", name, names_of(present)));
    }
    if (auto good = check(*found, needs_multicast); !good) return good;
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
