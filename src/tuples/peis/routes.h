#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "rubicon/time.hpp"
#include "tuples/peis/troubles.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

/// A connection of this node; never used again.
enum class LinkId : std::uint64_t {};

/// How this node reaches a host.
struct Route {
  LinkId link{};
  OwnerId via{};  ///< the neighbour
  std::uint32_t sequence = 0;
  std::uint32_t magic = 0;  ///< of the host
  int metric = 0;
  std::uint8_t connections = 0;
  bool direct = false;    ///< the host is the neighbour
  bool unlisted = false;  ///< only heard that way: no page of the neighbour lists it yet
  SteadyTime renewed{};
};

/// What a change of the table led to. `found`: a route where there was none, or to another start of the host.
struct RouteChanges {
  std::vector<OwnerId> found, lost;
  bool any() const { return !found.empty() || !lost.empty(); }
};

/// The routing table (peis.md, section 3.7), by sequence and metric. A lost route comes back only with a newer sequence
/// or magic, and no route is advertised to the neighbour that it leads over: so there are no loops among nodes of ours,
/// whatever kernels advertise. Does no I/O.
class Routes {
 public:
  static constexpr std::size_t kMaxRoutes = 1024;               ///< besides those to neighbours
  static constexpr Duration kStale = std::chrono::seconds(60);  ///< without a newer sequence
  static constexpr Duration kKeepLost = 4 * kRoutingPeriod;

  /// `is_over`: whether the start of a host with this magic is known to have ended. The counters must outlive it.
  Routes(OwnerId self, NodeCounters& counters, std::function<bool(OwnerId, std::uint32_t magic)> is_over);

  /// The neighbour on a link is known. Cost: 1 on the same host, else 2.
  RouteChanges open(LinkId link, OwnerId peer, std::uint32_t magic, int cost, SteadyTime now);
  RouteChanges close(LinkId link, SteadyTime now);
  /// A page of the table of a neighbour. Pages of links that are not open are ignored.
  RouteChanges receive(LinkId link, const RoutingPage& page, SteadyTime now);
  /// A host that no neighbour lists spoke by way of this link, after so many hops: it is reached that way until pages
  /// say otherwise. Nothing for one that was lost: only its newer sequence brings it back.
  RouteChanges hear(LinkId link, OwnerId host, std::uint32_t magic, int hops, SteadyTime now);
  /// The host left: it needs a newer sequence to come back.
  RouteChanges forget(OwnerId host, SteadyTime now);
  /// Call it each kRoutingPeriod.
  RouteChanges age(SteadyTime now);

  const Route* find(OwnerId host) const;
  const std::map<OwnerId, Route>& all() const { return routes_; }
  /// What to advertise to a neighbour, without this node itself.
  std::vector<RouteEntry> entries_for(LinkId link, SteadyTime now) const;
  /// The lowest id that can be reached, this node's included.
  OwnerId cluster() const;

 private:
  struct Neighbour {
    OwnerId peer{};
    std::uint32_t magic = 0;
    int cost = 0;
    std::vector<OwnerId> listed;  ///< in the pages since page 0
    std::uint32_t next_page = 0;
  };
  struct Lost {
    std::uint32_t sequence = 0, magic = 0;
    SteadyTime since{};
  };

  void receive(LinkId link, const Neighbour& neighbour, const RouteEntry& entry, SteadyTime now, RouteChanges& changes);
  void take(OwnerId host, Route route, RouteChanges& changes);
  bool is_better(OwnerId host, const Route& offered, const Route& present, SteadyTime now) const;
  void lose(OwnerId host, SteadyTime now, RouteChanges& changes);
  void withdraw_unlisted(LinkId link, Neighbour& neighbour, SteadyTime now, RouteChanges& changes);
  bool is_neighbour(OwnerId host) const;

  OwnerId self_;
  NodeCounters& counters_;
  std::function<bool(OwnerId, std::uint32_t)> is_over_;
  std::map<LinkId, Neighbour> neighbours_;
  std::map<OwnerId, Route> routes_;
  std::map<OwnerId, Lost> lost_;
};

}  // namespace rubicon::tuples::peis
