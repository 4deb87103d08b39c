#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string_view>

#include "base/scheduler.h"
#include "tuples/peis/connection.h"
#include "tuples/peis/deliveries.h"
#include "tuples/peis/discovery.h"
#include "tuples/peis/forgeries.h"
#include "tuples/peis/hosts.h"
#include "tuples/peis/node_links.h"
#include "tuples/peis/node_routing.h"
#include "tuples/peis/places.h"

namespace rubicon::tuples::peis {

/// Who is there, and which start of it: what hosts say of themselves and of each other, on connections, in packages and
/// in announcements, and what this node says of itself. Believes only what the way of a statement can show.
class NodePresence {
 public:
  /// All must outlive it.
  NodePresence(NodeContext& context, const NodeCallbacks& calls, Hosts& hosts, NodeLinks& links, NodeRouting& routing,
               Deliveries& deliveries, Dialer& dialer, Places& places, Forgeries& forgeries);

  /// Begins to announce this node, if the options say so.
  void begin();

  // -- connections
  /// Says who this node is, first (section 3.3).
  void greet(NodeLink& link);
  /// The connection is over, and was heard last then. `broken`: not by this node.
  void unlinked(const NodeLink& link, SteadyTime heard, bool broken);

  // -- packages; true: others should have it too
  void take_hello(NodeLink& link, const Package& package);
  void take_record(NodeLink& link, const PackageHeader& header, const HostRecordMessage& message);
  bool take_death(const PackageHeader& header, const DeadHost& dead);
  /// A package with this node's id as its source: its own package came back, or another component uses the id.
  void take_own_id(const Package& package);
  HostRecord own_record() const;

  // -- what Hosts reports
  void happened(HostEvent event, const Identity& host);
  void welcome(OwnerId host);
  void returned(const Identity& host);
  void gone(OwnerId host) { forgetful_.erase(host); }

 private:
  void meet(NodeLink& met, const HostRecord& record);
  void take_newcomer(const NodeLink& link, const PackageHeader& header, const HostRecord& record);
  RecordSource source_of(const NodeLink& link, const PackageHeader& header, const HostRecordMessage& message) const;
  bool is_other_start(const HostRecord& record, std::string_view from);
  void forgotten_by(OwnerId host);
  void leave_host(OwnerId host);
  void widen_links(OwnerId peer);
  void announced(const HostRecord& record);
  void id_claimed(const HostRecord& record);
  void id_taken(const Identity& other);

  /// A host that forgot this node.
  struct Forgetful {
    SteadyTime not_before{};
    Timer timer;
  };

  NodeContext& context_;
  const NodeCallbacks& callbacks_;
  Hosts& hosts_;
  NodeLinks& links_;
  NodeRouting& routing_;
  Deliveries& deliveries_;
  Dialer& dialer_;
  Places& places_;
  Forgeries& forgeries_;
  IdCheck id_check_;
  std::unique_ptr<Announcer> announcer_;
  std::set<std::uint32_t> taken_magics_;
  std::map<OwnerId, Forgetful> forgetful_;
};

}  // namespace rubicon::tuples::peis
