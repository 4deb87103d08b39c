#pragma once

#include <memory>
#include <string>

#include "base/scheduler.h"
#include "networks/knx/line/discovery.h"
#include "networks/knx/line/line.h"
#include "networks/knx/line/routing.h"
#include "networks/knx/secure/routing_guard.h"
#include "transport/transports.h"

namespace rubicon::networks::knx::line {

struct RoutingOptions {
  transport::Endpoint group{std::string(kKnxGroup), kKnxPort};  ///< 224.0.23.12 or higher
  std::string
      interface_address{};  ///< IPv4; empty = the system's choice; own frames are then recognised by their bytes
  std::uint8_t ttl = 16;    ///< the default of ETS projects
  wire::IndividualAddress address{0xfffa};    ///< own: 15.15.250; unique on the backbone
  TelegramQueue::Limits limits{0, 1, 10000};  ///< in addition to the 50 per second of routing; default: none
  secure::GroupGuard* guard = nullptr;        ///< of secured groups; must outlive the line
  std::uint64_t seed = 0;                     ///< different in each process: for the pauses after ROUTING_BUSY
  /// KNX IP Secure: nothing is sent or taken in plain but searches. nullopt = plain.
  std::optional<secure::RoutingKeys> secure{};
  secure::GroupStorage storage{};  ///< keeps the timer of the secure group
  secure::Random random = secure::system_random();
};

/// What a routing line reports in addition to LineCallbacks; each may be empty.
struct RoutingCallbacks {
  /// A router lost telegrams on its way to or from the bus.
  std::function<void(const transport::Endpoint& from, const wire::RoutingLostMessage&)> lost{};
  /// A search or its answer was received (for Discovery::receive).
  std::function<void(const transport::Endpoint& from, ByteView frame)> discovery{};
};

/// KNXnet/IP routing: telegrams over the multicast group of the routers, without confirmations. A secure line is
/// connecting until it has the timer of its group, some seconds.
class RoutingLine final : public Line {
 public:
  /// After this long without traffic the line rejoins its groups: switches without an IGMP querier forget members (IGMP
  /// snooping), and interfaces appear and disappear.
  static constexpr Duration kSilence = std::chrono::seconds(60);

  /// Scheduler and transports must outlive it.
  RoutingLine(Scheduler& scheduler, transport::Transports& transports, RoutingOptions options, LineCallbacks callbacks,
              RoutingCallbacks routing_callbacks = {});
  RoutingLine(const RoutingLine&) = delete;
  RoutingLine& operator=(const RoutingLine&) = delete;

  Result<void> open() override;
  void send(wire::Telegram telegram, SteadyTime expires, SendCallback done) override;
  const LineState& state() const override { return state_; }
  std::map<std::string, std::uint64_t> counters() const override;

 private:
  using Sockets = std::vector<std::unique_ptr<transport::UdpSocket>>;

  void report_lost(const Error& why);
  Result<void> join(const transport::Endpoint& group, Routing::Group role);
  Result<void> join_all();
  Result<void> open_sender();
  void receive(const transport::Endpoint& from, ByteView datagram, Routing::Group role);
  void rejoin();
  void close();
  Result<void> make_guard();
  Result<void> transmit(ByteView frame);
  void sockets_open();
  void become_up();
  Routing::Callbacks routing_calls();
  void lost(Error why);
  void report_state();

  Scheduler& scheduler_;
  transport::Transports& transports_;
  RoutingOptions options_;
  LineCallbacks callbacks_;
  RoutingCallbacks routing_callbacks_;
  Sockets sockets_;                               ///< receive from the groups
  std::unique_ptr<transport::UdpSocket> sender_;  ///< has a port of its own
  LineState state_;
  Timer report_up_, close_later_;
  base::Deadline silence_;
  std::uint64_t rejoined_ = 0;
  std::unique_ptr<secure::RoutingGuard> guard_;  ///< of a secure line, from the first open() on
  std::string shown_problem_;
  Routing routing_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::knx::line
