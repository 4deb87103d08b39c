#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tuples/peis/node_impl.h"

namespace rubicon::tuples::peis {

namespace {

std::string refusal(const NodeLink& link, OwnerId source, std::string_view what) {
  return fmt::format("{} of component {} came from component {} at {}, which cannot say this: ignored", what,
                     number(source), number(link.peer), transport::to_string(link.connection->remote()));
}

}  // namespace

/// A neighbour says what it is on its own connection. Of a host further away, who is on the way can say anything, and
/// the ways there and back may differ.
bool Node::Impl::speaks_for(const NodeLink& link, OwnerId source) const {
  if (link.peer == source) return link.is_route();
  const auto* route = routes.find(source);
  return !route || !route->direct;
}

bool Node::Impl::is_forged(const NodeLink& link, const Package& package) {
  const auto& header = package.header;
  if (header.routing == Routing::kLink) return false;
  if (header.routing == Routing::kDirect && header.destination != options.id) return false;
  if (header.port == Port::kDeadHost) return is_forged_death(link, package);
  if (header.port != Port::kHello || package.body.empty() || speaks_for(link, header.source)) return false;
  // Not acknowledged: the true one is sent again, on the connection that there is by now.
  doubt(counters.forged_hellos, link, header.source, "hello",
        [this, source = header.source, hello = decode_hello(package.body)] {
          const auto* host = hosts.find(source);
          return !host || (hello && host->hello == *hello);
        });
  return true;
}

bool Node::Impl::is_forged_death(const NodeLink& link, const Package& package) {
  const auto source = package.header.source;
  const auto dead = read_dead_host(package.body);
  if (!dead) return false;
  const auto* route = routes.find(source);
  const bool is_by_its_way = link.peer == source || !route || route->link == link.id;
  const bool may = dead->id == options.id || (dead->id == source && is_by_its_way);
  if (may && speaks_for(link, source)) return false;
  const auto* host = hosts.find(source);
  if (dead->id != source) return refuse(counters.forged_deaths, link, source, "DEAD_HOST"), true;
  if (!host) return true;  // it has left
  // A neighbour may pass on the goodbye before the host's own copy comes.
  doubt(counters.forged_deaths, link, source, "DEAD_HOST", [this, source, magic = host->magic] {
    const auto* present = hosts.find(source);
    return !present || present->magic != magic;
  });
  return true;
}

void Node::Impl::refuse(std::uint64_t& counter, const NodeLink& link, OwnerId source, std::string_view what) {
  ++counter;
  log.warning(fmt::format("refused {}", what), refusal(link, source, what));
}

void Node::Impl::doubt(std::uint64_t& counter, const NodeLink& link, OwnerId source, std::string_view what,
                       std::function<bool()> is_true) {
  if (doubts.size() >= kMaxDoubts) return refuse(counter, link, source, what);
  const auto text = refusal(link, source, what);
  doubts.push_back({scheduler.now() + kProofTime, std::move(is_true), [this, &counter, text, name = std::string(what)] {
                      ++counter;
                      log.warning("refused " + name, text);
                    }});
  if (doubts.size() == 1) proofs = scheduler.at(doubts.front().due, [this] { judge_doubts(); });
}

void Node::Impl::judge_doubts() {
  for (; !doubts.empty() && doubts.front().due <= scheduler.now(); doubts.pop_front()) {
    if (!doubts.front().is_true()) doubts.front().refuse();
  }
  if (!doubts.empty()) proofs = scheduler.at(doubts.front().due, [this] { judge_doubts(); });
}

/// An empty one is a sign of life.
void Node::Impl::take_hello(NodeLink& link, const Package& package) {
  const auto& header = package.header;
  if (header.routing != Routing::kDirect || package.body.empty()) return;
  const auto hello = decode_hello(package.body);
  if (!hello) return void(++counters.bad_bodies);
  const auto from = header.source;
  const auto* route = routes.find(from);
  if (!route) return;  // nothing shows who sent it; hello is sent again
  const auto other = route->link == link.id ? HelloWay::kRoute : HelloWay::kAny;
  const auto way = link.peer == from ? HelloWay::kOwnLink : other;
  if (!hosts.may_be_hello(from, *hello, way)) return refuse(counters.forged_hellos, link, from, "another hello");
  deliveries.widen(from);
  hosts.hello(from, *hello, way);
  if (!deliveries.is_open(from)) return;  // its record has not come; hello is sent again
  deliveries.acknowledge(from, header.ack_id);
  widen_links(from);  // also if hello took another way, which it was sent on before there was a direct one
  drop_duplicates(from);
}

void Node::Impl::take_record(NodeLink& link, const PackageHeader& header, const HostRecordMessage& message) {
  const auto& record = message.host;
  if (record.id == options.id || !is_id(record.id)) {
    if (record.magic != options.magic) ++counters.own_id_seen;
    return;
  }
  const bool by_itself = header.source == record.id && !message.cached;
  if (by_itself && header.routing == Routing::kLink) return meet(link, record);
  const auto source = source_of(link, header, message);
  const bool asks = by_itself && source != RecordSource::kItself &&
                    is_other_start(record, fmt::format("component {}", number(link.peer)));
  if (!hosts.learn(record, source)) return;
  if (by_itself && link.is_route()) take_newcomer(link, header, record);
  if (asks) dialer.prefer_direct(record.id);
}

/// A kernel that joined by way of another speaks before the next routing of that, up to 10 s later. Any host behind the
/// neighbour can say so in the name of another: it ends no start that is up or may come back.
void Node::Impl::take_newcomer(const NodeLink& link, const PackageHeader& header, const HostRecord& record) {
  const auto* present = hosts.find(record.id);
  if (present && present->magic != record.magic) return;
  for (const auto host : routes.hear(link.id, record.id, record.magic, header.hops - 1, scheduler.now()).found)
    hosts.routable(host, record.magic, false);
}

RecordSource Node::Impl::source_of(const NodeLink& link, const PackageHeader& header,
                                   const HostRecordMessage& message) const {
  const auto* route = routes.find(message.host.id);
  if (header.source != message.host.id || message.cached || (route && route->direct)) return RecordSource::kOther;
  return route && route->link == link.id ? RecordSource::kItself : RecordSource::kAnnounced;
}

/// Whether it is another start of a host that is up. Only the host itself shows that it restarted: on a connection.
bool Node::Impl::is_other_start(const HostRecord& record, std::string_view from) {
  const auto* present = hosts.find(record.id);
  if (!present || present->magic == record.magic) return false;
  ++counters.other_starts;
  log.warning("other start", fmt::format("{} says that component {} has started again, but it is up: not believed "
                                         "before that start has connected",
                                         from, number(record.id)));
  return true;
}

/// Only the host itself declares itself dead, and only on the way that leads to it. Whether others should have it.
bool Node::Impl::take_death(const PackageHeader& header, const DeadHost& dead) {
  const auto from = header.source;
  if (dead.id == options.id) {
    if (dead.reason != DeathReason::kMessage) forgotten_by(from);
    return false;
  }
  if (from != dead.id || dead.reason != DeathReason::kLost) return ++counters.forged_deaths, false;
  if (routes.find(dead.id)) leave_host(dead.id);
  return true;
}

/// The host gets all once more: at most once in kForgottenPause.
void Node::Impl::forgotten_by(OwnerId host) {
  if (!hosts.find(host)) return void(++counters.unknown_sources);
  auto& [not_before, timer] = forgetful[host];
  const auto now = scheduler.now();
  if (timer.pending() || now < not_before) {
    ++counters.held_deaths;
    log.info("forgotten", fmt::format("component {} declares this one dead again within {} s: it gets all again "
                                      "only then",
                                      number(host), kForgottenPause / std::chrono::seconds(1)));
  }
  if (timer.pending()) return;
  timer = scheduler.at(std::max(now, not_before), [this, host] {
    const auto* present = hosts.find(host);
    if (!present) return;
    forgetful[host].not_before = scheduler.now() + kForgottenPause;
    happened(HostEvent::kForgot, Identity(*present));
  });
}

}  // namespace rubicon::tuples::peis
