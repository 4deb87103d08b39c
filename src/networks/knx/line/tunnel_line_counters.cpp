#include "networks/knx/line/tunnel_line.h"

// The counters of a tunnel line.

namespace rubicon::networks::knx::line {

namespace {

std::uint64_t seconds_of(WallTime time) {
  return static_cast<std::uint64_t>(std::chrono::ceil<std::chrono::seconds>(time.time_since_epoch()).count());
}

}  // namespace

std::map<std::string, std::uint64_t> TunnelLine::counters() const {
  const auto& tunnel = tunnel_counters_;
  const auto& outbox = outbox_.counters();
  std::map<std::string, std::uint64_t> all{{"telegrams-sent", counters_.sent},
                                           {"telegrams-received", counters_.received},
                                           {"telegrams-waiting", outbox_.waiting()},
                                           {"telegrams-refused", outbox.refused + tunnel.not_understood},
                                           {"telegrams-expired", outbox.expired},
                                           {"telegrams-lost", outbox.lost},
                                           {"repeats", tunnel.repeats},
                                           {"missing-acks", tunnel.missing_acks},
                                           {"unconfirmed", tunnel.unconfirmed},
                                           {"not-acknowledged", tunnel.not_acknowledged},
                                           {"late-confirmations", tunnel.late_confirmations},
                                           {"attempts", counters_.attempts},
                                           {"next-attempt", retry_timer_.pending() ? seconds_of(next_attempt_) : 0},
                                           {"reconnects", counters_.connects > 0 ? counters_.connects - 1 : 0},
                                           {"missing-heartbeats", tunnel.missing_heartbeats},
                                           {"duplicates", tunnel.duplicates},
                                           {"wrong-sequence", tunnel.wrong_sequence},
                                           {"wrong-channel", tunnel.wrong_channel},
                                           {"wrong-source", counters_.other_source},
                                           {"bad-frames", tunnel.bad_frames},
                                           {"unknown-services", tunnel.unknown_services},
                                           {"undelivered", counters_.undelivered},
                                           {"lte-frames", counters_.lte},
                                           {"other-frames", counters_.other_frames},
                                           {"doubled-address", counters_.duplicate_address},
                                           {"other-tunnel-address", counters_.other_address}};
  if (options_.secure) add_session_counters(all);
  if (options_.guard != nullptr) all.merge(options_.guard->counters());
  return all;
}

void TunnelLine::add_session_counters(std::map<std::string, std::uint64_t>& all) const {
  const auto& session = session_counters_;
  all["bad-frames"] += session.bad_frames;
  all.insert({{"secure-sessions", session.sessions},
              {"secure-unverified", session.unverified},
              {"secure-plain-frames", session.plain_frames},
              {"secure-early-frames", session.early_frames},
              {"secure-wrong-mac", session.wrong_mac},
              {"secure-replays", session.replays},
              {"secure-other-sessions", session.other_sessions},
              {"secure-forbidden-frames", session.forbidden_frames}});
}

}  // namespace rubicon::networks::knx::line
