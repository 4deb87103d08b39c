#include "tuples/peis/node_presence.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

namespace rubicon::tuples::peis {

namespace {

constexpr std::size_t kMaxTakenMagics = 16;
constexpr Duration kForgottenPause = std::chrono::seconds(10);  ///< sending all again costs much

/// Nullopt: no IPv4 address.
std::optional<std::array<std::uint8_t, 4>> parse_ip(const std::string& text) {
  std::array<unsigned, 4> parts{};
  char rest = 0;
  if (std::sscanf(text.c_str(), "%3u.%3u.%3u.%3u%c", &parts[0], &parts[1], &parts[2], &parts[3], &rest) != 4)
    return std::nullopt;
  std::array<std::uint8_t, 4> ip{};
  for (std::size_t i = 0; i < ip.size(); ++i) {
    if (parts[i] > 255) return std::nullopt;
    ip[i] = static_cast<std::uint8_t>(parts[i]);
  }
  return ip;
}

}  // namespace

NodePresence::NodePresence(NodeContext& context, const NodeCallbacks& calls, Hosts& hosts, NodeLinks& links,
                           NodeRouting& routing, Deliveries& deliveries, Dialer& dialer, Places& places,
                           Forgeries& forgeries)
    : context_(context),
      callbacks_(calls),
      hosts_(hosts),
      links_(links),
      routing_(routing),
      deliveries_(deliveries),
      dialer_(dialer),
      places_(places),
      forgeries_(forgeries),
      id_check_(context.scheduler, context.transports, {context.options.id, 0, context.options.network},
                [this](const Identity& other) { id_taken(other); }) {}

void NodePresence::begin() {
  if (!context_.options.multicast) return;
  Announcer::Callbacks calls{[this] { return own_record(); }, [this](const HostRecord& record) { announced(record); },
                             [this](TroubleKind kind, OwnerId id, std::string_view name, std::string_view detail) {
                               context_.troubles.note(kind, id, name, detail);
                             }};
  announcer_ = std::make_unique<Announcer>(context_.scheduler, context_.transports,
                                           Announcer::Where{context_.options.network, context_.options.interfaces},
                                           context_.counters, context_.log, std::move(calls));
}

void NodePresence::greet(NodeLink& link) {
  const auto record = write(HostRecordMessage{own_record(), false});
  links_.send(link, Routing::kLink, Port::kHostInfo, record);
  routing_.tell(link);
  links_.send(link, Routing::kBroadcast, Port::kHostInfo, record);
}

HostRecord NodePresence::own_record() const {
  HostRecord record;
  record.id = context_.options.id;
  record.magic = context_.options.magic;
  record.host_name = context_.options.host_name;
  record.full_name = context_.options.full_name;
  record.cluster = routing_.routes().cluster();
  for (const auto& interface : context_.options.interfaces) {
    const auto ip = parse_ip(interface.address);
    if (!ip) continue;
    record.addresses.push_back(
        {interface.name.substr(0, 8), interface.is_loopback, AddressType::kTcp4, *ip, links_.local().port});
  }
  return record;
}

/// The peer sent its host record: the link becomes a route.
void NodePresence::meet(NodeLink& met, const HostRecord& record) {
  if (met.is_route()) {
    if (met.magic != record.magic) return links_.close(met);
    return void(hosts_.learn(record, RecordSource::kOwnLink));
  }
  if (!links_.has_room_for(met, record.id)) {
    ++context_.counters.too_many_links;
    context_.log.warning("links", fmt::format("component {}: refused, too many connections", number(record.id)));
    return links_.close(met);
  }
  if (!hosts_.learn(record, RecordSource::kOwnLink)) {
    context_.log.info(
        fmt::format("over {}", number(record.id)),
        fmt::format("component {}: refused, another start of it came later, or too many hosts", number(record.id)));
    if (hosts_.is_over(record.id, record.magic))
      context_.troubles.note(TroubleKind::kSharedId, record.id, record.full_name, "it connected after another start");
    return links_.close(met);
  }
  context_.troubles.reached(record.id, links_.address_of(met.target));
  dialer_.connected(met.target, record.id);
  links_.close_former(record.id, record.magic);
  met.magic = record.magic;
  widen_links(record.id);
  routing_.open(met, record);
  links_.close_duplicates(record.id);
  places_.met(record.id);
}

void NodePresence::widen_links(OwnerId peer) {
  if (const auto lease = hosts_.lease(peer)) links_.widen(peer, *lease);
}

void NodePresence::unlinked(const NodeLink& link, SteadyTime heard, bool broken) {
  if (link.initiated) dialer_.ended(link.target, link.is_route());
  if (!link.is_route()) return;
  routing_.close(link, heard);
  if (broken && link.target.configured < 0 && !links_.is_linked(link.peer)) dialer_.again(link.peer, link.initiated);
}

void NodePresence::announced(const HostRecord& record) {
  if (record.id == context_.options.id) {
    if (record.magic != context_.options.magic) id_claimed(record);
    return;
  }
  const auto id = number(record.id);
  if (id == 0 || id > kMaxId) return void(++context_.counters.bad_ids);
  // Only programs that run announce themselves.
  if (hosts_.is_over(record.id, record.magic))
    context_.troubles.note(TroubleKind::kSharedId, record.id, record.full_name,
                           "it announces itself after another start");
  is_other_start(record, "an announcement");
  if (!hosts_.learn(record, RecordSource::kAnnounced) || routing_.routes().find(record.id)) return;
  const auto own = routing_.routes().cluster();
  // It cannot hear a component that leaves announcing to a kernel: by way of kernels the route here takes up to 10 s.
  const bool is_ours_to_connect = record.cluster <= own || !announcer_->is_active();
  dialer_.meet(record.id, is_ours_to_connect, announcer_->is_active() || routing_.routes().all().empty());
  if (record.cluster != own) announcer_->announce();
}

void NodePresence::take_own_id(const Package& package) {
  if (package.header.port != Port::kHostInfo) return;
  const auto claim = read_host_info(package.body);
  if (claim && claim->host.id == context_.options.id && claim->host.magic != context_.options.magic)
    id_claimed(claim->host);
}

/// Anyone may say so: the other one is asked.
void NodePresence::id_claimed(const HostRecord& record) {
  ++context_.counters.own_id_seen;
  context_.troubles.note(TroubleKind::kOwnId, record.id, record.full_name, {});
  if (taken_magics_.contains(record.magic)) return;
  context_.log.info("own id", fmt::format("{} says that it has the id {} of this component: asked", record.full_name,
                                          number(record.id)));
  id_check_.ask({record.id, record.magic, record.host_name, record.full_name, std::nullopt},
                dialer_.addresses_of(&record));
}

void NodePresence::id_taken(const Identity& other) {
  if (taken_magics_.size() >= kMaxTakenMagics || !taken_magics_.insert(other.magic).second) return;
  context_.log.unlimited().warning(
      fmt::format("another component uses the id {} of this one: {}", number(other.id), other.full_name));
  context_.troubles.note(TroubleKind::kOwnId, other.id, other.full_name, {});
  callbacks_.id_taken(other);
}

void NodePresence::happened(HostEvent event, const Identity& host) {
  if (event == HostEvent::kBack) deliveries_.send_again(host.id);
  callbacks_.host(event, host);
  // Its hello was lost and sent again. So what it sent before the hello was taken for messages of a kernel.
  if (event == HostEvent::kHello) returned(host);
}

/// The hello is the first message that it gets.
void NodePresence::welcome(OwnerId host) {
  deliveries_.open(host, hosts_.is_ours(host));
  const auto sent = deliveries_.send(host, Port::kHello, encode(context_.options.hello), {});
  if (!sent) context_.log.debug("hello", sent.error().text);
  // A kernel on the way lets others know this one only with its next routing, up to 10 s later.
  const auto* route = routing_.routes().find(host);
  if (route && !route->direct && !hosts_.is_ours(route->via)) dialer_.prefer_direct(host);
}

/// This node had deleted the host's subscriptions. One of ours is asked to send them again; a kernel does so when it
/// meets a host that had left.
void NodePresence::returned(const Identity& host) {
  const auto tell = [&](const DeadHost& dead) {
    const auto sent = deliveries_.send(host.id, Port::kDeadHost, write(dead), {});
    if (!sent) context_.log.debug("returned", sent.error().text);
  };
  if (host.hello) return tell({host.id, DeathReason::kReborn});
  const auto* route = routing_.routes().find(host.id);
  if (!route || !route->direct) return tell({context_.options.id, DeathReason::kLost});
  routing_.send(host.id, Port::kDeadHost, write(DeadHost{context_.options.id, DeathReason::kLost}));
  links_.close_all(host.id);
  dialer_.again(host.id, true);
}

void NodePresence::leave_host(OwnerId host) {
  hosts_.left(host);
  dialer_.forget(host);
  routing_.forget(host);
  links_.close_all(host);
}

/// An empty one is a sign of life.
void NodePresence::take_hello(NodeLink& link, const Package& package) {
  const auto& header = package.header;
  if (header.routing != Routing::kDirect || package.body.empty()) return;
  const auto hello = decode_hello(package.body);
  if (!hello) return void(++context_.counters.bad_bodies);
  const auto from = header.source;
  const auto* route = routing_.routes().find(from);
  if (!route) return;  // nothing shows who sent it; hello is sent again
  const auto other = route->link == link.id ? HelloWay::kRoute : HelloWay::kAny;
  const auto way = link.peer == from ? HelloWay::kOwnLink : other;
  if (!hosts_.may_be_hello(from, *hello, way))
    return forgeries_.refuse(context_.counters.forged_hellos, link, from, "another hello");
  deliveries_.widen(from);
  hosts_.hello(from, *hello, way);
  if (!deliveries_.is_open(from)) return;  // its record has not come; hello is sent again
  deliveries_.acknowledge(from, header.ack_id);
  widen_links(from);  // also if hello took another way, which it was sent on before there was a direct one
  links_.close_duplicates(from);
}

void NodePresence::take_record(NodeLink& link, const PackageHeader& header, const HostRecordMessage& message) {
  const auto& record = message.host;
  if (record.id == context_.options.id || !is_id(record.id)) {
    if (record.magic != context_.options.magic) ++context_.counters.own_id_seen;
    return;
  }
  const bool by_itself = header.source == record.id && !message.cached;
  if (by_itself && header.routing == Routing::kLink) return meet(link, record);
  const auto source = source_of(link, header, message);
  const bool asks = by_itself && source != RecordSource::kItself &&
                    is_other_start(record, fmt::format("component {}", number(link.peer)));
  if (!hosts_.learn(record, source)) return;
  if (by_itself && link.is_route()) take_newcomer(link, header, record);
  if (asks) dialer_.prefer_direct(record.id);
}

/// A kernel that joined by way of another speaks before the next routing of that, up to 10 s later. Any host behind the
/// neighbour can say so in the name of another: it ends no start that is up or may come back.
void NodePresence::take_newcomer(const NodeLink& link, const PackageHeader& header, const HostRecord& record) {
  const auto* present = hosts_.find(record.id);
  if (present && present->magic != record.magic) return;
  routing_.hear(link, record, header.hops - 1);
}

RecordSource NodePresence::source_of(const NodeLink& link, const PackageHeader& header,
                                     const HostRecordMessage& message) const {
  const auto* route = routing_.routes().find(message.host.id);
  if (header.source != message.host.id || message.cached || (route && route->direct)) return RecordSource::kOther;
  return route && route->link == link.id ? RecordSource::kItself : RecordSource::kAnnounced;
}

/// Whether it is another start of a host that is up. Only the host itself shows that it restarted: on a connection.
bool NodePresence::is_other_start(const HostRecord& record, std::string_view from) {
  const auto* present = hosts_.find(record.id);
  if (!present || present->magic == record.magic) return false;
  ++context_.counters.other_starts;
  context_.log.warning("other start",
                       fmt::format("{} says that component {} has started again, but it is up: not believed "
                                   "before that start has connected",
                                   from, number(record.id)));
  return true;
}

/// Only the host itself declares itself dead, and only on the way that leads to it. Whether others should have it.
bool NodePresence::take_death(const PackageHeader& header, const DeadHost& dead) {
  const auto from = header.source;
  if (dead.id == context_.options.id) {
    if (dead.reason != DeathReason::kMessage) forgotten_by(from);
    return false;
  }
  if (from != dead.id || dead.reason != DeathReason::kLost) return ++context_.counters.forged_deaths, false;
  if (routing_.routes().find(dead.id)) leave_host(dead.id);
  return true;
}

/// The host gets all once more: at most once in kForgottenPause.
void NodePresence::forgotten_by(OwnerId host) {
  if (!hosts_.find(host)) return void(++context_.counters.unknown_sources);
  auto& [not_before, timer] = forgetful_[host];
  const auto now = context_.scheduler.now();
  if (timer.pending() || now < not_before) {
    ++context_.counters.held_deaths;
    context_.log.info("forgotten",
                      fmt::format("component {} declares this one dead again within {} s: it gets all again "
                                  "only then",
                                  number(host), kForgottenPause / std::chrono::seconds(1)));
  }
  if (timer.pending()) return;
  timer = context_.scheduler.at(std::max(now, not_before), [this, host] {
    const auto* present = hosts_.find(host);
    if (!present) return;
    forgetful_[host].not_before = context_.scheduler.now() + kForgottenPause;
    happened(HostEvent::kForgot, Identity(*present));
  });
}

}  // namespace rubicon::tuples::peis
