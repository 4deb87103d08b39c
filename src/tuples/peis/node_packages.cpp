#include <fmt/format.h>

#include <utility>

#include "tuples/peis/node_impl.h"

namespace rubicon::tuples::peis {

namespace {

/// Whether the node itself handles a port.
bool is_of_node(Port port) {
  return port == Port::kRouting || port == Port::kTrace || port == Port::kTraceReply || port == Port::kDeadHost ||
         port == Port::kTimeSync || port == Port::kQueryHost || port == Port::kHostInfo || port == Port::kAcks ||
         port == Port::kHello;
}

/// Whether messages on a port are for the tuples.
bool is_of_tuples(Port port) {
  const auto n = static_cast<int>(port);
  return (n >= 5 && n <= 7) || n == 10 || n == 15 || n == 16 || (n >= 41 && n <= kLastPort);
}

}  // namespace

// Receiving.

void Node::Impl::received(NodeLink& link, const Package& package) {
  const auto& header = package.header;
  if (!is_sound(link, header)) return;
  if (link.peer == OwnerId{}) {  // we connected, and this is the first that comes
    if (header.routing != Routing::kLink) return;
    if (header.source == options.id || !link.initiated) {
      own_id_in(package);
      return close(link);
    }
    link.peer = header.source;
  }
  if (header.source == options.id) {
    ++counters.duplicates;
    return own_id_in(package);
  }
  if (is_forged(link, package)) return;  // before it counts as received: the true one may come by the way of the host
  if (header.routing == Routing::kBroadcast) return received_broadcast(link, package);
  if (header.routing == Routing::kDirect) return received_direct(link, package);
  if (header.routing == Routing::kLink && header.source == link.peer) take(link, package);
}

/// A package that gives this node's id as its source: its own one that came back, or that of another component.
void Node::Impl::own_id_in(const Package& package) {
  if (package.header.port != Port::kHostInfo) return;
  const auto claim = read_host_info(package.body);
  if (claim && claim->host.id == options.id && claim->host.magic != options.magic) id_claimed(claim->host);
}

bool Node::Impl::is_sound(const NodeLink& link, const PackageHeader& header) {
  const bool destination = header.routing != Routing::kDirect || is_id(header.destination);
  const bool ids = is_id(header.source) && destination && header.id != 0;
  const bool port = static_cast<std::uint16_t>(header.port) <= kLastPort;
  if (!ids) dropped(counters.bad_ids, "an id out of range", link, header);
  if (ids && !port) dropped(counters.high_ports, "a port above 49, which kills kernels", link, header);
  return ids && port;
}

void Node::Impl::dropped(std::uint64_t& counter, const std::string& what, const NodeLink& from,
                         const PackageHeader& header) {
  ++counter;
  log.info(what, fmt::format("package of component {} by way of {} dropped: {}", number(header.source),
                             number(from.peer), what));
}

void Node::Impl::received_broadcast(NodeLink& link, const Package& package) {
  const auto& header = package.header;
  if (!broadcasts.add(std::uint64_t{number(header.source)} << 32 | header.id)) return void(++counters.duplicates);
  const auto from = link.id;
  const bool passes = link.broadcasts.take(scheduler.now(), kMaxBroadcasts, std::chrono::seconds(1));
  if (!passes) dropped(counters.held_broadcasts, "too many broadcasts, not passed on", link, header);
  const bool limit = header.hops >= kMaxHops;
  if (limit) dropped(counters.hop_limit, "it took too many hops", link, header);
  if (!take(link, package) || !passes || limit) return;
  auto next = header;
  ++next.hops;
  Bytes copy;
  append_package(copy, next, package.body);
  flood(copy, from);
}

void Node::Impl::received_direct(NodeLink& link, const Package& package) {
  if (package.header.destination == options.id) {
    take(link, package);
  } else {
    forward(link, package);
  }
}

void Node::Impl::forward(NodeLink& from, const Package& package) {
  auto header = package.header;
  if (header.hops >= kMaxHops) return dropped(counters.hop_limit, "it took too many hops", from, header);
  const auto* route = routes.find(header.destination);
  if (!route) return dropped(counters.no_route, "no route to its destination", from, header);
  if (route->link == from.id) return dropped(counters.loops, "its way leads back", from, header);
  ++header.hops;
  Bytes copy;
  if (auto trace = header.port == Port::kTrace ? read_trace(package.body) : fail(ErrorCode::kInvalid, {})) {
    if (trace->path.size() < kMaxTrace) trace->path.push_back(options.id);
    append_package(copy, header, write(*trace));
  } else {
    append_package(copy, header, package.body);
  }
  if (emit(header.destination, copy, header.port == Port::kAcks) == Emitted::kFull)
    dropped(counters.queue_full, "too much waits for its destination", from, header);
}

/// Whether others should have it too.
bool Node::Impl::take(NodeLink& link, const Package& package) {
  const auto& header = package.header;
  if (header.port == Port::kHello) return take_hello(link, package), true;
  if (!is_of_node(header.port)) return take_message(package), true;
  if (header.fragments > 0) return false;
  if (header.routing == Routing::kDirect && header.wants_ack() && deliveries.is_open(header.source)) {
    deliveries.acknowledge(header.source, header.ack_id);
    if (!deliveries.is_new(header.source, header.ack_id)) return ++counters.duplicates, false;
  }
  return take_node_message(link, package);
}

bool Node::Impl::take_node_message(NodeLink& link, const Package& package) {
  const auto& header = package.header;
  const auto with = [&](const auto& body, auto call) {
    if (body) return call(*body), true;
    ++counters.bad_bodies;
    return log.debug("body", body.error().text), false;
  };
  switch (header.port) {
    case Port::kRouting:
      return header.routing == Routing::kLink && with(read_routing_page(package.body), [&](const RoutingPage& page) {
               if (link.is_route()) return take_routing(link, page);
               if (link.early.size() < kMaxEarlyPages) link.early.push_back(page);
             });
    case Port::kHostInfo:
      return with(read_host_info(package.body), [&](const auto& message) { take_record(link, header, message); });
    case Port::kDeadHost: {
      const auto dead = read_dead_host(package.body);
      return with(dead, [](const DeadHost&) {}) && take_death(header, *dead);
    }
    case Port::kAcks:
      return with(read_acks(package.body), [&](const Acks& acks) { deliveries.acknowledged(header.source, acks); });
    case Port::kQueryHost:
      return with(read_query_host(package.body), [&](const QueryHost& query) { answer_query(query); });
    case Port::kTrace:
      return with(read_trace(package.body), [&](const Trace& trace) { answer_trace(header.source, trace); });
    case Port::kTimeSync:
      ++counters.time_messages;  // anyone may send them; this clock is set by its system only
      return true;
    default: return true;
  }
}

void Node::Impl::take_message(const Package& package) {
  const auto& header = package.header;
  if (!hosts.message(header.source)) return void(++counters.unknown_sources);
  const bool is_request = header.port == Port::kSetRemote || header.port == Port::kSetAppend;
  if (is_request && has_no_place(header.source)) return hold(package);
  if (is_request && is_held(header.source)) release();  // first what came before
  if (header.fragments > 0) {
    auto message = fragments.add(header, package.body);
    if (!message) ++counters.fragments_dropped;
    if (!message && message.error().code == ErrorCode::kBusy) return;
    if (header.wants_ack()) deliveries.acknowledge(header.source, header.ack_id);
    if (message && *message && is_of_tuples(header.port)) calls.message(header.source, header.port, **message);
    return;
  }
  if (header.routing == Routing::kDirect && header.wants_ack()) {
    deliveries.acknowledge(header.source, header.ack_id);
    if (!deliveries.is_new(header.source, header.ack_id)) return void(++counters.duplicates);
  }
  if (is_of_tuples(header.port)) calls.message(header.source, header.port, package.body);
}

/// Also of other starts' magic: a kernel with an old one would never learn the new one.
void Node::Impl::answer_query(const QueryHost& query) {
  if (!is_id(query.asker)) return void(++counters.bad_ids);
  send_direct(query.asker, Port::kHostInfo, write(HostRecordMessage{own_record(), false}));
}

void Node::Impl::answer_trace(OwnerId asker, Trace trace) {
  if (trace.path.size() < kMaxTrace) trace.path.push_back(options.id);
  send_direct(asker, Port::kTraceReply, write(trace));
}

// Sending.

PackageHeader Node::Impl::header_for(Routing routing, Port port, OwnerId destination) {
  PackageHeader header;
  header.id = header.ack_id = deliveries.next_id();
  header.routing = routing;
  header.source = options.id;
  header.destination = destination;
  header.port = port;
  return header;
}

void Node::Impl::send_on(NodeLink& link, Routing routing, Port port, ByteView body) {
  Bytes package;
  append_package(package, header_for(routing, port, kEveryone), body);
  if (!link.connection->send(package, true)) ++counters.queue_full;
}

void Node::Impl::send_direct(OwnerId to, Port port, ByteView body) {
  Bytes package;
  append_package(package, header_for(Routing::kDirect, port, to), body);
  emit(to, package, true);
}

void Node::Impl::flood(ByteView package, std::optional<LinkId> except) {
  for (auto& [id, link] : links) {
    if (id == except || !link.is_route()) continue;
    if (!link.connection->send(package, false)) ++counters.queue_full;
  }
}

Emitted Node::Impl::emit(OwnerId to, std::span<std::uint8_t> package, bool urgent) {
  const auto* route = routes.find(to);
  auto* way = route ? link(route->link) : nullptr;
  if (!way) return Emitted::kNoRoute;
  return way->connection->send(package, urgent) ? Emitted::kSent : Emitted::kFull;
}

}  // namespace rubicon::tuples::peis
