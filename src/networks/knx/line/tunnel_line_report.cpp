#include <fmt/format.h>

#include "model/findings.h"
#include "networks/knx/line/tunnel_line.h"

// What a tunnel line tells of itself: why a tunnel ended, and its counters.

namespace rubicon::networks::knx::line {

namespace {

std::uint64_t seconds_of(WallTime time) {
  return static_cast<std::uint64_t>(std::chrono::ceil<std::chrono::seconds>(time.time_since_epoch()).count());
}

}  // namespace

/// Adds possible causes where the server did not answer.
std::string TunnelLine::reason_for(const Tunnel::End& end) const {
  const bool silence = end.cause == Tunnel::Cause::kNoAnswer || end.cause == Tunnel::Cause::kSilent;
  auto why = end.why;
  if (silence && !sockets_.send_error().empty()) why += fmt::format(" ({})", sockets_.send_error());
  if (end.cause == Tunnel::Cause::kNoAnswer && !sockets_.stranger().empty())
    why += fmt::format("; {} sent a datagram instead (wrong-source)", sockets_.stranger());
  return why;
}

/// A session that ended is the reason why its tunnel did.
std::string_view TunnelLine::finding_of(const Tunnel::End& end) const {
  if (session_end_) return session_end_->finding();
  if (end.cause != Tunnel::Cause::kRefused) return {};
  if (end.status == wire::status::kConnectionType) return model::findings::kConnectionType;
  const bool lacks_tunnel = end.status == wire::status::kUnauthorised && options_.secure;
  return lacks_tunnel ? model::findings::kUserWithoutTunnel : std::string_view();
}

/// Adds what helps against it, as far as we know.
void TunnelLine::explain_refusal(Tunnel::End& end) {
  const bool route_back_before = std::exchange(route_back_, route_back_ || (retired_ && retired_->route_back_works()));
  if (end.cause != Tunnel::Cause::kRefused) return;
  if (!route_back_before && route_back_ && wire::meaning_of(end.status).remedy == wire::Remedy::kWaitForSlot)
    end.why += "; our first request may occupy one for two minutes, because its answer did not reach us (NAT)";
  if (end.status == wire::status::kConnectionType && !options_.secure)
    end.why += "; if it does, configure `keyring: FILE.knxkeys` of the ETS project and `via: tunnel-tcp`";
  if (end.status == wire::status::kUnauthorised && options_.secure)
    end.why += fmt::format("; user {} has no tunnel there", options_.secure->user);
}

std::map<std::string, std::uint64_t> TunnelLine::counters() const {
  const auto& tunnel = tunnel_counters_;
  const auto& telegrams = telegrams_.counters();
  std::map<std::string, std::uint64_t> all{{"telegrams-sent", counters_.sent},
                                           {"telegrams-received", counters_.received},
                                           {"telegrams-waiting", telegrams_.waiting()},
                                           {"telegrams-refused", telegrams.refused + tunnel.not_understood},
                                           {"telegrams-expired", telegrams.expired},
                                           {"telegrams-lost", telegrams.lost},
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
