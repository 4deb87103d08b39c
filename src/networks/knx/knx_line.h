#pragma once

#include <memory>

#include "networks/knx/line/routing_line.h"
#include "networks/knx/line/tunnel_line.h"

namespace rubicon::networks::knx {

enum class Via : std::uint8_t { kTunnel, kTunnelTcp, kRouting };

/// The way to the bus that the configuration names; only the part that `via` means counts.
struct LineOptions {
  Via via = Via::kTunnel;
  line::TunnelOptions tunnel;
  line::RoutingOptions routing;
};

/// Whether a line with the one is as good as one with the other.
bool same_line(const LineOptions& one, const LineOptions& other);

std::unique_ptr<line::Line> make_line(const LineOptions& options, Scheduler& scheduler,
                                      transport::Transports& transports, line::LineCallbacks calls);

}  // namespace rubicon::networks::knx
