#include "networks/knx/line/tunnel.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/assert.h"
#include "networks/knx/wire/cemi.h"

namespace rubicon::networks::knx::line {

namespace {

using namespace std::chrono_literals;

// knx.md, section 5.1.
constexpr Duration kConnectTime = 10s;
constexpr Duration kStateTime = 10s;
constexpr Duration kHeartbeatPeriod = 60s;
constexpr Duration kHeartbeatPause = 1s;  ///< before the repeat, after an answer with an error
constexpr unsigned kHeartbeatTries = 4;
constexpr Duration kAckTime = 1s;
constexpr Duration kConfirmationTime = 3s;
/// A confirmation that is lost comes again after 1 s; after 2 s knxd drops the channel without a word (knxd.md, section
/// 6): then the server is asked whether it knows it still.
constexpr Duration kConfirmationDoubt = 2100ms;
constexpr Duration kResyncTime = 2s;
/// A CONNECT_REQUEST over UDP is repeated after so long, and again: one lost datagram shall not cost 10 s.
constexpr Duration kConnectRepeat = 2s;
/// A stream that owes a confirmation and says nothing at all is given up after so much more.
constexpr Duration kStreamSilence = 3s;
/// How long the confirmation of a request that was given up is waited for, lest it pass for that of an equal one.
constexpr Duration kStrayTime = 5s;
/// How long the answer to a CONNECT_REQUEST for a certain address may come again, by a repeat or the network.
constexpr Duration kSameAnswer = 1s;
/// How long an ack may come after the confirmation, which says as much as it.
constexpr Duration kAckGrace = 100ms;
/// Header and connection header stand before the cEMI of a request.
constexpr std::size_t kBeforeCemi = wire::kHeaderSize + 4;

}  // namespace

Tunnel::Tunnel(Scheduler& scheduler, Settings settings, TunnelCounters& counters, Calls calls)
    : scheduler_(scheduler),
      settings_(settings),
      counters_(counters),
      calls_(std::move(calls)),
      request_deadline_(scheduler, [this] { request_timeout(); }),
      heartbeat_deadline_(scheduler, [this] { awaits_state_ ? heartbeat_missing() : heartbeat(); }),
      resync_deadline_(scheduler, [this] { end(Cause::kOutOfStep, "the interface counts telegrams differently"); }),
      connect_deadline_(scheduler, [this] { connect_timeout(); }) {}

void Tunnel::transmit(Path path, const wire::Message& message) {
  const auto frame = write(message);
  calls_.transmit(path, frame);
}

void Tunnel::connect() {
  RUBICON_ASSERT(phase_ == Phase::kNew);
  phase_ = Phase::kConnecting;
  connect_until_ = scheduler_.now() + kConnectTime;
  send_connect();
}

void Tunnel::send_connect() {
  ++connect_tries_;
  if (connect_tries_ > 1 && settings_.tries_route_back) settings_.own = {};
  const auto repeat = scheduler_.now() + connect_tries_ * kConnectRepeat;
  connect_deadline_.set_at(settings_.stream ? connect_until_ : std::min(repeat, connect_until_));
  transmit(
      Path::kControl,
      wire::ConnectRequest{
          settings_.own, settings_.own, {wire::ConnectionType::kTunnel, wire::TunnelLayer::kLink, settings_.wanted}});
}

void Tunnel::connect_timeout() {
  if (scheduler_.now() < connect_until_) return send_connect();
  end(Cause::kNoAnswer, "the interface does not answer");
}

void Tunnel::receive(ByteView bytes) {
  if (phase_ == Phase::kEnded) return;
  const auto frame = wire::read_frame(bytes);
  if (!frame) return bad_frame(frame.error().text);
  undelivered_in_row_ = 0;
  heard_ = true;
  if (std::exchange(holds_, false)) request_deadline_.set(Duration::zero());
  switch (frame->service) {
    case wire::ServiceCode::kTunnellingAck: return on_ack(*frame);
    case wire::ServiceCode::kTunnellingRequest:
    case wire::ServiceCode::kFeatureResponse:
    case wire::ServiceCode::kFeatureNotice: return on_request(*frame);
    default: return on_control(*frame);
  }
}

void Tunnel::on_control(const wire::Frame& frame) {
  const auto message = wire::read_message(frame);
  if (!message) {
    bad_frame(message.error().text);
  } else if (const auto* connect = std::get_if<wire::ConnectResponse>(&*message)) {
    on(*connect);
  } else if (const auto* state = std::get_if<wire::ConnectionStateResponse>(&*message)) {
    on(*state);
  } else if (const auto* disconnect = std::get_if<wire::DisconnectRequest>(&*message)) {
    on(*disconnect);
  } else if (!std::holds_alternative<wire::DisconnectResponse>(*message)) {
    ++counters_.unknown_services;
    if (calls_.note)
      calls_.note("unknown-services", fmt::format("the interface sent {}: passed over", to_string(frame.service)));
  }
}

void Tunnel::bad_frame(std::string_view why) {
  ++counters_.bad_frames;
  if (calls_.note) calls_.note("bad-frames", fmt::format("the interface sent a frame that cannot be read: {}", why));
}

void Tunnel::on(const wire::ConnectResponse& response) {
  if (phase_ != Phase::kConnecting) {
    // A second channel, because the request was repeated: nobody would ever use it.
    if (response.status == wire::status::kOk && response.channel != channel_) disconnect(response.channel);
    return;
  }
  answered_ = true;
  settings_.tries_route_back = false;
  if (response.status == wire::status::kOk) return connected(response);
  if (response.status == wire::status::kConnectionType && settings_.wanted) {
    settings_.wanted.reset();
    connect_tries_ = 0;
    answers_from_ = scheduler_.now() + kSameAnswer;
    return send_connect();
  }
  // Likely the same answer once more; if not, the repeat brings another.
  if (response.status == wire::status::kConnectionType && scheduler_.now() < answers_from_) return;
  end(Cause::kRefused, wire::describe_status(response.status), response.status);
}

void Tunnel::connected(const wire::ConnectResponse& response) {
  phase_ = Phase::kUp;
  channel_ = response.channel;
  address_ = response.crd.address;
  data_ = response.data;
  connect_deadline_.clear();
  heartbeat_deadline_.set(kHeartbeatPeriod);
  calls_.up();
}

void Tunnel::on(const wire::DisconnectRequest& request) {
  if (phase_ != Phase::kUp || request.channel != channel_) {
    ++counters_.wrong_channel;
    return;
  }
  transmit(Path::kControl, wire::DisconnectResponse{channel_, wire::status::kOk});
  end(Cause::kClosedByServer, "the interface closed the tunnel");
}

// Receiving (knx.md, section 6.2). The ack goes out before anybody looks at the cEMI.

void Tunnel::on_request(const wire::Frame& frame) {
  base::ByteReader reader(frame.body);
  const auto header = wire::read_connection_header(reader);
  if (!header) return bad_frame(header.error().text);
  if (phase_ != Phase::kUp || header->channel != channel_) {
    ++counters_.wrong_channel;
    return;
  }
  if (!settings_.stream && !in_sequence(header->sequence)) return;
  const auto rest = frame.body.subspan(reader.position());
  if (frame.service == wire::ServiceCode::kTunnellingRequest) return on_cemi(rest);
  on_feature(frame.service, rest);
}

bool Tunnel::in_sequence(std::uint8_t sequence) {
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
  calls_.transmit(Path::kData, ack_);
}

void Tunnel::on_cemi(ByteView cemi) {
  const bool is_confirmation = !cemi.empty() && cemi[0] == static_cast<std::uint8_t>(wire::CemiCode::kDataConfirmation);
  auto outcome = is_confirmation ? confirmation(cemi) : std::nullopt;
  if (outcome && sending_ == Sending::kWaitAck) {
    early_ = std::exchange(outcome, std::nullopt);
    request_deadline_.set_at(std::min(request_deadline_.due(), scheduler_.now() + kAckGrace));
  } else if (outcome) {
    sending_ = Sending::kIdle;
    request_deadline_.clear();
  }
  calls_.received(cemi, outcome);
}

/// The confirmation that is still owed for a request that was given up: the next equal one shall not take it for its
/// own.
bool Tunnel::is_stray(ByteView confirmation) {
  if (stray_.empty()) return false;
  const bool late = scheduler_.now() < stray_until_ && wire::confirms(confirmation, stray_);
  if (late || scheduler_.now() >= stray_until_) stray_.clear();
  return late;
}

std::optional<Tunnel::Outcome> Tunnel::confirmation(ByteView cemi) {
  if (is_stray(cemi)) {
    ++counters_.late_confirmations;
    swallowed_ = sending_ != Sending::kIdle;
    return std::nullopt;
  }
  if (sending_ == Sending::kIdle || !wire::confirms(cemi, ByteView(request_).subspan(kBeforeCemi))) {
    ++counters_.late_confirmations;
    return std::nullopt;
  }
  if ((wire::control1_of(cemi) & 1) == 0) return Outcome::kConfirmed;
  ++counters_.not_acknowledged;
  return Outcome::kNotAcknowledged;
}

void Tunnel::on_feature(wire::ServiceCode service, ByteView body) {
  if (body.size() < 2) return bad_frame(fmt::format("{}: body: too short", to_string(service)));
  const bool of_bus = body[0] == static_cast<std::uint8_t>(wire::Feature::kBusConnection) && body.size() > 2;
  if (of_bus && service == wire::ServiceCode::kFeatureNotice) calls_.bus(body[2] != 0);
}

// Sending (knx.md, section 6.1).

void Tunnel::send(ByteView cemi) {
  RUBICON_ASSERT(idle());
  wire::write_connection_request(request_, wire::ServiceCode::kTunnellingRequest, {channel_, send_sequence_, 0}, cemi);
  request_tries_ = 0;
  early_.reset();
  swallowed_ = doubted_ = false;
  if (settings_.stream) {
    ++send_sequence_;
    sending_ = Sending::kWaitConfirmation;
    request_deadline_.set(kConfirmationDoubt);
  } else {
    sending_ = Sending::kWaitAck;
  }
  transmit_request();
}

void Tunnel::transmit_request() {
  ++request_tries_;
  if (!settings_.stream) request_deadline_.set(kAckTime);
  calls_.transmit(Path::kData, request_);
}

void Tunnel::on_ack(const wire::Frame& frame) {
  base::ByteReader reader(frame.body);
  const auto ack = wire::read_connection_header(reader);
  if (!ack) return bad_frame(ack.error().text);
  if (phase_ != Phase::kUp || ack->channel != channel_) {
    ++counters_.wrong_channel;
    return;
  }
  if (sending_ != Sending::kWaitAck || ack->sequence != send_sequence_) return;
  if (ack->status == wire::status::kLayer) {
    ++send_sequence_;
    ++counters_.not_understood;
    return finish(Outcome::kNotUnderstood);
  }
  if (ack->status != wire::status::kOk) return ack_missing();
  if (const auto outcome = acknowledged()) finish(*outcome);
}

/// The outcome if the confirmation was there before.
std::optional<Tunnel::Outcome> Tunnel::acknowledged() {
  ++send_sequence_;
  sending_ = Sending::kWaitConfirmation;
  doubted_ = false;
  request_deadline_.set(kConfirmationDoubt);
  return early_;
}

void Tunnel::finish(Outcome outcome) {
  sending_ = Sending::kIdle;
  request_deadline_.clear();
  holds_ = false;
  // If an equal one's came meanwhile, it may have been this one's: another is not to be waited for.
  if (outcome == Outcome::kUnconfirmed && !swallowed_) {
    const auto cemi = ByteView(request_).subspan(kBeforeCemi);
    stray_.assign(cemi.begin(), cemi.end());
    stray_until_ = scheduler_.now() + kStrayTime;
  }
  calls_.finished(outcome);
}

void Tunnel::request_timeout() {
  if (sending_ == Sending::kWaitAck) return ack_missing();
  if (!std::exchange(doubted_, true)) {
    heard_ = false;
    request_deadline_.set(kConfirmationTime - kConfirmationDoubt);
    if (settings_.stream || !awaits_state_) send_state_request();
    return;
  }
  if (settings_.stream && !heard_) {
    if (holds_) return end(Cause::kSilent, "the interface says nothing any more");
    holds_ = true;
    return request_deadline_.set(kStreamSilence);
  }
  ++counters_.unconfirmed;
  finish(Outcome::kUnconfirmed);
}

/// A confirmation without an ack says that the ack was lost: the server took the request. Else the request is repeated
/// once, and the server asked whether it knows the channel still: some drop it without a word.
void Tunnel::ack_missing() {
  ++counters_.missing_acks;
  if (early_) {
    if (const auto outcome = acknowledged()) return finish(*outcome);
  }
  if (request_tries_ > 1) return end(Cause::kSilent, "the interface does not acknowledge telegrams");
  ++counters_.repeats;
  transmit_request();
  if (!awaits_state_) send_state_request();
}

// Heartbeat (knx.md, section 5.4).

void Tunnel::send_state_request() {
  transmit(Path::kControl, wire::ConnectionStateRequest{channel_, settings_.own});
}

void Tunnel::heartbeat() {
  ++heartbeat_tries_;
  awaits_state_ = true;
  heartbeat_deadline_.set(kStateTime);
  send_state_request();
}

void Tunnel::heartbeat_missing() {
  ++counters_.missing_heartbeats;
  if (heartbeat_tries_ >= kHeartbeatTries) return end(Cause::kSilent, "the interface does not answer heartbeats");
  heartbeat();
}

void Tunnel::on(const wire::ConnectionStateResponse& response) {
  if (phase_ != Phase::kUp || response.channel != channel_) {
    ++counters_.wrong_channel;
    return;
  }
  if (response.status == wire::status::kUnknownConnection)
    return end(Cause::kForgotten, wire::describe_status(response.status), response.status);
  const bool bus_down = response.status == wire::status::kBusDown;
  if (response.status == wire::status::kOk || bus_down) {
    if (std::exchange(awaits_state_, false)) heartbeat_deadline_.set(kHeartbeatPeriod);
    heartbeat_tries_ = 0;
    return calls_.bus(!bus_down);
  }
  if (!awaits_state_) return;  // it answers a question that was no heartbeat
  ++counters_.missing_heartbeats;
  if (heartbeat_tries_ >= kHeartbeatTries) return end(Cause::kSilent, wire::describe_status(response.status));
  awaits_state_ = false;
  heartbeat_deadline_.set(kHeartbeatPause);
}

void Tunnel::undelivered() {
  if (phase_ == Phase::kConnecting) return end(Cause::kUnreachable, "nobody listens there");
  if (phase_ != Phase::kUp) return;
  if (++undelivered_in_row_ >= 2) return end(Cause::kUnreachable, "nobody listens there any more");
  send_state_request();
}

void Tunnel::disconnect(std::uint8_t channel) {
  transmit(Path::kControl, wire::DisconnectRequest{channel, settings_.own});
}

void Tunnel::stop() {
  phase_ = Phase::kEnded;
  sending_ = Sending::kIdle;
  for (auto* deadline : {&request_deadline_, &heartbeat_deadline_, &resync_deadline_, &connect_deadline_})
    deadline->clear();
}

void Tunnel::close() {
  if (phase_ == Phase::kUp) {
    disconnect(channel_);
    // Nobody will be there to repeat it, and a lost one costs the server a tunnel for two minutes.
    if (!settings_.stream) disconnect(channel_);
  }
  stop();
}

void Tunnel::lost(std::string why) {
  if (phase_ != Phase::kEnded) end(Cause::kUnreachable, std::move(why));
}

void Tunnel::end(Cause cause, std::string why, std::uint8_t code) {
  const bool knows_channel = cause != Cause::kClosedByServer && cause != Cause::kForgotten;
  if (phase_ == Phase::kUp && knows_channel) disconnect(channel_);
  std::optional<Outcome> outcome;
  if (sending_ != Sending::kIdle) outcome = early_;
  if (sending_ == Sending::kWaitConfirmation && !settings_.stream) {
    ++counters_.unconfirmed;
    outcome = Outcome::kUnconfirmed;
  }
  stop();
  calls_.ended({cause, code, std::move(why), outcome});
}

}  // namespace rubicon::networks::knx::line
