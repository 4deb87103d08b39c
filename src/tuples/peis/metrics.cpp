#include "tuples/peis/metrics.h"

namespace rubicon::tuples::peis {

void each_counter(const Counters& counters, const CounterVisit& visit) {
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
