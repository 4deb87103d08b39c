#pragma once

#include <string>
#include <vector>

#include "networks/knx/wire/message.h"
#include "transport/udp.h"

namespace rubicon::networks::knx::line {

/// A KNXnet/IP server as its answers to searches and to requests for its description tell it.
struct FoundServer {
  transport::Endpoint control;  ///< where to reach it; what names it
  wire::ServerDescription description;
  bool extended = false;  ///< it answered an extended search: a server of Core version 2

  std::size_t free_slots() const;
  friend bool operator==(const FoundServer&, const FoundServer&) = default;
};

/// Adds what another answer of the same server tells. What an answer leaves out stays as it was: knxd names family 03
/// in its description only, and a serial number in its search answer only (knx.md, 5.2).
void merge(wire::ServerDescription& into, const wire::ServerDescription& more);

/// Answers of any number of servers, one entry per control endpoint, in the order they came.
class FoundServers {
 public:
  /// A network of the size that KNX allows has less routers; what else answers is not worth the memory.
  static constexpr std::size_t kMost = 1024;

  /// False if it was one too many.
  bool add(const transport::Endpoint& control, const wire::ServerDescription& description, bool extended);
  const std::vector<FoundServer>& all() const { return servers_; }

 private:
  std::vector<FoundServer> servers_;
};

/// `TP1`, `IP`, `medium 40`, `unknown medium`.
std::string medium_name(std::uint8_t medium);

/// Some lines for people, without an end of line at the end.
std::string describe(const FoundServer& server);

}  // namespace rubicon::networks::knx::line
