#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "base/scheduler.h"
#include "tuples/peis/deliveries.h"
#include "tuples/peis/hosts.h"
#include "tuples/peis/node_links.h"
#include "tuples/peis/routes.h"

namespace rubicon::tuples::peis {

/// The ways of a node to hosts: keeps the routing table with its neighbours, tells the hosts which of them can be
/// reached, and sends along the ways.
class NodeRouting {
 public:
  /// All must outlive it.
  NodeRouting(NodeContext& context, NodeLinks& links, Hosts& hosts, Deliveries& deliveries);

  /// Begins to tell the neighbours what it knows, each kRoutingPeriod and after changes.
  void begin();
  const Routes& routes() const { return routes_; }

  /// The link is a route now: its magic is set.
  void open(NodeLink& link, const HostRecord& record);
  /// It was one, and was heard last then.
  void close(const NodeLink& link, SteadyTime heard);
  /// A page of a neighbour.
  void take(NodeLink& link, const RoutingPage& page);
  /// The host spoke by way of the link.
  void hear(const NodeLink& link, const HostRecord& record, int hops);
  /// It left.
  void forget(OwnerId host);

  /// Tells the neighbour what this node knows.
  void tell(NodeLink& link);
  Emitted emit(OwnerId to, std::span<std::uint8_t> package, bool urgent);
  /// A message of the node itself, without acknowledgement.
  void send(OwnerId to, Port port, ByteView body);

 private:
  void apply(const RouteChanges& changes, std::optional<std::pair<OwnerId, SteadyTime>> heard = std::nullopt);
  void report_found(const RouteChanges& changes);
  void periodic();
  void tell_all();

  NodeContext& context_;
  NodeLinks& links_;
  Hosts& hosts_;
  Deliveries& deliveries_;
  Routes routes_;
  std::uint32_t sequence_ = 0;
  base::PacedCall updates_;
  Timer period_;
};

}  // namespace rubicon::tuples::peis
