#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "tuples/peis/connection.h"
#include "tuples/peis/peis_world.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

/// A component that behaves as kernels of G6 do in the captures: what it sends when a connection begins, when it sends
/// routing, acks and resends, its metric, no split horizon, and what it does not notice.
class KernelPeer {
 public:
  struct Received {
    SteadyTime at{};
    PackageHeader header;
    std::string body;
  };

  KernelPeer(PeisWorld& world, std::uint32_t id, std::uint16_t port)
      : KernelPeer(world.time, world.machine, id, port) {}
  /// With these sockets, which may be those of the machine.
  KernelPeer(Scheduler& scheduler, transport::Transports& transports, std::uint32_t id, std::uint16_t port);
  ~KernelPeer();

  std::uint32_t magic;
  std::string host_name = "hostx";
  std::string network = "default";
  double loss = 0;      ///< probability that a package is lost, in each direction
  int lost_deaths = 0;  ///< DEAD_HOST packages that get lost on their way here
  bool acknowledges = true;
  std::size_t each_step = 0;  ///< packages of a connection that a step of 10 ms takes, 9 as shipped; 0 = all at once
  bool sends_routing = true;
  bool connects = true;        ///< to announced hosts of other clusters
  bool notices_fin = true;     ///< kernels do not (section 6.4, 24); they also answer nothing then
  bool resets_reborn = false;  ///< closes the first connection of another start (section 6.4, 26)
  bool resets_always = false;  ///< closes each connection when the host record comes
  std::uint32_t version = kProtocolVersion;

  void listen();
  void stop_listening() { listener_.reset(); }
  void hold(bool held);  ///< reads nothing from its present connections, as when a stream is locked up
  void send_datagram(ByteView datagram);
  void announce();  ///< each second from now on
  void connect(std::uint16_t port, std::uint32_t flags = kForcedByCluster);
  void close();  ///< all connections, in order
  void leave();  ///< DEAD_HOST, and close
  std::size_t links() const { return links_.size(); }

  /// Sends with ack and resends, as kernels do.
  void send(std::uint32_t to, Port port, const std::string& body);
  /// Sends a package as it is on all connections.
  void send_raw(PackageHeader header, ByteView body);
  void send_bytes(ByteView bytes);
  PackageHeader header(Routing routing, Port port, std::uint32_t to = kAnyId);
  bool routable(std::uint32_t id) const { return routes_.contains(OwnerId{id}); }
  HostRecord record() const;

  std::vector<Received> received;                   ///< all packages, lost ones apart
  std::vector<Received> messages;                   ///< to it, for the first time, not of the node level
  std::function<void(const Received&)> on_message;  ///< for each of them
  std::vector<ConnectMessage> greetings;            ///< connect messages that came
  std::set<std::uint32_t> given_up;                 ///< destinations
  std::vector<std::string> texts() const;
  std::vector<Received> of(Port port) const;

 private:
  struct Link {
    std::unique_ptr<transport::TcpStream> stream;
    PackageStream packages;
    bool accepted = false, greeted = false;
    OwnerId peer{};
    std::uint32_t counter = 0;
    int failures = 0;  ///< sends that failed: at the second it closes
  };
  struct Known {
    std::uint64_t link = 0;
    int hops = 0;
    std::uint32_t sequence = 0, magic = 0;
  };
  struct Unacknowledged {
    PackageHeader header;
    Bytes body;
    int resends = 0;
    SteadyTime due{};
  };

  transport::TcpCallbacks calls(std::uint64_t id);
  void begin(std::uint64_t id);
  void arrived(std::uint64_t id, ByteView bytes);
  void take_packages(std::uint64_t id, std::size_t most);
  void take(std::uint64_t id, const Package& package);
  void take_routing(std::uint64_t id, const RoutingPage& page);
  void write(Link& link, PackageHeader header, ByteView body);
  void route(const PackageHeader& header, ByteView body);
  void answer_for(OwnerId host, const QueryHost& query);
  RoutingPage routing_page() const;
  void send_routing();
  void tick();
  OwnerId cluster() const;
  std::uint32_t random_id() { return static_cast<std::uint32_t>(random_() % kMaxId) + 1; }
  bool loses() { return loss > 0 && static_cast<double>(random_() % 10000) < loss * 10000; }

  Scheduler& scheduler_;
  transport::Transports& transports_;
  OwnerId id_;
  std::uint16_t port_;
  std::mt19937 random_;
  std::unique_ptr<transport::TcpListener> listener_;
  std::unique_ptr<transport::UdpSocket> socket_;
  std::map<std::uint64_t, Link> links_;
  std::uint64_t last_link_ = 0;
  std::map<OwnerId, Known> routes_;
  std::map<OwnerId, HostRecord> known_;
  std::vector<Unacknowledged> unacknowledged_;
  std::map<OwnerId, std::vector<std::uint32_t>> acks_;
  std::set<std::uint32_t> seen_;
  std::uint32_t sequence_ = 0;
  bool announces_ = false;
  SteadyTime next_routing_, next_ack_, next_announcement_, next_connect_;
  Timer timer_;
};

}  // namespace rubicon::tuples::peis
