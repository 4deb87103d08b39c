#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tuples/peis/node_impl.h"

namespace rubicon::tuples::peis {

NodeLink* Node::Impl::link(LinkId id) {
  const auto found = links.find(id);
  return found == links.end() ? nullptr : &found->second;
}

bool Node::Impl::is_linked(OwnerId peer) const {
  return std::any_of(links.begin(), links.end(), [&](const auto& item) {
    const auto& link = item.second;  // what one that connected says of itself shows nothing before its record
    return link.peer == peer && (link.is_route() || link.initiated);
  });
}

std::size_t Node::Impl::strangers() const {
  return static_cast<std::size_t>(std::count_if(links.begin(), links.end(), [](const auto& item) {
    return !item.second.initiated && item.second.peer == OwnerId{};
  }));
}

bool Node::Impl::may_accept(const std::string& address) const {
  std::size_t all = 0, of_host = 0;
  for (const auto& [id, link] : links) {
    if (link.initiated || link.is_route()) continue;
    ++all;
    if (link.connection->remote().address == address) ++of_host;
  }
  const bool is_local = address.starts_with("127.");
  return all < kMaxUnmet && strangers() < kMaxStrangers && (is_local || of_host < kMaxUnmetOfHost);
}

bool Node::Impl::has_room(std::size_t limit) const {
  const auto used = std::count_if(links.begin(), links.end(),
                                  [](const auto& item) { return item.second.initiated || item.second.is_route(); });
  return static_cast<std::size_t>(used) < limit;
}

NodeLink& Node::Impl::make_link(bool initiated) {
  const LinkId id{++last_link};
  ConnectionCalls events;
  const auto with = [this, id](auto call) {
    return [this, id, call](auto&&... arguments) {
      if (auto* found = link(id)) call(*found, arguments...);
    };
  };
  events.connected = with([this](NodeLink& link) { greet(link); });
  events.greeted = [this, id](const ConnectMessage& message) {
    auto* found = link(id);
    return found && greeted(*found, message);
  };
  events.package = with([this](NodeLink& link, const Package& package) { received(link, package); });
  events.closed = [this, id](Ending why, const Error& error) { closed(id, why, error); };
  events.room = [this] { pumping.request(); };
  events.quiet = with([this](NodeLink& link) { send_on(link, Routing::kLink, Port::kHello, {}); });
  auto& made = links[id];
  made.id = id;
  made.initiated = initiated;
  made.connection = std::make_unique<Connection>(scheduler, std::move(events));
  return made;
}

transport::TcpCalls Node::Impl::accept(std::unique_ptr<transport::TcpStream> stream) {
  const auto from = stream->remote().address;
  if (may_accept(from)) return make_link(false).connection->accept(std::move(stream));
  ++counters.too_many_links;
  log.warning("strangers", "connection from " + from + " refused: too many others have not sent who they are");
  return {};
}

bool Node::Impl::dial(const Target& target, const transport::Endpoint& to, std::uint32_t flags) {
  if (to == local) return false;
  if (!has_room(kMaxLinks + kReservedLinks)) {
    ++counters.too_many_links;
    return log.warning("links", "no connection to " + transport::to_string(to) + ": too many connections"), false;
  }
  auto& link = make_link(true);
  const auto dialed = link.connection->dial(transports, to, {options.id, flags, options.network});
  if (dialed) return link.target = target, true;
  log.debug("dial " + transport::to_string(to), dialed.error().text);
  links.erase(link.id);
  return false;
}

/// Whether the connect message is one of this network, of another component.
bool Node::Impl::greeted(NodeLink& link, const ConnectMessage& message) {
  const auto from = link.connection->remote();
  const auto name = fmt::format("component {} at {}", number(message.id), transport::to_string(from));
  if (message.network != options.network) {
    ++counters.foreign_networks;
    troubles.note(TroubleKind::kForeignNetwork, message.id, transport::to_string(from), message.network);
    return log.info("network " + name, fmt::format("{}: refused, its network is another one", name)), false;
  }
  if (message.id == options.id) {
    ++counters.own_id_seen;
    const bool is_self = std::any_of(links.begin(), links.end(),
                                     [&](const auto& item) { return item.second.connection->local() == from; });
    if (is_self) return false;
    // Its record follows. Without one it asks whether this node is there: closing is the answer.
    link.record_due = scheduler.after(kClaimTime, [this, id = link.id] {
      if (auto* asked = this->link(id)) close(*asked);
    });
    return true;
  }
  const auto id = number(message.id);
  if (id == 0 || id > kMaxId) return ++counters.bad_ids, false;
  if (!has_room(kMaxLinks)) {
    ++counters.too_many_links;
    return log.warning("links", name + ": refused, too many connections"), false;
  }
  link.peer = message.id;
  greet(link);
  return true;
}

/// What each side sends first (section 3.3).
void Node::Impl::greet(NodeLink& link) {
  const auto record = write(HostRecordMessage{own_record(), false});
  send_on(link, Routing::kLink, Port::kHostInfo, record);
  send_routing(link);
  send_on(link, Routing::kBroadcast, Port::kHostInfo, record);
  expect_record(link);
}

/// Without its record a connection leads nowhere, but takes room.
void Node::Impl::expect_record(NodeLink& link) {
  link.record_due = scheduler.after(kRecordTime, [this, id = link.id] {
    auto* late = this->link(id);
    if (!late || late->is_route()) return;
    ++counters.silent_links;
    const auto text = fmt::format("component {} at {} did not send who it is", number(late->peer),
                                  transport::to_string(late->connection->remote()));
    log.warning("no record", text + ": connection closed");
    if (late->initiated) unreachable(late->target, Error{ErrorCode::kUnreachable, text});
    close(*late);
  });
}

/// The peer sent its host record: the link becomes a route.
void Node::Impl::meet(NodeLink& met, const HostRecord& record) {
  const auto id = met.id;
  if (met.is_route()) {
    if (met.magic != record.magic) return close(met);
    return void(hosts.learn(record, RecordSource::kOwnLink));
  }
  if (!met.initiated && !is_linked(record.id) && !has_room(kMaxLinks)) {
    ++counters.too_many_links;
    log.warning("links", fmt::format("component {}: refused, too many connections", number(record.id)));
    return close(met);
  }
  if (!hosts.learn(record, RecordSource::kOwnLink)) {
    log.info(
        fmt::format("over {}", number(record.id)),
        fmt::format("component {}: refused, another start of it came later, or too many hosts", number(record.id)));
    if (hosts.is_over(record.id, record.magic))
      troubles.note(TroubleKind::kSharedId, record.id, record.full_name, "it connected after another start");
    return close(met);
  }
  troubles.reached(record.id, address_of(met.target));
  dialer.connected(met.target, record.id);
  std::vector<LinkId> former;
  for (const auto& [other, link] : links) {
    if (link.peer == record.id && link.is_route() && link.magic != record.magic) former.push_back(other);
  }
  for (const auto other : former) close(*link(other));
  met.magic = record.magic;
  const auto* before = routes.find(record.id);
  const bool was_far = before && !before->direct;
  widen_links(record.id);
  const auto early = std::exchange(met.early, {});
  const auto now = scheduler.now();
  apply(routes.open(id, record.id, record.magic, record.host_name == options.host_name ? 1 : 2, now));
  for (const auto& page : early) apply(routes.receive(id, page, now));
  if (was_far) deliveries.send_again(record.id);  // a hello that comes another way is refused from now on
  updates.request();
  drop_duplicates(record.id);
  if (placeless.contains(record.id)) release();
}

/// Of connections that one side established the newest stays; of those of both sides that of the lower id, among
/// components of ours.
void Node::Impl::drop_duplicates(OwnerId peer) {
  NodeLink* by_us = nullptr;
  NodeLink* by_peer = nullptr;
  std::vector<LinkId> surplus;
  for (auto& [id, link] : links) {
    if (link.peer != peer || !link.is_route()) continue;
    auto& newest = link.initiated ? by_us : by_peer;
    if (newest) surplus.push_back(newest->id);
    newest = &link;
  }
  if (by_us && by_peer && by_us->ours && by_peer->ours) surplus.push_back((options.id < peer ? by_peer : by_us)->id);
  for (const auto id : surplus) close(*link(id));
}

void Node::Impl::widen_links(OwnerId peer) {
  const auto lease = hosts.lease(peer);
  for (auto& [id, link] : links) {
    if (link.peer != peer || !lease || !link.is_route()) continue;
    link.ours = true;
    link.connection->widen(*lease, options.hello.lease);
  }
}

void Node::Impl::close(NodeLink& link) {
  link.connection->close();
  remove(link.id, false);
}

/// `host:port` of a configured host, else empty.
std::string Node::Impl::address_of(const Target& target) const {
  if (target.configured < 0) return {};
  return options.connect.at(static_cast<std::size_t>(target.configured));
}

void Node::Impl::unreachable(const Target& target, const Error& error) {
  const auto* record = hosts.record(target.host);
  troubles.note(TroubleKind::kUnreachable, target.host, record ? record->full_name : address_of(target), error.text);
}

void Node::Impl::closed(LinkId id, Ending why, const Error& error) {
  const auto* ended = link(id);
  if (ended && ended->initiated && !ended->is_route()) unreachable(ended->target, error);
  if (why == Ending::kStuck) ++counters.stuck_links;
  if (why == Ending::kSilent) ++counters.silent_links;
  if (why == Ending::kStrange) {
    const bool version = error.code == ErrorCode::kUnsupported;
    ++(version ? counters.foreign_versions : counters.bad_streams);
    if (version) troubles.note(TroubleKind::kForeignVersion, ended ? ended->peer : OwnerId{}, {}, error.text);
    log.warning("strange bytes", error.text);
  } else {
    const bool is_odd = why == Ending::kStuck || why == Ending::kSilent;
    if (is_odd)
      log.info("dead connection", fmt::format("component {}: {}", number(ended ? ended->peer : OwnerId{}), error.text));
    log.debug("connection", error.text);
  }
  remove(id, true);
}

void Node::Impl::remove(LinkId id, bool broken) {
  auto gone = links.extract(id);
  if (gone.empty()) return;
  auto& link = gone.mapped();
  const auto now = scheduler.now();
  const auto heard = link.connection->heard();
  over.push_back(std::move(link.connection));
  cleaning.request();
  if (link.initiated) dialer.ended(link.target, link.is_route());
  if (!link.is_route()) return;
  std::vector<OwnerId> moved;
  for (const auto& [host, route] : routes.all()) {
    if (route.link == id) moved.push_back(host);
  }
  apply(routes.close(id, now), std::pair(link.peer, heard));
  for (const auto host : moved) {
    if (routes.find(host)) deliveries.send_again(host);
  }
  updates.request();
  if (broken && link.target.configured < 0 && !is_linked(link.peer)) dialer.again(link.peer, link.initiated);
}

void Node::Impl::apply(const RouteChanges& changes, std::optional<std::pair<OwnerId, SteadyTime>> heard) {
  for (const auto host : changes.lost) {
    if (routes.find(host)) continue;
    hosts.unroutable(host, heard && heard->first == host ? heard->second : scheduler.now());
  }
  find_routable(changes);
  if (changes.any()) updates.request();
}

void Node::Impl::find_routable(const RouteChanges& changes) {
  for (const auto host : changes.found) {
    if (const auto* route = routes.find(host)) hosts.routable(host, route->magic);
  }
}

/// Changes beyond the budget go out with the next routing.
void Node::Impl::take_routing(NodeLink& link, const RoutingPage& page) {
  const auto now = scheduler.now();
  const auto changes = routes.receive(link.id, page, now);
  if (changes.any() && link.changes.take(now, kMaxChanges, kRoutingPeriod)) updates.request();
  for (const auto host : changes.lost) {
    if (!routes.find(host)) hosts.unroutable(host, now);
  }
  find_routable(changes);
}

void Node::Impl::periodic() {
  period = scheduler.after(kRoutingPeriod, [this] { periodic(); });
  apply(routes.age(scheduler.now()));
  updates.call_now();
}

void Node::Impl::update() {
  ++sequence;
  for (auto& [id, link] : links) {
    if (link.peer != OwnerId{}) send_routing(link);
  }
}

void Node::Impl::send_routing(NodeLink& link) {
  auto entries = routes.entries_for(link.id, scheduler.now());
  // Before its record is here: what is known is a former start, and a kernel would take the route to that as its own.
  if (!link.is_route()) std::erase_if(entries, [&](const RouteEntry& entry) { return entry.id == link.peer; });
  const auto connections = static_cast<std::uint8_t>(std::min<std::size_t>(links.size(), 254));
  entries.insert(entries.begin(), {options.id, sequence, options.magic, 0, connections});
  const auto pages = (entries.size() + kMaxRoutesOfPage - 1) / kMaxRoutesOfPage;
  for (std::size_t i = 0; i < pages; ++i) {
    RoutingPage page;
    page.page = static_cast<std::uint16_t>(i);
    page.pages = static_cast<std::uint16_t>(pages);
    page.sequence = sequence;
    const auto first = entries.begin() + static_cast<std::ptrdiff_t>(i * kMaxRoutesOfPage);
    const auto size = std::min(kMaxRoutesOfPage, entries.size() - i * kMaxRoutesOfPage);
    page.entries.assign(first, first + static_cast<std::ptrdiff_t>(size));
    send_on(link, Routing::kLink, Port::kRouting, write(page));
  }
}

}  // namespace rubicon::tuples::peis
