#pragma once

#include <memory>
#include <string>

#include "networks/knx/line/discovery.h"
#include "networks/knx/line/line.h"
#include "networks/knx/line/routing.h"
#include "transport/transports.h"

namespace rubicon::networks::knx::line {

struct RoutingOptions {
  transport::Endpoint group{std::string(kKnxGroup), kKnxPort};  ///< 224.0.23.12 or higher
  std::string interface_address{};  ///< IPv4; empty = the system's choice, own frames are then known by their bytes
  std::uint8_t ttl = 16;            ///< as ETS projects have it
  wire::IndividualAddress address{0xfffa};  ///< own: 15.15.250; unique on the backbone
  Outbox::Limits limits{0, 1, 10000};       ///< beside the 50 a second of routing; default: none
  std::uint64_t seed = 0;                   ///< another one per process: of the pauses after ROUTING_BUSY
};

/// What a routing line tells beyond LineCalls; each may be empty.
struct RoutingCalls {
  /// A router lost telegrams on its way to or from the bus.
  std::function<void(const transport::Endpoint& from, const wire::RoutingLostMessage&)> lost{};
  /// A search or its answer was heard (for Discovery::heard).
  std::function<void(const transport::Endpoint& from, ByteView frame)> discovery{};
};

/// Telegrams over the routers' group: each is sent when it left; nobody confirms it.
class RoutingLine final : public Line {
 public:
  /// Who heard nobody for so long joins the groups once more: switches forget members where no router asks for them
  /// (IGMP snooping), and interfaces come and go.
  static constexpr Duration kSilence = std::chrono::seconds(60);

  /// Scheduler and transports must outlive it.
  RoutingLine(Scheduler& scheduler, transport::Transports& transports, RoutingOptions options, LineCalls calls,
              RoutingCalls more = {});
  ~RoutingLine() override;
  RoutingLine(const RoutingLine&) = delete;
  RoutingLine& operator=(const RoutingLine&) = delete;

  Result<void> open() override;
  void send(wire::Telegram telegram, SteadyTime expires, SentCall done) override;
  const LineState& state() const override { return state_; }
  std::map<std::string, std::uint64_t> counters() const override;

 private:
  using Sockets = std::vector<std::unique_ptr<transport::UdpSocket>>;

  void tell_lost(const Error& why);
  Result<void> join(const transport::Endpoint& group, Routing::Group role);
  Result<void> join_all();
  Result<void> open_sender();
  void heard(const transport::Endpoint& from, ByteView datagram, Routing::Group role);
  void join_again();
  void close();
  Routing::Calls machine_calls();
  void lost(Error why);
  void tell();

  Scheduler& scheduler_;
  transport::Transports& transports_;
  RoutingOptions options_;
  LineCalls calls_;
  RoutingCalls more_;
  Sockets sockets_;                               ///< that hear
  std::unique_ptr<transport::UdpSocket> sender_;  ///< with a port of its own
  LineState state_;
  Timer up_, closing_;
  base::Deadline silence_;
  std::uint64_t joined_again_ = 0;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
  Routing machine_;
};

}  // namespace rubicon::networks::knx::line
