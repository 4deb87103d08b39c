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
/// Over TCP there are no acks, so that a silent bus looks like an interface that does not work.
constexpr std::string_view kInterfaceSilent = "the interface did not confirm three telegrams in a row";
constexpr std::size_t kMaxFrame = 2048;

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

std::uint64_t seconds_of(WallTime time) {
  return static_cast<std::uint64_t>(std::chrono::ceil<std::chrono::seconds>(time.time_since_epoch()).count());
}

bool is_ipv4(const std::string& address) {
  return address.find(':') == std::string::npos;
}

}  // namespace

TunnelLine::TunnelLine(TunnelOptions options, Scheduler& scheduler, transport::Transports& transports,
                       LineCallbacks callbacks)
    : options_(std::move(options)),
      scheduler_(scheduler),
      transports_(transports),
      callbacks_(std::move(callbacks)),
      route_back_(options_.nat == TunnelOptions::Nat::kOn),
      hold_off_(static_cast<std::uint64_t>(scheduler.wall_now().time_since_epoch().count()) ^
                std::hash<std::string>{}(options_.host)),
      outbox_(scheduler, options_.limits, [this] { pump(); }) {
  state_.server = options_.host;
}

TunnelLine::~TunnelLine() {
  lifetime_.end();
  if (tunnel_) tunnel_->close();
}

Result<void> TunnelLine::open() {
  if (state_.phase != Phase::kOff) return {};
  // A trial socket shows at once whether sockets can be opened and the local port is free.
  transport::UdpCalls unused{[](const auto&, ByteView) {}, [](const Error&) {}, [](const Error&) {}};
  transport::UdpOptions trial;
  if (!over_tcp()) trial.local.port = options_.local_port;
  if (const auto tried = transports_.open_udp(trial, std::move(unused)); !tried) return fail(tried.error());
  state_.phase = Phase::kResolving;
  lookup_ = transports_.look_up(options_.host, [this](auto addresses) { resolved(std::move(addresses)); });
  return {};
}

void TunnelLine::resolved(Result<std::vector<std::string>> addresses) {
  const auto lookup = std::move(lookup_);  // destroyed at the end: this is its callback
  if (!addresses) return fail_line(addresses.error().code, addresses.error().text);
  const auto four = std::find_if(addresses->begin(), addresses->end(), is_ipv4);
  if (four == addresses->end())
    return fail_line(ErrorCode::kUnreachable, fmt::format("{} has no IPv4 address", options_.host));
  control_ = {*four, options_.port};
  state_.server = fmt::format("{} ({})", options_.host, to_string(control_));
  connect();
}

void TunnelLine::connect() {
  if (auto opened = open_sockets(); !opened) return fail_line(opened.error().code, opened.error().text);
  const auto watch = lifetime_.watch();
  set_state(Phase::kConnecting, {});
  if (!watch.ended() && !over_tcp() && tunnel_) tunnel_->connect();
}

Result<void> TunnelLine::open_sockets() {
  if (auto opened = over_tcp() ? open_tcp() : open_udp(); !opened) return opened;
  data_ = control_;
  send_error_.clear();
  other_sender_.clear();
  make_tunnel();
  return {};
}

/// A connected probe socket tells which of our addresses the server sees. The socket of the tunnel is not connected,
/// since the data endpoint of a server may be another address.
Result<void> TunnelLine::open_udp() {
  transport::UdpOptions options;
  if (!route_back_) {
    transport::UdpCalls unused{[](const auto&, ByteView) {}, [](const Error&) {}, [](const Error&) {}};
    transport::UdpOptions probe;
    probe.remote = control_;
    const auto found = transports_.open_udp(probe, std::move(unused));
    if (!found) return fail(found.error());
    options.local = (*found)->local();
    if (!is_ipv4(options.local.address)) options.local.address.clear();
  }
  options.local.port = options_.local_port;
  options.largest = kMaxFrame;
  transport::UdpCalls calls;
  calls.received = [this](const transport::Endpoint& from, ByteView bytes) { received(from, bytes); };
  calls.undelivered = [this](const Error&) {
    ++counters_.undelivered;
    if (tunnel_) tunnel_->undelivered();
  };
  calls.failed = [this](const Error& error) {
    if (tunnel_) tunnel_->lost(error.text);
  };
  auto socket = transports_.open_udp(options, std::move(calls));
  if (!socket) return fail(socket.error());
  socket_ = std::move(*socket);
  return {};
}

Result<void> TunnelLine::open_tcp() {
  frames_.clear();
  transport::TcpOptions options;
  options.remote = control_;
  transport::TcpCalls calls;
  calls.connected = [this] {
    if (tunnel_) tunnel_->connect();
  };
  calls.received = [this](ByteView bytes) { stream_received(bytes); };
  calls.failed = [this](const Error& error) {
    if (tunnel_) tunnel_->lost(error.text);
  };
  auto stream = transports_.open_tcp(options, std::move(calls));
  if (!stream) return fail(stream.error());
  stream_ = std::move(*stream);
  return {};
}

wire::Hpai TunnelLine::own_endpoint() const {
  if (over_tcp()) return {wire::HostProtocol::kTcp, {}, 0};
  if (route_back_ || !socket_) return {};
  const auto local = socket_->local();
  const auto own = wire::udp_hpai(local.address, local.port);
  return own.route_back() ? wire::Hpai{} : own;
}

void TunnelLine::make_tunnel() {
  Tunnel::Callbacks calls;
  calls.transmit = [this](Tunnel::Path path, ByteView frame) { transmit(path, frame); };
  calls.up = [this] { up(); };
  calls.received = [this](ByteView cemi, std::optional<Tunnel::Outcome> outcome) { received_cemi(cemi, outcome); };
  calls.finished = [this](Tunnel::Outcome outcome) { finish(outcome); };
  calls.bus = [this](bool connected) {
    set_bus(connected, connected ? std::string_view() : wire::meaning_of(wire::status::kBusDown).meaning);
  };
  if (callbacks_.note) calls.note = callbacks_.note;
  calls.ended = [this](Tunnel::End end) { ended(std::move(end)); };
  const bool tries_route_back = !over_tcp() && options_.nat == TunnelOptions::Nat::kAuto;
  tunnel_ = std::make_unique<Tunnel>(scheduler_,
                                     Tunnel::Settings{over_tcp(), own_endpoint(), tries_route_back, options_.wanted},
                                     tunnel_counters_, std::move(calls));
}

// Callbacks of the sockets.

/// Accepts datagrams of the server, from any port.
void TunnelLine::received(const transport::Endpoint& from, ByteView bytes) {
  if (from.address != control_.address && from.address != data_.address) {
    ++counters_.other_source;
    other_sender_ = transport::to_string(from);
    return note("wrong-source", fmt::format("{} sends to this tunnel, but is not the interface {}: ignored",
                                            other_sender_, transport::to_string(control_)));
  }
  send_error_.clear();
  if (tunnel_) tunnel_->receive(bytes);
}

void TunnelLine::stream_received(ByteView bytes) {
  const auto watch = lifetime_.watch();
  frames_.append(bytes);
  while (!watch.ended() && tunnel_) {
    const auto frame = frames_.next();
    if (!frame) {
      ++tunnel_counters_.bad_frames;
      note("bad-frames", frame.error().text);
      if (!watch.ended() && tunnel_) tunnel_->lost(frame.error().text);
      return;
    }
    if (frame->empty()) return;
    tunnel_->receive(*frame);
  }
}

/// A frame that cannot be sent is treated as lost: the tunnel has timers for that.
void TunnelLine::transmit(Tunnel::Path path, ByteView frame) {
  Result<void> sent;
  if (stream_) {
    sent = stream_->send(frame);
  } else if (socket_) {
    sent = socket_->send(path == Tunnel::Path::kData ? data_ : control_, frame);
  }
  if (!sent) send_error_ = sent.error().text;
}

void TunnelLine::note(const std::string& subject, std::string_view text) {
  if (callbacks_.note) callbacks_.note(subject, text);
}

/// Adds possible causes where the server did not answer.
std::string TunnelLine::reason_for(const Tunnel::End& end) const {
  const bool silence = end.cause == Tunnel::Cause::kNoAnswer || end.cause == Tunnel::Cause::kSilent;
  auto why = end.why;
  if (silence && !send_error_.empty()) why += fmt::format(" ({})", send_error_);
  if (end.cause == Tunnel::Cause::kNoAnswer && !other_sender_.empty())
    why += fmt::format("; {} sent a datagram instead (wrong-source)", other_sender_);
  return why;
}

// Callbacks of the tunnel.

void TunnelLine::up() {
  ++counters_.connects;
  up_since_ = scheduler_.now();
  unconfirmed_in_row_ = 0;
  hold_off_.connected();
  route_back_ = route_back_ || tunnel_->route_back_works();
  const auto& data = tunnel_->data_endpoint();
  if (!over_tcp() && !data.route_back()) data_ = {address_text(data), data.port};
  state_.own = tunnel_->address();
  state_.bus = true;
  const auto watch = lifetime_.watch();
  set_state(Phase::kUp, {});
  if (!watch.ended()) pump();
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
  const auto telegram = wire::to_telegram(*frame);
  if (!telegram) {
    ++counters_.other_frames;
    return;
  }
  ++counters_.received;
  // The telegram is delivered all the same: in some installations several tunnels share an address.
  if (telegram->source == state_.own) ++counters_.duplicate_address;
  if (callbacks_.received) callbacks_.received(*telegram);
}

void TunnelLine::finish(Tunnel::Outcome outcome) {
  const auto watch = lifetime_.watch();
  if (outcome == Tunnel::Outcome::kConfirmed) ++counters_.sent;
  count_unconfirmed(outcome);
  if (watch.ended()) return;
  const auto report = report_of(outcome, over_tcp());
  outbox_.finish(report.sent, report.why);
  if (!watch.ended()) pump();
}

/// The bus counts as down after three consecutive telegrams without a confirmation.
void TunnelLine::count_unconfirmed(Tunnel::Outcome outcome) {
  if (outcome == Tunnel::Outcome::kUnconfirmed) {
    if (++unconfirmed_in_row_ < kSilentBus) return;
    if (!over_tcp()) return set_bus(false, kBusSilent);
    if (unconfirmed_in_row_ == kSilentBus) set_state(state_.phase, std::string(kInterfaceSilent));
  } else if (outcome != Tunnel::Outcome::kNotUnderstood && std::exchange(unconfirmed_in_row_, 0U) >= kSilentBus) {
    over_tcp() && state_.bus ? set_state(state_.phase, {}) : set_bus(true, {});
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
  retired_ = std::move(tunnel_);
  if (!std::exchange(route_back_, route_back_ || retired_->route_back_works()) && route_back_ &&
      end.cause == Tunnel::Cause::kRefused && wire::meaning_of(end.status).remedy == wire::Remedy::kWaitForSlot)
    end.why += "; our first request may occupy one for two minutes, because its answer did not reach us (NAT)";
  // Data of a dead stream that the operating system still holds would reach the bus after it expired.
  if (stream_ && end.cause == Tunnel::Cause::kSilent) stream_->abort();
  close_sockets();
  up_since_ = {};
  hold_off_.ended(lived);
  if (outbox_.in_flight() && end.outcome) {
    if (*end.outcome == Tunnel::Outcome::kConfirmed) ++counters_.sent;
    const auto report = report_of(*end.outcome, over_tcp());
    outbox_.finish(report.sent, report.why);
    if (watch.ended()) return;
  }
  outbox_.line_lost();
  if (retries_later(end, lived)) return;
  fail_line(ErrorCode::kUnreachable, fmt::format("{}: {}", state_.server, reason_for(end)));
}

bool TunnelLine::retries_later(const Tunnel::End& end, Duration lived) {
  if (end.cause == Tunnel::Cause::kClosedByServer) {
    const auto pause = hold_off_.closed_by_server(scheduler_.now(), lived);
    if (pause == Duration{}) return false;
    retry_after(Phase::kWaiting, pause,
                "the interface closes the tunnel repeatedly: two clients probably compete for it");
    return true;
  }
  if (end.cause != Tunnel::Cause::kRefused) return false;
  switch (wire::meaning_of(end.status).remedy) {
    case wire::Remedy::kRetry:
    case wire::Remedy::kWaitForSlot: retry_after(Phase::kWaiting, hold_off_.slot_taken(), end.why); return true;
    case wire::Remedy::kConfiguration: retry_after(Phase::kRefused, hold_off_.misconfigured(), end.why); return true;
    case wire::Remedy::kBusDown:
      state_.bus = false;
      retry_after(Phase::kWaiting, hold_off_.slot_taken(), end.why);
      return true;
    default: return false;
  }
}

void TunnelLine::retry_after(Phase phase, Duration pause, std::string why) {
  next_attempt_ = scheduler_.wall_now() + std::chrono::ceil<std::chrono::microseconds>(pause);
  retry_timer_ = scheduler_.after(pause, [this] { retry(); });
  set_state(phase, std::move(why));
}

bool TunnelLine::reopen() {
  if (!retry_timer_.pending()) return false;
  retry_timer_ = scheduler_.after(Duration::zero(), [this] { retry(); });
  return true;
}

void TunnelLine::retry() {
  state_.phase = Phase::kOff;
  ++counters_.attempts;
  if (auto opened = open(); !opened) fail_line(opened.error().code, opened.error().text);
}

// Sending.

void TunnelLine::send(wire::Telegram telegram, SteadyTime expires, SendCallback done) {
  outbox_.push(std::move(telegram), expires, after_settled(std::move(done), callbacks_));
}

void TunnelLine::pump() {
  const auto watch = lifetime_.watch();
  while (tunnel_ && tunnel_->idle()) {
    const auto* telegram = outbox_.take();
    if (telegram == nullptr) return;
    const auto cemi = wire::write_telegram(wire::CemiCode::kDataRequest, *telegram);
    if (!cemi) {
      outbox_.finish(SendOutcome::kRefused, cemi.error().text);
      if (watch.ended()) return;
      continue;
    }
    tunnel_->send(*cemi);
    if (callbacks_.frame) callbacks_.frame(*cemi, true);
    if (watch.ended()) return;
  }
}

// States.

void TunnelLine::set_state(Phase phase, std::string reason) {
  state_.phase = phase;
  state_.reason = std::move(reason);
  if (callbacks_.changed) callbacks_.changed(state_);
}

void TunnelLine::close_sockets() {
  socket_.reset();
  stream_.reset();
}

void TunnelLine::fail_line(ErrorCode code, std::string why) {
  close_sockets();
  const auto watch = lifetime_.watch();
  set_state(Phase::kOff, why);
  if (!watch.ended() && callbacks_.failed) callbacks_.failed({code, std::move(why)});
}

std::map<std::string, std::uint64_t> TunnelLine::counters() const {
  const auto& tunnel = tunnel_counters_;
  const auto& outbox = outbox_.counters();
  return {{"telegrams-sent", counters_.sent},
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
          {"doubled-address", counters_.duplicate_address}};
}

}  // namespace rubicon::networks::knx::line
