#pragma once

#include <memory>

#include "networks/knx/line/gateway_line.h"
#include "networks/knx/line/routing_line.h"
#include "networks/knx/line/tunnel_line.h"

namespace rubicon::networks::knx {

enum class Via : std::uint8_t { kTunnel, kTunnelTcp, kRouting };

/// The configured connection to the bus. `via` selects which of the two parts is used.
struct LineOptions {
  Via via = Via::kTunnel;
  line::TunnelOptions tunnel;
  line::RoutingOptions routing;
  std::vector<std::string> hosts{};       ///< of tunnels, if there are several; the first is that of `tunnel`
  std::vector<line::Gateway> gateways{};  ///< the tunnels of these hosts with their keys; empty = one for each host
  std::optional<Duration> gateway_check = std::chrono::minutes(5);  ///< of GatewayOptions
  bool multicast_given = false;                                     ///< the options name the group of routing
};

/// True if a line that was made with one of them need not be replaced for the other.
bool same_line(const LineOptions& one, const LineOptions& other);

std::unique_ptr<line::Line> make_line(const LineOptions& options, Scheduler& scheduler,
                                      transport::Transports& transports, line::LineCallbacks calls);

}  // namespace rubicon::networks::knx
