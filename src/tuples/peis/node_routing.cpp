#include "tuples/peis/node_routing.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace rubicon::tuples::peis {

namespace {

constexpr std::size_t kMaxEarlyPages = 16;
constexpr int kMaxChanges = 40;  ///< routing pages of one connection that are passed on at once, in 10 s
constexpr Duration kUpdatePause = std::chrono::milliseconds(100);

}  // namespace

NodeRouting::NodeRouting(NodeContext& context, NodeLinks& links, Hosts& hosts, Deliveries& deliveries)
    : context_(context),
      links_(links),
      hosts_(hosts),
      deliveries_(deliveries),
      routes_(context.options.id, context.counters,
              [this](OwnerId host, std::uint32_t magic) { return hosts_.is_over(host, magic); }),
      updates_(context.scheduler, kUpdatePause, [this] { tell_all(); }) {}

void NodeRouting::begin() {
  periodic();
}

void NodeRouting::periodic() {
  period_ = context_.scheduler.after(kRoutingPeriod, [this] { periodic(); });
  apply(routes_.age(context_.scheduler.now()));
  updates_.call_now();
}

/// What came before the host record counts now.
void NodeRouting::open(NodeLink& link, const HostRecord& record) {
  const auto* before = routes_.find(record.id);
  const bool was_far = before && !before->direct;
  const auto early = std::exchange(link.early, {});
  const auto now = context_.scheduler.now();
  const int cost = record.host_name == context_.options.host_name ? 1 : 2;
  apply(routes_.open(link.id, record.id, record.magic, cost, now));
  for (const auto& page : early) apply(routes_.receive(link.id, page, now));
  if (was_far) deliveries_.send_again(record.id);  // a hello that comes another way is refused from now on
  updates_.request();
}

void NodeRouting::close(const NodeLink& link, SteadyTime heard) {
  std::vector<OwnerId> moved;
  for (const auto& [host, route] : routes_.all()) {
    if (route.link == link.id) moved.push_back(host);
  }
  apply(routes_.close(link.id, context_.scheduler.now()), std::pair(link.peer, heard));
  for (const auto host : moved) {
    if (routes_.find(host)) deliveries_.send_again(host);
  }
  updates_.request();
}

/// Changes beyond the budget go out with the next routing.
void NodeRouting::take(NodeLink& link, const RoutingPage& page) {
  if (!link.is_route()) {
    if (link.early.size() < kMaxEarlyPages) link.early.push_back(page);
    return;
  }
  const auto now = context_.scheduler.now();
  const auto changes = routes_.receive(link.id, page, now);
  if (changes.any() && link.changes.take(now, kMaxChanges, kRoutingPeriod)) updates_.request();
  for (const auto host : changes.lost) {
    if (!routes_.find(host)) hosts_.unroutable(host, now);
  }
  report_found(changes);
}

void NodeRouting::hear(const NodeLink& link, const HostRecord& record, int hops) {
  for (const auto host : routes_.hear(link.id, record.id, record.magic, hops, context_.scheduler.now()).found)
    hosts_.routable(host, record.magic, false);
}

void NodeRouting::forget(OwnerId host) {
  apply(routes_.forget(host, context_.scheduler.now()));
}

void NodeRouting::apply(const RouteChanges& changes, std::optional<std::pair<OwnerId, SteadyTime>> heard) {
  for (const auto host : changes.lost) {
    if (routes_.find(host)) continue;
    hosts_.unroutable(host, heard && heard->first == host ? heard->second : context_.scheduler.now());
  }
  report_found(changes);
  if (changes.any()) updates_.request();
}

void NodeRouting::report_found(const RouteChanges& changes) {
  for (const auto host : changes.found) {
    if (const auto* route = routes_.find(host)) hosts_.routable(host, route->magic);
  }
}

void NodeRouting::tell_all() {
  ++sequence_;
  for (const auto& [id, link] : links_.all()) {
    if (link.peer != OwnerId{}) tell(*links_.find(id));
  }
}

void NodeRouting::tell(NodeLink& link) {
  auto entries = routes_.entries_for(link.id, context_.scheduler.now());
  // Before its record is here: what is known is a former start, and a kernel would take the route to that as its own.
  if (!link.is_route()) std::erase_if(entries, [&](const RouteEntry& entry) { return entry.id == link.peer; });
  const auto connections = static_cast<std::uint8_t>(std::min<std::size_t>(links_.all().size(), 254));
  entries.insert(entries.begin(), {context_.options.id, sequence_, context_.options.magic, 0, connections});
  const auto pages = (entries.size() + kMaxRoutesOfPage - 1) / kMaxRoutesOfPage;
  for (std::size_t i = 0; i < pages; ++i) {
    RoutingPage page;
    page.page = static_cast<std::uint16_t>(i);
    page.pages = static_cast<std::uint16_t>(pages);
    page.sequence = sequence_;
    const auto first = entries.begin() + static_cast<std::ptrdiff_t>(i * kMaxRoutesOfPage);
    const auto size = std::min(kMaxRoutesOfPage, entries.size() - i * kMaxRoutesOfPage);
    page.entries.assign(first, first + static_cast<std::ptrdiff_t>(size));
    links_.send(link, Routing::kLink, Port::kRouting, write(page));
  }
}

Emitted NodeRouting::emit(OwnerId to, std::span<std::uint8_t> package, bool urgent) {
  const auto* route = routes_.find(to);
  auto* way = route ? links_.find(route->link) : nullptr;
  if (!way) return Emitted::kNoRoute;
  return way->connection->send(package, urgent) ? Emitted::kSent : Emitted::kFull;
}

void NodeRouting::send(OwnerId to, Port port, ByteView body) {
  Bytes package;
  append_package(package, deliveries_.next_header(Routing::kDirect, port, to), body);
  emit(to, package, true);
}

}  // namespace rubicon::tuples::peis
