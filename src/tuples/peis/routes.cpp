#include "tuples/peis/routes.h"

#include <algorithm>

namespace rubicon::tuples::peis {

namespace {

/// Without news for this long, a longer way with a newer sequence replaces a route.
constexpr Duration kAging = 25 * std::chrono::seconds(1);
/// A neighbour lists a host that it passed packages of within its next two pages.
constexpr Duration kUnlistedTime = 2 * kRoutingPeriod;

bool is_newer(std::uint32_t one, std::uint32_t other) {
  return static_cast<std::int32_t>(one - other) > 0;
}

}  // namespace

Routes::Routes(OwnerId self, NodeCounters& counters, std::function<bool(OwnerId, std::uint32_t)> is_over)
    : self_(self), counters_(counters), is_over_(std::move(is_over)) {}

RouteChanges Routes::open(LinkId link, OwnerId peer, std::uint32_t magic, int cost, SteadyTime now) {
  RouteChanges changes;
  neighbours_[link] = {peer, magic, cost, {}, 0};
  const auto present = routes_.find(peer);
  std::uint32_t sequence = 0;
  if (present != routes_.end() && present->second.magic == magic) sequence = present->second.sequence;
  if (const auto lost = lost_.find(peer); lost != lost_.end() && lost->second.magic == magic)
    sequence = lost->second.sequence;
  take(peer, {link, peer, sequence, magic, cost, 0, true, false, now}, changes);
  return changes;
}

/// The neighbour may have another connection.
RouteChanges Routes::close(LinkId link, SteadyTime now) {
  RouteChanges changes;
  const auto closed = neighbours_.extract(link);
  if (closed.empty()) return changes;
  std::vector<OwnerId> over;
  for (auto& [host, route] : routes_) {
    if (route.link != link) continue;
    const auto other = std::find_if(neighbours_.begin(), neighbours_.end(), [&, via = route.via](const auto& item) {
      return item.second.peer == via && item.second.magic == closed.mapped().magic;
    });
    if (other == neighbours_.end()) {
      over.push_back(host);
    } else {
      route.link = other->first;
    }
  }
  for (const auto host : over) lose(host, now, changes);
  return changes;
}

RouteChanges Routes::receive(LinkId link, const RoutingPage& page, SteadyTime now) {
  RouteChanges changes;
  const auto found = neighbours_.find(link);
  if (found == neighbours_.end()) return changes;
  auto& neighbour = found->second;
  if (page.page == 0) {
    neighbour.listed.clear();
    neighbour.next_page = 0;
  }
  const bool in_order = page.page == neighbour.next_page && neighbour.listed.size() <= kMaxRoutes;
  for (const auto& entry : page.entries) {
    if (in_order) neighbour.listed.push_back(entry.id);
    receive(link, neighbour, entry, now, changes);
  }
  if (!in_order) return changes;
  if (++neighbour.next_page == page.pages) withdraw_unlisted(link, neighbour, now, changes);
  return changes;
}

RouteChanges Routes::hear(LinkId link, OwnerId host, std::uint32_t magic, int hops, SteadyTime now) {
  RouteChanges changes;
  const auto found = neighbours_.find(link);
  if (found == neighbours_.end() || host == self_ || routes_.contains(host) || is_over_(host, magic)) return changes;
  const auto lost = lost_.find(host);
  const int metric = hops + found->second.cost;
  if ((lost != lost_.end() && lost->second.magic == magic) || metric >= kUnreachableMetric) return changes;
  take(host, {link, found->second.peer, 0, magic, metric, 0, false, true, now}, changes);
  return changes;
}

void Routes::withdraw_unlisted(LinkId link, Neighbour& neighbour, SteadyTime now, RouteChanges& changes) {
  auto& listed = neighbour.listed;
  std::sort(listed.begin(), listed.end());
  std::vector<OwnerId> over;
  for (const auto& [host, route] : routes_) {
    const bool is_new = route.unlisted && now - route.renewed < kUnlistedTime;
    if (route.link == link && !route.direct && !is_new && !std::binary_search(listed.begin(), listed.end(), host))
      over.push_back(host);
  }
  listed.clear();
  for (const auto host : over) lose(host, now, changes);
}

bool Routes::is_neighbour(OwnerId host) const {
  const auto found = routes_.find(host);
  return found != routes_.end() && found->second.direct;
}

void Routes::receive(LinkId link, const Neighbour& neighbour, const RouteEntry& entry, SteadyTime now,
                     RouteChanges& changes) {
  const auto id = number(entry.id);
  if (entry.id == self_ || id == 0 || id > kMaxId) return;
  const auto present = routes_.find(entry.id);
  if (entry.id == neighbour.peer || is_neighbour(entry.id)) {  // what others say of a neighbour does not count
    if (entry.id != neighbour.peer || entry.magic != neighbour.magic || present == routes_.end()) return;
    if (is_newer(entry.sequence, present->second.sequence)) present->second.sequence = entry.sequence;
    present->second.connections = entry.connections;
    present->second.renewed = now;
    return;
  }
  const int metric = entry.hops + neighbour.cost;
  if (metric >= kUnreachableMetric) {
    if (present != routes_.end() && present->second.link == link) lose(entry.id, now, changes);
    return;
  }
  if (is_over_(entry.id, entry.magic)) return;
  const Route offered{link, neighbour.peer, entry.sequence, entry.magic, metric, entry.connections, false, false, now};
  if (present != routes_.end() && !is_better(entry.id, offered, present->second, now)) return;
  const auto lost = lost_.find(entry.id);
  if (present == routes_.end() && lost != lost_.end() && lost->second.magic == entry.magic &&
      !is_newer(entry.sequence, lost->second.sequence))
    return;
  take(entry.id, offered, changes);
}

bool Routes::is_better(OwnerId host, const Route& offered, const Route& present, SteadyTime now) const {
  if (present.unlisted) return true;  // hearsay
  // A living host sends news in each kRoutingPeriod. News of another start by another way is ignored while the present
  // start lives.
  if (offered.magic != present.magic)
    return offered.link == present.link || is_over_(host, present.magic) || now - present.renewed > kAging;
  const bool newer = is_newer(offered.sequence, present.sequence);
  if (offered.link == present.link)
    return newer || (offered.sequence == present.sequence && offered.metric != present.metric);
  if (newer) return offered.metric <= present.metric || now - present.renewed > kAging;
  return offered.sequence == present.sequence && offered.metric < present.metric;
}

void Routes::take(OwnerId host, Route route, RouteChanges& changes) {
  const auto present = routes_.find(host);
  if (present == routes_.end() && !route.direct && routes_.size() >= kMaxRoutes) {
    ++counters_.too_many_routes;
    return;
  }
  const bool is_found = present == routes_.end() || present->second.magic != route.magic;
  if (present != routes_.end() && !is_newer(route.sequence, present->second.sequence) && !is_found)
    route.renewed = route.direct ? route.renewed : present->second.renewed;  // no news of the host
  routes_[host] = route;
  lost_.erase(host);
  if (is_found) changes.found.push_back(host);
}

void Routes::lose(OwnerId host, SteadyTime now, RouteChanges& changes) {
  const auto gone = routes_.extract(host);
  if (gone.empty()) return;
  changes.lost.push_back(host);
  if (gone.mapped().unlisted) return;  // its sequence is not known
  if (lost_.size() >= kMaxRoutes) lost_.erase(lost_.begin());
  lost_[host] = {gone.mapped().sequence, gone.mapped().magic, now};
}

RouteChanges Routes::forget(OwnerId host, SteadyTime now) {
  RouteChanges changes;
  lose(host, now, changes);
  return changes;
}

RouteChanges Routes::age(SteadyTime now) {
  RouteChanges changes;
  std::erase_if(lost_, [&](const auto& item) { return now - item.second.since > kKeepLost; });
  std::vector<OwnerId> over;
  for (const auto& [host, route] : routes_) {
    if (!route.direct && now - route.renewed > kStale) over.push_back(host);
  }
  for (const auto host : over) lose(host, now, changes);
  return changes;
}

const Route* Routes::find(OwnerId host) const {
  const auto found = routes_.find(host);
  return found == routes_.end() ? nullptr : &found->second;
}

std::vector<RouteEntry> Routes::entries_for(LinkId link, SteadyTime now) const {
  std::vector<RouteEntry> entries;
  for (const auto& [host, route] : routes_) {
    if (route.unlisted || (route.link == link && !route.direct)) continue;
    entries.push_back({host, route.sequence, route.magic, static_cast<std::uint8_t>(route.metric), route.connections});
  }
  for (const auto& [host, lost] : lost_) {
    const auto steps = (now - lost.since) / kRoutingPeriod;
    if (steps > kDeletedRoute - kLostRoute) continue;
    entries.push_back({host, lost.sequence, lost.magic, static_cast<std::uint8_t>(kLostRoute + steps), 0});
  }
  return entries;
}

OwnerId Routes::cluster() const {
  return routes_.empty() ? self_ : std::min(self_, routes_.begin()->first);
}

}  // namespace rubicon::tuples::peis
