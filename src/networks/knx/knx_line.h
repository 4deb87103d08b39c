#pragma once

#include <memory>
#include <string>
#include <vector>

#include "networks/knx/line/gateway_line.h"
#include "networks/knx/line/routing_line.h"
#include "networks/knx/line/tunnel_line.h"
#include "networks/knx/wire/address.h"

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

/// Which tunnels of a keyring were tried in vain. In each round all are tried but those whose user the interface
/// refused. Such a tunnel is skipped until the users of all tunnels are refused, or a user reopens the line.
class TunnelRound {
 public:
  std::vector<wire::IndividualAddress> unusable() const;
  void in_use(wire::IndividualAddress tunnel) { taken_.push_back(tunnel); }
  void user_refused(wire::IndividualAddress tunnel) { users_refused_.push_back(tunnel); }

  /// All tunnels were tried; `why` names them. The pause that follows depends on the tunnel that was tried last. True:
  /// try another tunnel at once, because the pause after a refused user is longer than the one for tunnels in use.
  bool end(bool last_was_refused, const Error& why);
  void up();
  void reopen() { users_refused_.clear(); }

  /// After a round without a free one: why; else empty.
  const std::string& text() const { return text_; }
  /// For it, as Error has it.
  std::string_view finding() const { return finding_; }

 private:
  std::vector<wire::IndividualAddress> taken_;  ///< in this round
  std::vector<wire::IndividualAddress> users_refused_;
  std::string text_;
  std::string_view finding_;
};

}  // namespace rubicon::networks::knx
