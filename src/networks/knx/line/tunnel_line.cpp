#include "networks/knx/line/tunnel_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "networks/knx/wire/cemi.h"

namespace rubicon::networks::knx::line {

namespace {

using Phase = LineState::Phase;

constexpr unsigned kSilentBus = 3;  ///< consecutive telegrams without a confirmation
constexpr std::string_view kBusSilent = "the bus is silent: three telegrams in a row were not confirmed";
constexpr const char* kOtherAddress = "other-tunnel-address";
/// Over TCP there are no acks, so that a silent bus looks like an interface that does not work.
constexpr std::string_view kInterfaceSilent = "the interface did not confirm three telegrams in a row";

struct Report {
  SendOutcome sent;
  std::string_view why;
};

/// Over TCP there is no ack which shows that the interface accepted the telegram.
Report report_of(Tunnel::Outcome outcome, bool over_tcp) {
  switch (outcome) {
    case Tunnel::Outcome::kNotAcknowledged:
      return {SendOutcome::kNotAcknowledged, "no device on the bus acknowledged it"};
    case Tunnel::Outcome::kUnconfirmed:
      return {SendOutcome::kUnconfirmed,
              over_tcp ? "the interface did not confirm that it was sent to the bus"
                       : "the interface accepted it, but did not confirm that it was sent to the bus"};
    case Tunnel::Outcome::kNotUnderstood:
      return {SendOutcome::kRefused, "the interface did not understand it (status 29)"};
    case Tunnel::Outcome::kConfirmed: break;
  }
  return {SendOutcome::kSent, {}};
}

}  // namespace

TunnelLine::TunnelLine(TunnelOptions options, Scheduler& scheduler, transport::Transports& transports,
                       LineCallbacks callbacks)
    : options_(std::move(options)),
      scheduler_(scheduler),
      transports_(transports),
      callbacks_(std::move(callbacks)),
      route_back_(options_.nat == TunnelOptions::Nat::kOn),
      sockets_({over_tcp(), options_.local_port}, transports, socket_callbacks()),
      hold_off_(static_cast<std::uint64_t>(scheduler.wall_now().time_since_epoch().count()) ^
                std::hash<std::string>{}(options_.host)),
      telegrams_(scheduler, options_.limits, [this] { pump(); }) {
  state_.server = options_.host;
}

TunnelLine::~TunnelLine() {
  lifetime_.end();
  if (tunnel_) tunnel_->close();
  if (session_) session_->close();
}

Result<void> TunnelLine::open() {
  if (state_.phase != Phase::kOff) return {};
  if (auto tried = sockets_.try_open(); !tried) return tried;
  state_.phase = Phase::kResolving;
  lookup_ = transports_.look_up(options_.host, [this](auto addresses) { resolved(std::move(addresses)); });
  return {};
}

void TunnelLine::resolved(Result<std::vector<std::string>> addresses) {
  const auto lookup = std::move(lookup_);  // destroyed at the end: this is its callback
  if (!addresses) return fail_line(addresses.error());
  const auto four = std::find_if(addresses->begin(), addresses->end(), is_ipv4);
  if (four == addresses->end())
    return fail_line({ErrorCode::kUnreachable, fmt::format("{} has no IPv4 address", options_.host)});
  const transport::Endpoint control{*four, options_.port};
  state_.server = fmt::format("{} ({})", options_.host, to_string(control));
  if (auto opened = sockets_.open(control, !over_tcp() && !route_back_); !opened) return fail_line(opened.error());
  connect();
}

void TunnelLine::connect() {
  session_end_.reset();
  if (options_.secure) {
    make_session();
  } else {
    make_tunnel(sockets_.own());
  }
  const auto watch = lifetime_.watch();
  set_state(Phase::kConnecting, {});
  if (!watch.ended() && !over_tcp()) begin();
}

void TunnelLine::begin() {
  if (session_) return session_->start();
  if (tunnel_) tunnel_->connect();
}

void TunnelLine::make_session() {
  secure::Session::Callbacks calls;
  calls.transmit = [this](ByteView frame) { put(path_, frame); };
  calls.up = [this] { session_up(); };
  calls.received = [this](ByteView frame) {
    if (tunnel_) tunnel_->receive(frame);
  };
  if (callbacks_.note) calls.note = callbacks_.note;
  calls.ended = [this](secure::Session::End end) { session_ended(std::move(end)); };
  secure::Session::Settings settings;
  settings.repeats = !over_tcp();
  settings.own = sockets_.own();
  settings.tries_route_back = tries_route_back();
  settings.password_form = password_form_;
  session_ = std::make_unique<secure::Session>(scheduler_, *options_.secure, std::move(settings), session_counters_,
                                               std::move(calls));
}

void TunnelLine::make_tunnel(const wire::Hpai& own) {
  Tunnel::Callbacks calls;
  calls.transmit = [this](Tunnel::Path path, ByteView frame) { transmit(path, frame); };
  calls.up = [this] { up(); };
  calls.received = [this](ByteView cemi, std::optional<Tunnel::Outcome> outcome) { received_cemi(cemi, outcome); };
  calls.finished = [this](Tunnel::Outcome outcome) { finish(outcome); };
  calls.bus = [this](bool connected) {
    set_bus(connected, connected ? std::string_view() : wire::meaning_of(wire::status::kBusDown).meaning);
  };
  calls.max_apdu = [this](std::optional<std::uint16_t> bytes) {
    max_apdu_ = bytes;
    pump();
  };
  if (callbacks_.note) calls.note = callbacks_.note;
  calls.ended = [this](Tunnel::End end) { ended(std::move(end)); };
  const bool asks = options_.guard != nullptr && (over_tcp() || !options_.secure);  // searches are outside of sessions
  const Tunnel::Settings settings{over_tcp(), own, tries_route_back(), options_.wanted, asks};
  tunnel_ = std::make_unique<Tunnel>(scheduler_, settings, tunnel_counters_, std::move(calls));
}

// Callbacks of the sockets.

TunnelSockets::Callbacks TunnelLine::socket_callbacks() {
  TunnelSockets::Callbacks calls;
  calls.connected = [this] { begin(); };
  calls.received = [this](ByteView frame) { received(frame); };
  calls.stranger = [this] { stranger(); };
  calls.undelivered = [this] {
    // Without a tunnel nothing is lost: the attempts to connect are counted.
    if (state_.phase == Phase::kUp) ++counters_.undelivered;
    if (tunnel_) return tunnel_->undelivered();
    if (session_) session_ended({secure::Session::Cause::kNoAnswer, 0, "no program listens on that port"});
  };
  calls.failed = [this](const Error& error) { sockets_failed(error); };
  return calls;
}

void TunnelLine::received(ByteView frame) {
  if (session_) return session_->receive(frame);
  if (tunnel_) tunnel_->receive(frame);
}

void TunnelLine::stranger() {
  ++counters_.other_source;
  note("wrong-source", fmt::format("{} sends to this tunnel, but is not the interface {}: ignored", sockets_.stranger(),
                                   transport::to_string(sockets_.control_endpoint())));
}

void TunnelLine::sockets_failed(const Error& error) {
  const auto watch = lifetime_.watch();
  if (error.code == ErrorCode::kInvalid) {
    ++tunnel_counters_.bad_frames;
    note("bad-frames", error.text);
    if (watch.ended()) return;
  }
  if (tunnel_) return tunnel_->lost(error.text);
  if (session_) ended({Tunnel::Cause::kUnreachable, 0, error.text, {}});
}

void TunnelLine::transmit(Tunnel::Path path, ByteView frame) {
  if (!session_) return put(path, frame);
  path_ = path;
  if (session_->up()) session_->send(frame);
  path_ = Tunnel::Path::kControl;
}

/// The sender may still need the tunnel. It ends in a turn of its own.
void TunnelLine::put(Tunnel::Path path, ByteView frame) {
  if (sockets_.send(path, frame) || send_failure_.pending()) return;
  send_failure_ = scheduler_.after(Duration::zero(), [this] {
    sockets_failed({ErrorCode::kUnreachable, sockets_.send_error()});
  });
}

// Callbacks of the session.

void TunnelLine::session_up() {
  refused_forms_ = 0;
  const auto watch = lifetime_.watch();
  if (password_form_ != 0)
    note("secure-sessions",
         "the interface takes the password with `?` for letters beyond ASCII: choose a password without such "
         "letters");
  if (watch.ended()) return;
  if (!session_->verified())
    note("secure-unverified",
         "the interface is not verified: the configuration has no device password (authentication code)");
  if (watch.ended()) return;
  make_tunnel(session_->own());
  tunnel_->connect();
}

void TunnelLine::session_ended(secure::Session::End end) {
  session_end_ = std::move(end);
  auto why = session_end_->why;
  if (tunnel_) return tunnel_->lost(std::move(why));
  const bool silent = session_end_->cause == secure::Session::Cause::kNoAnswer;
  ended({silent ? Tunnel::Cause::kNoAnswer : Tunnel::Cause::kUnreachable, 0, std::move(why), {}});
}

void TunnelLine::note(const std::string& subject, std::string_view text) {
  if (callbacks_.note) callbacks_.note(subject, text);
}

// Callbacks of the tunnel.

void TunnelLine::up() {
  ++counters_.connects;
  up_since_ = scheduler_.now();
  unconfirmed_in_row_ = 0;
  hold_off_.connected();
  route_back_ = route_back_ || tunnel_->route_back_works();
  sockets_.set_data_endpoint(tunnel_->data_endpoint());
  state_.own = tunnel_->address();
  state_.bus = true;
  const auto watch = lifetime_.watch();
  set_state(Phase::kUp, {});
  if (!watch.ended()) compare_address();
  if (!watch.ended()) pump();
}

void TunnelLine::compare_address() {
  if (!options_.wanted || *options_.wanted == state_.own) return;
  ++counters_.other_address;
  note(kOtherAddress, fmt::format("the interface gave us the tunnel {} instead of {}", to_string(state_.own),
                                  to_string(*options_.wanted)));
}

void TunnelLine::received_cemi(ByteView cemi, std::optional<Tunnel::Outcome> outcome) {
  const auto watch = lifetime_.watch();
  if (callbacks_.frame) {
    callbacks_.frame(cemi, false);
    if (watch.ended()) return;
  }
  if (outcome) return finish(*outcome);
  if (cemi.empty() || cemi[0] != static_cast<std::uint8_t>(wire::CemiCode::kDataIndication)) return;
  const auto frame = wire::read_data_frame(cemi);
  if (!frame) {
    ++tunnel_counters_.bad_frames;
    return note("bad-frames", frame.error().text);
  }
  if (frame->lte()) {
    ++counters_.lte;
    return;
  }
  if (callbacks_.is_known && callbacks_.is_known(*frame)) return;
  const auto telegram = decode(options_.guard, *frame, state_.own);
  if (!telegram) return dropped(telegram.error());
  ++counters_.received;
  // The telegram is delivered all the same: in some installations several tunnels share an address.
  if (telegram->source == state_.own) ++counters_.duplicate_address;
  if (callbacks_.received) callbacks_.received(*telegram);
}

void TunnelLine::dropped(const secure::GroupGuard::Dropped& frame) {
  if (frame.counter().empty()) {
    ++counters_.other_frames;
    return;
  }
  note(std::string(frame.counter()), frame.why);
}

void TunnelLine::finish(Tunnel::Outcome outcome) {
  const auto watch = lifetime_.watch();
  if (outcome == Tunnel::Outcome::kConfirmed) ++counters_.sent;
  count_unconfirmed(outcome);
  if (watch.ended()) return;
  const auto report = report_of(outcome, over_tcp());
  telegrams_.finish(report.sent, report.why);
  if (!watch.ended()) pump();
}

/// The bus counts as down after three consecutive telegrams without a confirmation.
void TunnelLine::count_unconfirmed(Tunnel::Outcome outcome) {
  if (outcome == Tunnel::Outcome::kUnconfirmed) {
    if (++unconfirmed_in_row_ < kSilentBus) return;
    if (!over_tcp()) return set_bus(false, kBusSilent);
    if (unconfirmed_in_row_ == kSilentBus) set_state(state_.phase, std::string(kInterfaceSilent));
  } else if (outcome != Tunnel::Outcome::kNotUnderstood && std::exchange(unconfirmed_in_row_, 0U) >= kSilentBus) {
    if (over_tcp() && state_.bus) return set_state(state_.phase, {});
    set_bus(true, {});
  }
}

void TunnelLine::set_bus(bool connected, std::string_view why) {
  if (connected && unconfirmed_in_row_ >= kSilentBus) return;  // it answers heartbeats, but sends nothing to the bus
  if (state_.bus == connected) return;
  state_.bus = connected;
  set_state(state_.phase, std::string(why));
}

void TunnelLine::ended(Tunnel::End end) {
  const auto lived = up_since_ != SteadyTime{} ? scheduler_.now() - up_since_ : Duration{};
  const auto watch = lifetime_.watch();
  retire();
  explain_refusal(end);
  // Data of a dead stream that the operating system still holds would reach the bus after it expired.
  if (end.cause == Tunnel::Cause::kSilent) sockets_.abort();
  sockets_.close();
  up_since_ = {};
  hold_off_.ended(lived);
  settle(end);
  if (watch.ended()) return;
  telegrams_.line_lost();
  if (retries_later(end, lived)) return;
  fail_line({ErrorCode::kUnreachable, fmt::format("{}: {}", state_.server, reason_for(end)), finding_of(end)});
}

void TunnelLine::retire() {
  send_failure_.cancel();
  retired_ = std::move(tunnel_);
  if (session_) session_->close();
  retired_session_ = std::move(session_);
}

/// Reports the pending telegram if the server is known to have accepted it.
void TunnelLine::settle(const Tunnel::End& end) {
  if (!telegrams_.in_flight() || !end.outcome) return;
  if (*end.outcome == Tunnel::Outcome::kConfirmed) ++counters_.sent;
  const auto report = report_of(*end.outcome, over_tcp());
  telegrams_.finish(report.sent, report.why);
}

bool TunnelLine::retries_later(const Tunnel::End& end, Duration lived) {
  if (session_end_) return retries_session(lived);
  if (end.cause == Tunnel::Cause::kClosedByServer) return retries_closed(lived);
  if (end.cause != Tunnel::Cause::kRefused) return false;
  switch (wire::meaning_of(end.status).remedy) {
    case wire::Remedy::kWaitForSlot: state_.tunnel_in_use = true; [[fallthrough]];
    case wire::Remedy::kRetry:
      retry_after(Phase::kWaiting, hold_off_.slot_taken(), end.why, finding_of(end));
      return true;
    case wire::Remedy::kConfiguration:
      state_.user_refused = options_.secure && end.status == wire::status::kUnauthorised;
      retry_after(Phase::kRefused, hold_off_.misconfigured(), end.why, finding_of(end));
      return true;
    case wire::Remedy::kBusDown:
      state_.bus = false;
      retry_after(Phase::kWaiting, hold_off_.slot_taken(), end.why);
      return true;
    default: return false;
  }
}

bool TunnelLine::retries_closed(Duration lived) {
  const auto pause = hold_off_.closed_by_server(scheduler_.now(), lived);
  if (pause == Duration{}) return false;
  retry_after(Phase::kWaiting, pause,
              "the interface closes the tunnel repeatedly: two clients probably compete for it");
  return true;
}

bool TunnelLine::retries_session(Duration lived) {
  using Cause = secure::Session::Cause;
  switch (session_end_->cause) {
    case Cause::kNoneFree:
      retry_after(Phase::kWaiting, hold_off_.slot_taken(), session_end_->why, session_end_->finding());
      return true;
    case Cause::kWrongServer:
      retry_after(Phase::kRefused, hold_off_.misconfigured(), session_end_->why, session_end_->finding());
      return true;
    case Cause::kNotAuthenticated: retry_password(*session_end_); return true;
    case Cause::kClosed:
    case Cause::kForgotten: return retries_closed(lived);
    case Cause::kNoAnswer:
    case Cause::kBroken: break;
  }
  return false;
}

/// A password with letters beyond ASCII has several forms; the others are tried once and at once.
void TunnelLine::retry_password(const secure::Session::End& end) {
  const auto forms = options_.secure->user_key.forms();
  password_form_ = (password_form_ + 1) % forms;
  if (++refused_forms_ < forms)
    return retry_after(Phase::kConnecting, {}, "the password has another form, which is tried now");
  refused_forms_ = 0;
  state_.user_refused = true;
  retry_after(Phase::kRefused, hold_off_.misconfigured(), end.why, end.finding());
}

void TunnelLine::retry_after(Phase phase, Duration pause, std::string why, std::string_view finding) {
  next_attempt_ = scheduler_.wall_now() + std::chrono::ceil<std::chrono::microseconds>(pause);
  retry_timer_ = scheduler_.after(pause, [this] { retry(); });
  set_state(phase, std::move(why), finding);
}

bool TunnelLine::reopen() {
  if (!retry_timer_.pending()) return false;
  retry_timer_ = scheduler_.after(Duration::zero(), [this] { retry(); });
  return true;
}

void TunnelLine::use(secure::SessionKeys keys, wire::IndividualAddress tunnel) {
  if (!(state_.tunnel_in_use || state_.user_refused) || !reopen()) return;
  options_.secure = std::move(keys);
  options_.wanted = tunnel;
  password_form_ = refused_forms_ = 0;
}

void TunnelLine::use_gateway(std::string host, std::optional<secure::SessionKeys> keys,
                             std::optional<wire::IndividualAddress> tunnel) {
  const bool other = host != options_.host;
  options_.host = std::move(host);
  options_.secure = std::move(keys);
  options_.wanted = tunnel;
  if (other) route_back_ = options_.nat == TunnelOptions::Nat::kOn;
  password_form_ = refused_forms_ = 0;
}

void TunnelLine::hand_over(TunnelLine& to) {
  retires_ = true;
  telegrams_.hand_over(to.telegrams_);
}

void TunnelLine::retry() {
  state_.phase = Phase::kOff;
  state_.tunnel_in_use = state_.user_refused = false;
  ++counters_.attempts;
  if (auto opened = open(); !opened) fail_line(opened.error());
}

// Sending.

void TunnelLine::send(wire::Telegram telegram, SteadyTime expires, SendCallback done) {
  telegrams_.push(std::move(telegram), expires, after_settled(std::move(done), callbacks_));
}

void TunnelLine::pump() {
  const auto watch = lifetime_.watch();
  while (tunnel_ && tunnel_->idle() && !retires_) {
    const auto* telegram = telegrams_.take();
    if (telegram == nullptr) return;
    const auto cemi = encode(options_.guard, wire::CemiCode::kDataRequest, *telegram, state_.own,
                             options_.max_apdu ? options_.max_apdu : max_apdu_);
    if (!cemi) {
      telegrams_.finish(SendOutcome::kRefused, cemi.error().text);
      if (watch.ended()) return;
      continue;
    }
    tunnel_->send(*cemi);
    if (callbacks_.frame) callbacks_.frame(*cemi, true);
    if (watch.ended()) return;
  }
}

// States.

void TunnelLine::set_state(Phase phase, std::string reason, std::string_view finding) {
  state_.phase = phase;
  state_.reason = std::move(reason);
  state_.finding = finding;
  if (callbacks_.changed) callbacks_.changed(state_);
}

void TunnelLine::fail_line(Error why) {
  sockets_.close();
  const auto watch = lifetime_.watch();
  set_state(Phase::kOff, why.text, why.finding);
  if (!watch.ended() && callbacks_.failed) callbacks_.failed(std::move(why));
}

}  // namespace rubicon::networks::knx::line
