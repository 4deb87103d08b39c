#pragma once

#include <cstdint>
#include <string>

#include "tuples/peis/connection.h"
#include "tuples/peis/deliveries.h"
#include "tuples/peis/forgeries.h"
#include "tuples/peis/fragments.h"
#include "tuples/peis/hosts.h"
#include "tuples/peis/node_links.h"
#include "tuples/peis/node_presence.h"
#include "tuples/peis/node_routing.h"
#include "tuples/peis/places.h"

namespace rubicon::tuples::peis {

/// What arrives from whom (docs/life-of-a-frame.md): judges each package that a connection brings, passes on what is
/// for others, and gives what is for this node to the part that it is for: who is there, ways, deliveries, or the
/// tuples.
class Packages {
 public:
  /// All must outlive it.
  Packages(NodeContext& context, const NodeCallbacks& calls, Hosts& hosts, NodeLinks& links, NodeRouting& routing,
           Deliveries& deliveries, Places& places, Forgeries& forgeries, NodePresence& presence)
      : context_(context),
        callbacks_(calls),
        hosts_(hosts),
        links_(links),
        routing_(routing),
        deliveries_(deliveries),
        places_(places),
        forgeries_(forgeries),
        presence_(presence),
        fragments_(context.scheduler) {}

  void received(NodeLink& link, const Package& package);
  /// A message for the tuples.
  void take_message(const Package& package);
  /// The host is gone: what it did not finish is dropped.
  void forget(OwnerId host) { fragments_.forget(host); }

 private:
  bool is_sound(const NodeLink& link, const PackageHeader& header);
  /// Counts it, with one line in the log a minute.
  void dropped(std::uint64_t& counter, const std::string& what, const NodeLink& from, const PackageHeader& header);
  void received_broadcast(NodeLink& link, const Package& package);
  void forward(NodeLink& from, const Package& package);
  bool take(NodeLink& link, const Package& package);
  bool take_node_message(NodeLink& link, const Package& package);
  void answer_query(const QueryHost& query);
  void answer_trace(OwnerId asker, Trace trace);

  NodeContext& context_;
  const NodeCallbacks& callbacks_;
  Hosts& hosts_;
  NodeLinks& links_;
  NodeRouting& routing_;
  Deliveries& deliveries_;
  Places& places_;
  Forgeries& forgeries_;
  NodePresence& presence_;
  Fragments fragments_;
  SeenIds<std::uint64_t> broadcasts_{kDuplicateTable};
};

}  // namespace rubicon::tuples::peis
