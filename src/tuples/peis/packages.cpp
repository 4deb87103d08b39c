#include "tuples/peis/packages.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

namespace {

constexpr int kMaxBroadcasts = 1000;  ///< of one connection that are passed on, in a second

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

void Packages::received(NodeLink& link, const Package& package) {
  const auto& header = package.header;
  if (!is_sound(link, header)) return;
  if (link.peer == OwnerId{}) {  // we connected, and this is the first that comes
    if (header.routing != Routing::kLink) return;
    if (header.source == context_.options.id || !link.initiated) {
      presence_.take_own_id(package);
      return links_.close(link);
    }
    link.peer = header.source;
  }
  if (header.source == context_.options.id) {
    ++context_.counters.duplicates;
    return presence_.take_own_id(package);
  }
  // Before it counts as received: the true one may come by the way of the host.
  if (forgeries_.is_forged(link, package)) return;
  if (header.routing == Routing::kBroadcast) return received_broadcast(link, package);
  const bool is_direct = header.routing == Routing::kDirect;
  if (is_direct && header.destination != context_.options.id) return forward(link, package);
  if (is_direct || (header.routing == Routing::kLink && header.source == link.peer)) take(link, package);
}

bool Packages::is_sound(const NodeLink& link, const PackageHeader& header) {
  const bool destination = header.routing != Routing::kDirect || is_id(header.destination);
  const bool ids = is_id(header.source) && destination && header.id != 0;
  const bool port = static_cast<std::uint16_t>(header.port) <= kLastPort;
  if (!ids) dropped(context_.counters.bad_ids, "an id out of range", link, header);
  if (ids && !port) dropped(context_.counters.high_ports, "a port above 49, which kills kernels", link, header);
  return ids && port;
}

void Packages::dropped(std::uint64_t& counter, const std::string& what, const NodeLink& from,
                       const PackageHeader& header) {
  ++counter;
  context_.log.info(what, fmt::format("package of component {} by way of {} dropped: {}", number(header.source),
                                      number(from.peer), what));
}

void Packages::received_broadcast(NodeLink& link, const Package& package) {
  const auto& header = package.header;
  if (!broadcasts_.add(std::uint64_t{number(header.source)} << 32 | header.id))
    return void(++context_.counters.duplicates);
  const auto from = link.id;
  const bool passes = link.broadcasts.take(context_.scheduler.now(), kMaxBroadcasts, std::chrono::seconds(1));
  if (!passes) dropped(context_.counters.held_broadcasts, "too many broadcasts, not passed on", link, header);
  const bool limit = header.hops >= kMaxHops;
  if (limit) dropped(context_.counters.hop_limit, "it took too many hops", link, header);
  if (!take(link, package) || !passes || limit) return;
  auto next = header;
  ++next.hops;
  Bytes copy;
  append_package(copy, next, package.body);
  links_.flood(copy, from);
}

void Packages::forward(NodeLink& from, const Package& package) {
  auto header = package.header;
  if (header.hops >= kMaxHops) return dropped(context_.counters.hop_limit, "it took too many hops", from, header);
  const auto* route = routing_.routes().find(header.destination);
  if (!route) return dropped(context_.counters.no_route, "no route to its destination", from, header);
  if (route->link == from.id)
    return dropped(context_.counters.loops, "its route leads back to its sender", from, header);
  ++header.hops;
  Bytes copy;
  if (auto trace = header.port == Port::kTrace ? read_trace(package.body) : fail(ErrorCode::kInvalid, {})) {
    if (trace->path.size() < kMaxTrace) trace->path.push_back(context_.options.id);
    append_package(copy, header, write(*trace));
  } else {
    append_package(copy, header, package.body);
  }
  if (routing_.emit(header.destination, copy, header.port == Port::kAcks) == Emitted::kFull)
    dropped(context_.counters.queue_full, "too much waits for its destination", from, header);
}

/// Whether others should have it too.
bool Packages::take(NodeLink& link, const Package& package) {
  const auto& header = package.header;
  if (header.port == Port::kHello) return presence_.take_hello(link, package), true;
  if (!is_of_node(header.port)) return take_message(package), true;
  if (header.fragments > 0) return false;
  if (header.routing == Routing::kDirect && header.wants_ack() && deliveries_.is_open(header.source)) {
    deliveries_.acknowledge(header.source, header.ack_id);
    if (!deliveries_.is_new(header.source, header.ack_id)) return ++context_.counters.duplicates, false;
  }
  return take_node_message(link, package);
}

bool Packages::take_node_message(NodeLink& link, const Package& package) {
  const auto& header = package.header;
  const auto with = [&](const auto& body, auto call) {
    if (body) return call(*body), true;
    ++context_.counters.bad_bodies;
    return context_.log.debug("body", body.error().text), false;
  };
  switch (header.port) {
    case Port::kRouting:
      return header.routing == Routing::kLink &&
             with(read_routing_page(package.body), [&](const auto& page) { routing_.take(link, page); });
    case Port::kHostInfo:
      return with(read_host_info(package.body),
                  [&](const auto& message) { presence_.take_record(link, header, message); });
    case Port::kDeadHost: {
      const auto dead = read_dead_host(package.body);
      return with(dead, [](const DeadHost&) {}) && presence_.take_death(header, *dead);
    }
    case Port::kAcks:
      return with(read_acks(package.body), [&](const Acks& acks) { deliveries_.acknowledged(header.source, acks); });
    case Port::kQueryHost:
      return with(read_query_host(package.body), [&](const QueryHost& query) { answer_query(query); });
    case Port::kTrace:
      return with(read_trace(package.body), [&](const Trace& trace) { answer_trace(header.source, trace); });
    case Port::kTimeSync:
      ++context_.counters.time_messages;  // anyone may send them; this clock is set by its system only
      return true;
    default: return true;
  }
}

void Packages::take_message(const Package& package) {
  const auto& header = package.header;
  if (!hosts_.message(header.source)) return void(++context_.counters.unknown_sources);
  const bool is_request = header.port == Port::kSetRemote || header.port == Port::kSetAppend;
  if (is_request && places_.is_unknown(header.source)) return places_.hold(package);
  if (is_request && places_.holds_of(header.source)) places_.release();  // first what came before
  if (header.fragments > 0) {
    auto message = fragments_.add(header, package.body);
    if (!message) ++context_.counters.fragments_dropped;
    if (!message && message.error().code == ErrorCode::kBusy) return;
    if (header.wants_ack()) deliveries_.acknowledge(header.source, header.ack_id);
    if (message && *message && is_of_tuples(header.port)) callbacks_.message(header.source, header.port, **message);
    return;
  }
  if (header.routing == Routing::kDirect && header.wants_ack()) {
    deliveries_.acknowledge(header.source, header.ack_id);
    if (!deliveries_.is_new(header.source, header.ack_id)) return void(++context_.counters.duplicates);
  }
  if (is_of_tuples(header.port)) callbacks_.message(header.source, header.port, package.body);
}

/// Also of other starts' magic: a kernel with an old one would never learn the new one.
void Packages::answer_query(const QueryHost& query) {
  if (!is_id(query.asker)) return void(++context_.counters.bad_ids);
  routing_.send(query.asker, Port::kHostInfo, write(HostRecordMessage{presence_.own_record(), false}));
}

void Packages::answer_trace(OwnerId asker, Trace trace) {
  if (trace.path.size() < kMaxTrace) trace.path.push_back(context_.options.id);
  routing_.send(asker, Port::kTraceReply, write(trace));
}

}  // namespace rubicon::tuples::peis
