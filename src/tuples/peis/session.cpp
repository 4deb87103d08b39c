#include "tuples/peis/session.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::tuples::peis {

void Session::send(Port port, ByteView body, Done done, SteadyTime ends) {
  if (waiting_.empty() && try_send(port, body, done)) return;
  waiting_bytes_ += body.size();
  waiting_.push_back({port, Bytes(body.begin(), body.end()), std::move(done), ends});
}

/// False: no room.
bool Session::try_send(Port port, ByteView body, const Done& done) {
  const auto sent = context_.node->send(peer_, port, body, done);
  if (sent) return true;
  if (sent.error().code == ErrorCode::kBusy) return false;
  context_.log.debug("send", sent.error().text);
  if (done) context_.scheduler.post([done] { done(Outcome::kHostGone); });
  return true;
}

void Session::ready() {
  const auto now = context_.scheduler.now();
  while (!waiting_.empty()) {
    auto& next = waiting_.front();
    const bool limited = next.ends != SteadyTime::max();
    if (limited && next.ends > now) restamp(next.body, next.ends - now);
    const bool is_over = limited && next.ends <= now;
    if (!is_over && !try_send(next.port, next.body, next.done)) return;
    if (is_over && next.done) context_.scheduler.post([done = next.done] { done(Outcome::kNotSent); });
    waiting_bytes_ -= next.body.size();
    waiting_.pop_front();
  }
  send_due();
}

void Session::send_due() {
  while (!is_full() && send_next()) {
  }
}

void Session::restamp(Bytes&, Duration) {}

void Session::deliver(const Change& change) {
  if (context_.listener) context_.listener->on_changes(peer_, {&change, 1});
}

void Session::end_snapshot(std::uint32_t subscription) {
  later([this, subscription] { deliver(SnapshotEnd{subscription}); });
}

void Session::bad(const Error& error) {
  ++context_.counters.bad_messages;
  context_.log.warning("message of " + name(), fmt::format("{}: {}: dropped", name(), error.text));
}

std::string Session::name() const {
  return fmt::format("component {}", number(peer_));
}

void each_counter(const NodeCounters& counters, const CounterVisit& visit) {
  visit("bad-streams", counters.bad_streams);
  visit("foreign-versions", counters.foreign_versions);
  visit("foreign-networks", counters.foreign_networks);
  visit("bad-announcements", counters.bad_announcements);
  visit("bad-bodies", counters.bad_bodies);
  visit("high-ports", counters.high_ports);
  visit("bad-ids", counters.bad_ids);
  visit("hop-limit", counters.hop_limit);
  visit("loops", counters.loops);
  visit("duplicates", counters.duplicates);
  visit("unknown-sources", counters.unknown_sources);
  visit("held-requests", counters.held_requests);
  visit("no-route", counters.no_route);
  visit("queue-full", counters.queue_full);
  visit("forged-deaths", counters.forged_deaths);
  visit("held-deaths", counters.held_deaths);
  visit("forged-hellos", counters.forged_hellos);
  visit("other-starts", counters.other_starts);
  visit("time-messages", counters.time_messages);
  visit("too-many-hosts", counters.too_many_hosts);
  visit("too-many-routes", counters.too_many_routes);
  visit("too-many-links", counters.too_many_links);
  visit("held-broadcasts", counters.held_broadcasts);
  visit("untried-hosts", counters.untried_hosts);
  visit("fragments-dropped", counters.fragments_dropped);
  visit("stuck-links", counters.stuck_links);
  visit("silent-links", counters.silent_links);
  visit("resends", counters.resends);
  visit("given-up", counters.given_up);
  visit("own-id-seen", counters.own_id_seen);
}

void each_counter(const SessionCounters& counters, const CounterVisit& visit) {
  visit("bad-messages", counters.bad_messages);
  visit("foreign-tuples", counters.foreign_tuples);
  visit("refused-keys", counters.refused_keys);
  visit("unknown-keys", counters.unknown_keys);
  visit("refused-patterns", counters.refused_patterns);
  visit("refused-sets", counters.refused_sets);
  visit("ignored-quits", counters.ignored_quits);
  visit("dropped-replies", counters.dropped_replies);
  visit("copies-not-kept", counters.copies_not_kept);
  visit("lost-pushes", counters.lost_pushes);
}

}  // namespace rubicon::tuples::peis
