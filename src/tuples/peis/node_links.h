#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/peis/connection.h"
#include "tuples/peis/deliveries.h"
#include "tuples/peis/discovery.h"
#include "tuples/peis/hosts.h"
#include "tuples/peis/node.h"
#include "tuples/peis/routes.h"
#include "tuples/peis/troubles.h"

namespace rubicon::tuples::peis {

/// What the parts of a node share.
struct NodeContext {
  NodeOptions options;
  Scheduler& scheduler;
  transport::Transports& transports;
  base::LimitedLog log;
  NodeCounters counters{};
  Troubles troubles{};
};

/// How often something may happen in a time.
struct Budget {
  SteadyTime since{};
  int taken = 0;

  /// Whether it is one of the first `most` of the period.
  bool take(SteadyTime now, int most, Duration period) {
    if (now - since >= period) since = now, taken = 0;
    return ++taken <= most;
  }
};

/// A connection and what it is for.
struct NodeLink {
  LinkId id{};
  std::unique_ptr<Connection> connection;
  bool initiated = false;  ///< by this node
  Target target;
  OwnerId peer{};                  ///< 0 = not known yet
  std::uint32_t magic = 0;         ///< of the peer; 0 = its host record has not come, and the link is not a route
  bool ours = false;               ///< the peer sent a hello
  std::vector<RoutingPage> early;  ///< came before the host record
  Timer record_due;
  Budget broadcasts, changes;  ///< that are passed on; routing changes that are

  bool is_route() const { return magic != 0; }
};

inline bool is_id(OwnerId id) {
  return number(id) > 0 && number(id) <= kMaxId;
}

inline bool is_loopback_only(const NodeOptions& options) {
  return std::all_of(options.interfaces.begin(), options.interfaces.end(),
                     [](const auto& interface) { return interface.is_loopback; });
}

/// The connections of a node: which there are, with whom, and how many may be.
class NodeLinks {
 public:
  struct Callbacks {
    /// The connection is established: each side says who it is. Its own record has to follow.
    std::function<void(NodeLink&)> greet;
    std::function<void(NodeLink&, const Package&)> package;
    /// There is room again on a connection.
    std::function<void()> room;
    /// The connection is closed, and was heard last then. `broken`: not by this node.
    std::function<void(const NodeLink&, SteadyTime heard, bool broken)> ended;
  };

  /// All must outlive it.
  NodeLinks(NodeContext& context, const Hosts& hosts, Deliveries& deliveries, Callbacks calls);
  NodeLinks(const NodeLinks&) = delete;
  NodeLinks& operator=(const NodeLinks&) = delete;

  /// Listens on the first free port of the options; the errors of Node::open().
  Result<void> listen();
  /// Closes all. No calls follow.
  void end();
  transport::Endpoint local() const { return local_; }  ///< where it listens
  /// False: the address cannot be tried.
  bool dial(const Target& target, const transport::Endpoint& to, std::uint32_t flags);
  /// The target was not reached.
  void unreachable(const Target& target, const Error& error);
  /// `host:port` of a configured host, else empty.
  std::string address_of(const Target& target) const;

  const std::map<LinkId, NodeLink>& all() const { return links_; }
  NodeLink* find(LinkId id);
  bool is_linked(OwnerId peer) const;
  /// Whether a connection of the host comes from an address of this machine. A name shows nothing: any host may have
  /// it.
  bool is_here(OwnerId host) const;
  /// Whether the connection may become a route to the host.
  bool has_room_for(const NodeLink& link, OwnerId host) const;
  /// The peer is a component of ours.
  void widen(OwnerId peer, Duration lease);

  void close(NodeLink& link);
  void close_all(OwnerId peer);
  /// Closes the routes to other starts of the host.
  void close_former(OwnerId peer, std::uint32_t magic);
  /// If one side established several connections, the newest stays. If both sides did, the connection of the lower id
  /// stays, among components of ours.
  void close_duplicates(OwnerId peer);

  void send(NodeLink& link, Routing routing, Port port, ByteView body);
  /// Sends a whole package on all routes but one.
  void flood(ByteView package, std::optional<LinkId> except);

 private:
  Result<void> listen(std::uint16_t port);
  transport::TcpCallbacks accept(std::unique_ptr<transport::TcpStream> stream);
  NodeLink& make(bool initiated);
  bool greeted(NodeLink& link, const ConnectMessage& message);
  void greet(NodeLink& link);
  bool may_accept(const std::string& address) const;
  std::size_t strangers() const;
  bool has_room(std::size_t limit) const;
  void close_each(const std::function<bool(const NodeLink&)>& which);
  void closed(LinkId id, Ending why, const Error& error);
  void remove(LinkId id, bool broken);

  NodeContext& context_;
  const Hosts& hosts_;
  Deliveries& deliveries_;
  Callbacks callbacks_;
  std::map<LinkId, NodeLink> links_;
  std::uint64_t last_link_ = 0;
  std::vector<std::unique_ptr<Connection>> over_;  ///< closed in this turn
  std::unique_ptr<transport::TcpListener> listener_;
  transport::Endpoint local_;
  base::OncePerTurn cleaning_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::tuples::peis
