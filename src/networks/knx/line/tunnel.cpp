#include "networks/knx/line/tunnel.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/assert.h"
#include "networks/knx/wire/blocks.h"
#include "networks/knx/wire/cemi.h"

namespace rubicon::networks::knx::line {

namespace {

using namespace std::chrono_literals;

// knx.md, section 5.1.
constexpr Duration kAnswerTime = 10s;
constexpr Duration kPeriod = 60s;
constexpr Duration kPauseAfterError = 1s;
constexpr unsigned kMaxHeartbeats = 4;

}  // namespace

TunnelHeartbeat::TunnelHeartbeat(Scheduler& scheduler, TunnelCounters& counters, Callbacks callbacks)
    : counters_(counters), callbacks_(std::move(callbacks)), deadline_(scheduler, [this] { reached(); }) {}

void TunnelHeartbeat::start() {
  deadline_.set(kPeriod);
}

void TunnelHeartbeat::reached() {
  if (!awaits_answer()) return request();
  ++counters_.missing_heartbeats;
  if (attempts_ >= kMaxHeartbeats) return callbacks_.unanswered("the interface does not answer heartbeats");
  request();
}

void TunnelHeartbeat::request() {
  ++attempts_;
  state_ = State::kAwaitsAnswer;
  deadline_.set(kAnswerTime);
  callbacks_.request();
}

void TunnelHeartbeat::succeeded() {
  if (awaits_answer()) start();
  state_ = State::kWaits;
  attempts_ = 0;
}

void TunnelHeartbeat::failed(std::uint8_t status) {
  if (!awaits_answer()) return;  // the answer to a connection check of the sender
  ++counters_.missing_heartbeats;
  if (attempts_ >= kMaxHeartbeats) return callbacks_.unanswered(wire::describe_status(status));
  state_ = State::kWaits;
  deadline_.set(kPauseAfterError);
}

namespace {

// knx.md, section 5.1.
constexpr Duration kConnectTime = 10s;
constexpr Duration kResyncTime = 2s;
/// Interval of CONNECT_REQUESTs over UDP, so that one lost datagram does not cost 10 s.
constexpr Duration kConnectRepeat = 2s;
/// How long the answer to a CONNECT_REQUEST for a certain address may arrive again, repeated or delayed.
constexpr Duration kSameAnswer = 1s;
/// How long telegrams wait for the server to say which APDU it carries; some never do.
constexpr Duration kApduAnswer = 500ms;
/// Every medium carries this (knx.md, section 4); a server that says less does not know.
constexpr std::uint16_t kMinApdu = 15;
/// Consecutive requests that the operating system reports as undeliverable before the tunnel ends.
constexpr unsigned kMaxUndelivered = 2;

}  // namespace

Tunnel::Tunnel(Scheduler& scheduler, Settings settings, TunnelCounters& counters, Callbacks callbacks)
    : scheduler_(scheduler),
      settings_(settings),
      counters_(counters),
      callbacks_(std::move(callbacks)),
      sender_(scheduler, settings_.stream, counters, sender_callbacks()),
      heartbeat_(scheduler, counters, heartbeat_callbacks()),
      resync_deadline_(scheduler, [this] { end(Cause::kOutOfStep, "the interface counts telegrams differently"); }),
      connect_deadline_(scheduler, [this] { connect_timeout(); }),
      apdu_deadline_(scheduler, [this] { know_max_apdu(std::nullopt); }) {}

TunnelSender::Callbacks Tunnel::sender_callbacks() {
  TunnelSender::Callbacks calls;
  calls.transmit = [this](ByteView frame) { callbacks_.transmit(Path::kData, frame); };
  calls.check_connection = [this] {
    // A pending heartbeat asks the same; only over UDP does its answer help the sender.
    if (settings_.stream || !heartbeat_.awaits_answer()) request_state();
  };
  calls.finished = [this](Outcome outcome) { callbacks_.finished(outcome); };
  calls.gave_up = [this](std::string why) { end(Cause::kSilent, std::move(why)); };
  return calls;
}

TunnelHeartbeat::Callbacks Tunnel::heartbeat_callbacks() {
  return {[this] { request_state(); }, [this](std::string why) { end(Cause::kSilent, std::move(why)); }};
}

void Tunnel::transmit(Path path, const wire::Message& message) {
  const auto frame = write(message);
  callbacks_.transmit(path, frame);
}

void Tunnel::connect() {
  RUBICON_ASSERT(phase_ == Phase::kNew);
  phase_ = Phase::kConnecting;
  connecting_.until = scheduler_.now() + kConnectTime;
  send_connect();
}

void Tunnel::send_connect() {
  ++connecting_.attempts;
  if (connecting_.attempts > 1 && settings_.tries_route_back) settings_.own = {};
  const auto repeat = scheduler_.now() + connecting_.attempts * kConnectRepeat;
  connect_deadline_.set_at(settings_.stream ? connecting_.until : std::min(repeat, connecting_.until));
  transmit(
      Path::kControl,
      wire::ConnectRequest{
          settings_.own, settings_.own, {wire::ConnectionType::kTunnel, wire::TunnelLayer::kLink, settings_.wanted}});
}

void Tunnel::connect_timeout() {
  if (scheduler_.now() < connecting_.until) return send_connect();
  end(Cause::kNoAnswer, "the interface does not answer");
}

void Tunnel::receive(ByteView bytes) {
  if (phase_ == Phase::kEnded) return;
  const auto frame = wire::read_frame(bytes);
  if (!frame) return receive_bad_frame(frame.error().text);
  undelivered_in_row_ = 0;
  sender_.server_is_alive();
  switch (frame->service) {
    case wire::ServiceCode::kTunnellingAck: return receive_ack(*frame);
    case wire::ServiceCode::kTunnellingRequest:
    case wire::ServiceCode::kFeatureResponse:
    case wire::ServiceCode::kFeatureNotice: return receive_request(*frame);
    default: return receive_control(*frame);
  }
}

void Tunnel::receive_control(const wire::Frame& frame) {
  const auto message = wire::read_message(frame);
  if (!message) {
    receive_bad_frame(message.error().text);
  } else if (const auto* connect = std::get_if<wire::ConnectResponse>(&*message)) {
    receive(*connect);
  } else if (const auto* state = std::get_if<wire::ConnectionStateResponse>(&*message)) {
    receive(*state);
  } else if (const auto* disconnect = std::get_if<wire::DisconnectRequest>(&*message)) {
    receive(*disconnect);
  } else if (const auto* found = std::get_if<wire::SearchResponse>(&*message); found && settings_.asks_max_apdu) {
    receive(*found);
  } else if (!std::holds_alternative<wire::DisconnectResponse>(*message)) {
    ++counters_.unknown_services;
    if (callbacks_.note)
      callbacks_.note("unknown-services", fmt::format("the interface sent {}: ignored", to_string(frame.service)));
  }
}

void Tunnel::receive_bad_frame(std::string_view why) {
  ++counters_.bad_frames;
  if (callbacks_.note)
    callbacks_.note("bad-frames", fmt::format("the interface sent a frame that cannot be read: {}", why));
}

void Tunnel::receive(const wire::ConnectResponse& response) {
  if (phase_ != Phase::kConnecting) {
    // A repeated request got a second channel, which nothing would use.
    if (response.status == wire::status::kOk && response.channel != channel_) disconnect(response.channel);
    return;
  }
  connecting_.answered = true;
  settings_.tries_route_back = false;
  if (response.status == wire::status::kOk) return connected(response);
  refused(response.status);
}

/// Some servers do not understand a wanted address (status 22), or grant it to one user only (28; knx.md, 21.5).
void Tunnel::refused(std::uint8_t status) {
  const bool about_address = status == wire::status::kConnectionType || status == wire::status::kUnauthorised;
  if (about_address && settings_.wanted) {
    settings_.wanted.reset();
    connecting_.attempts = 0;
    connecting_.ignores_refusal_until = scheduler_.now() + kSameAnswer;
    return send_connect();
  }
  // Over UDP probably the same answer again; if not, the repeated request gets another.
  if (about_address && !settings_.stream && scheduler_.now() < connecting_.ignores_refusal_until) return;
  end(Cause::kRefused, wire::describe_status(status), status);
}

void Tunnel::connected(const wire::ConnectResponse& response) {
  phase_ = Phase::kUp;
  channel_ = response.channel;
  address_ = response.crd.address;
  data_ = response.data;
  connect_deadline_.clear();
  heartbeat_.start();
  if (settings_.asks_max_apdu) ask_max_apdu();
  callbacks_.up();
}

void Tunnel::ask_max_apdu() {
  apdu_deadline_.set(kApduAnswer);
  if (settings_.stream)
    return transmit(Path::kData, wire::FeatureMessage{wire::ServiceCode::kFeatureGet,
                                                      {channel_, 0, 0},
                                                      static_cast<std::uint8_t>(wire::Feature::kMaxApdu),
                                                      0,
                                                      {}});
  const auto block = static_cast<std::uint8_t>(wire::Dib::Type::kTunnelling);
  transmit(Path::kControl,
           wire::SearchRequest{settings_.own, true, {{wire::Srp::Type::kWantedDibs, false, {block, 0}}}});
}

void Tunnel::know_max_apdu(std::optional<std::uint16_t> bytes) {
  apdu_deadline_.clear();
  if (bytes && *bytes < kMinApdu) bytes.reset();
  if (callbacks_.max_apdu) callbacks_.max_apdu(bytes);
}

void Tunnel::receive(const wire::SearchResponse& response) {
  if (up()) know_max_apdu(wire::read_description(response.dibs).max_apdu);
}

bool Tunnel::accept_channel(std::uint8_t channel) {
  if (phase_ == Phase::kUp && channel == channel_) return true;
  ++counters_.wrong_channel;
  return false;
}

void Tunnel::receive(const wire::DisconnectRequest& request) {
  if (!accept_channel(request.channel)) return;
  transmit(Path::kControl, wire::DisconnectResponse{channel_, wire::status::kOk});
  end(Cause::kClosedByServer, "the interface closed the tunnel");
}

void Tunnel::receive(const wire::ConnectionStateResponse& response) {
  if (!accept_channel(response.channel)) return;
  if (response.status == wire::status::kUnknownConnection)
    return end(Cause::kForgotten, wire::describe_status(response.status), response.status);
  const bool bus_down = response.status == wire::status::kBusDown;
  if (response.status != wire::status::kOk && !bus_down) return heartbeat_.failed(response.status);
  heartbeat_.succeeded();
  callbacks_.bus(!bus_down);
}

// Requests of the server (knx.md, section 6.2). The ack is sent before the cEMI frame is read.

void Tunnel::receive_request(const wire::Frame& frame) {
  base::ByteReader reader(frame.body);
  const auto header = wire::read_connection_header(reader);
  if (!header) return receive_bad_frame(header.error().text);
  if (!accept_channel(header->channel)) return;
  if (!settings_.stream && !accept_sequence(header->sequence)) return;
  const auto rest = frame.body.subspan(reader.position());
  if (frame.service == wire::ServiceCode::kTunnellingRequest) return receive_cemi(rest);
  receive_feature(frame.service, rest);
}

bool Tunnel::accept_sequence(std::uint8_t sequence) {
  if (sequence == receive_sequence_) {
    acknowledge(sequence);
    ++receive_sequence_;
    resync_deadline_.clear();
    return true;
  }
  if (sequence == static_cast<std::uint8_t>(receive_sequence_ - 1)) {
    ++counters_.duplicates;
    acknowledge(sequence);
    return false;
  }
  ++counters_.wrong_sequence;
  if (!resync_deadline_.is_set()) resync_deadline_.set(kResyncTime);
  return false;
}

void Tunnel::acknowledge(std::uint8_t sequence) {
  wire::write_connection_ack(ack_, wire::ServiceCode::kTunnellingAck, {channel_, sequence, wire::status::kOk});
  callbacks_.transmit(Path::kData, ack_);
}

void Tunnel::receive_cemi(ByteView cemi) {
  const bool confirmation = !cemi.empty() && cemi[0] == static_cast<std::uint8_t>(wire::CemiCode::kDataConfirmation);
  callbacks_.received(cemi, confirmation ? sender_.receive_confirmation(cemi) : std::nullopt);
}

void Tunnel::receive_feature(wire::ServiceCode service, ByteView body) {
  if (body.size() < 2) return receive_bad_frame(fmt::format("{}: body: too short", to_string(service)));
  const bool of_bus = body[0] == static_cast<std::uint8_t>(wire::Feature::kBusConnection) && body.size() > 2;
  if (of_bus && service == wire::ServiceCode::kFeatureNotice) return callbacks_.bus(body[2] != 0);
  const bool of_apdu = body[0] == static_cast<std::uint8_t>(wire::Feature::kMaxApdu);
  if (!of_apdu || service != wire::ServiceCode::kFeatureResponse || !settings_.asks_max_apdu) return;
  base::ByteReader value(body.subspan(2));
  const auto bytes = value.u16_be();
  know_max_apdu(body[1] == 0 && value.ok() ? std::optional(bytes) : std::nullopt);
}

void Tunnel::receive_ack(const wire::Frame& frame) {
  base::ByteReader reader(frame.body);
  const auto ack = wire::read_connection_header(reader);
  if (!ack) return receive_bad_frame(ack.error().text);
  if (accept_channel(ack->channel)) sender_.receive_ack(*ack);
}

void Tunnel::send(ByteView cemi) {
  RUBICON_ASSERT(up());
  sender_.send(channel_, cemi);
}

void Tunnel::request_state() {
  transmit(Path::kControl, wire::ConnectionStateRequest{channel_, settings_.own});
}

void Tunnel::undelivered() {
  if (phase_ == Phase::kConnecting) return end(Cause::kUnreachable, "no program listens on that port");
  if (phase_ != Phase::kUp) return;
  if (++undelivered_in_row_ >= kMaxUndelivered)
    return end(Cause::kUnreachable, "no program listens on that port any longer");
  request_state();
}

void Tunnel::disconnect(std::uint8_t channel) {
  transmit(Path::kControl, wire::DisconnectRequest{channel, settings_.own});
}

void Tunnel::stop() {
  phase_ = Phase::kEnded;
  heartbeat_.stop();
  resync_deadline_.clear();
  connect_deadline_.clear();
  apdu_deadline_.clear();
}

void Tunnel::close() {
  if (phase_ == Phase::kUp) {
    disconnect(channel_);
    // It is not repeated. If it is lost, the server keeps the tunnel occupied for two minutes.
    if (!settings_.stream) disconnect(channel_);
  }
  stop();
  static_cast<void>(sender_.stop());
}

void Tunnel::lost(std::string why) {
  if (phase_ != Phase::kEnded) end(Cause::kUnreachable, std::move(why));
}

void Tunnel::end(Cause cause, std::string why, std::uint8_t status) {
  const bool knows_channel = cause != Cause::kClosedByServer && cause != Cause::kForgotten;
  if (phase_ == Phase::kUp && knows_channel) disconnect(channel_);
  stop();
  const auto outcome = sender_.stop();
  callbacks_.ended({cause, status, std::move(why), outcome});
}

}  // namespace rubicon::networks::knx::line
