#include "networks/knx/line/tunnel_sender.h"

#include <algorithm>
#include <utility>

#include "base/assert.h"
#include "networks/knx/wire/blocks.h"
#include "networks/knx/wire/cemi.h"

namespace rubicon::networks::knx::line {

namespace {

using namespace std::chrono_literals;

// knx.md, section 5.1.
constexpr Duration kAckTime = 1s;
constexpr Duration kConfirmationTime = 3s;
/// A lost confirmation is repeated after 1 s; after 2 s knxd drops the channel without notice (knxd.md, section 6).
/// After this time the server is asked whether it still knows the channel.
constexpr Duration kConnectionCheckAfter = 2100ms;
/// A stream on which nothing arrives after the connection check is given up after this time.
constexpr Duration kStreamSilence = 3s;
/// How long the confirmation of an abandoned request is expected, so that it is not taken for the confirmation of an
/// identical request.
constexpr Duration kAbandonedTime = 5s;
/// How long the ack of a request is still awaited after its confirmation, which implies the ack.
constexpr Duration kAckGrace = 100ms;
/// The header and the connection header precede the cEMI frame of a request.
constexpr std::size_t kBeforeCemi = wire::kHeaderSize + 4;

}  // namespace

ByteView TunnelSender::Request::cemi() const {
  return ByteView(frame).subspan(kBeforeCemi);
}

TunnelSender::TunnelSender(Scheduler& scheduler, bool stream, TunnelCounters& counters, Callbacks callbacks)
    : scheduler_(scheduler),
      stream_(stream),
      counters_(counters),
      callbacks_(std::move(callbacks)),
      deadline_(scheduler, [this] { timeout(); }) {}

void TunnelSender::send(std::uint8_t channel, ByteView cemi) {
  RUBICON_ASSERT(idle());
  wire::write_connection_request(request_.frame, wire::ServiceCode::kTunnellingRequest, {channel, sequence_, 0}, cemi);
  request_.transmissions = 0;
  request_.early_outcome.reset();
  request_.shares_confirmation = false;
  if (stream_) {
    await_confirmation();
  } else {
    state_ = State::kAwaitsAck;
  }
  transmit_request();
}

void TunnelSender::transmit_request() {
  ++request_.transmissions;
  if (!stream_) deadline_.set(kAckTime);
  callbacks_.transmit(request_.frame);
}

void TunnelSender::receive_ack(const wire::ConnectionHeader& ack) {
  if (state_ != State::kAwaitsAck || ack.sequence != sequence_) return;
  if (ack.status == wire::status::kLayer) {
    ++sequence_;
    ++counters_.not_understood;
    return finish(Outcome::kNotUnderstood);
  }
  if (ack.status != wire::status::kOk) return ack_missing();
  await_confirmation();
  if (request_.early_outcome) finish(*request_.early_outcome);
}

void TunnelSender::await_confirmation() {
  ++sequence_;
  state_ = State::kAwaitsConfirmation;
  deadline_.set(kConnectionCheckAfter);
}

/// A confirmation without an ack shows that the ack was lost and the server accepted the request. Otherwise the request
/// is repeated once, and the server is asked whether it still knows the channel: some servers drop it without notice.
void TunnelSender::ack_missing() {
  ++counters_.missing_acks;
  if (request_.early_outcome) {
    await_confirmation();
    return finish(*request_.early_outcome);
  }
  if (request_.transmissions > 1) return callbacks_.gave_up("the interface does not acknowledge telegrams");
  ++counters_.repeats;
  transmit_request();
  callbacks_.check_connection();
}

void TunnelSender::timeout() {
  switch (state_) {
    case State::kIdle: return;
    case State::kAwaitsAck: return ack_missing();
    case State::kAwaitsConfirmation: return check_connection();
    case State::kServerSilent: return callbacks_.gave_up("the interface stopped responding");
    case State::kChecksConnection:
      if (!stream_) break;
      state_ = State::kServerSilent;
      return deadline_.set(kStreamSilence);
    case State::kConnectionChecked: break;
  }
  ++counters_.unconfirmed;
  finish(Outcome::kUnconfirmed);
}

void TunnelSender::check_connection() {
  state_ = State::kChecksConnection;
  deadline_.set(kConfirmationTime - kConnectionCheckAfter);
  callbacks_.check_connection();
}

void TunnelSender::server_is_alive() {
  if (state_ == State::kServerSilent) deadline_.set(Duration::zero());
  if (state_ == State::kServerSilent || state_ == State::kChecksConnection) state_ = State::kConnectionChecked;
}

std::optional<TunnelSender::Outcome> TunnelSender::receive_confirmation(ByteView cemi) {
  const auto outcome = outcome_of(cemi);
  if (!outcome) return std::nullopt;
  if (state_ == State::kAwaitsAck) {
    request_.early_outcome = outcome;
    deadline_.set_at(std::min(deadline_.due(), scheduler_.now() + kAckGrace));
    return std::nullopt;
  }
  state_ = State::kIdle;
  deadline_.clear();
  return outcome;
}

std::optional<TunnelSender::Outcome> TunnelSender::outcome_of(ByteView confirmation) {
  const bool of_abandoned = confirms_abandoned(confirmation);
  if (of_abandoned) request_.shares_confirmation = true;
  if (of_abandoned || idle() || !wire::confirms(confirmation, request_.cemi())) {
    ++counters_.late_confirmations;
    return std::nullopt;
  }
  if ((wire::control1_of(confirmation) & 1) == 0) return Outcome::kConfirmed;
  ++counters_.not_acknowledged;
  return Outcome::kNotAcknowledged;
}

bool TunnelSender::confirms_abandoned(ByteView confirmation) {
  if (abandoned_.cemi.empty()) return false;
  const bool expired = scheduler_.now() >= abandoned_.until;
  const bool confirms = !expired && wire::confirms(confirmation, abandoned_.cemi);
  if (expired || confirms) abandoned_.cemi.clear();
  return confirms;
}

void TunnelSender::finish(Outcome outcome) {
  state_ = State::kIdle;
  deadline_.clear();
  if (outcome == Outcome::kUnconfirmed && !request_.shares_confirmation) {
    const auto cemi = request_.cemi();
    abandoned_.cemi.assign(cemi.begin(), cemi.end());
    abandoned_.until = scheduler_.now() + kAbandonedTime;
  }
  callbacks_.finished(outcome);
}

std::optional<TunnelSender::Outcome> TunnelSender::stop() {
  deadline_.clear();
  const auto state = std::exchange(state_, State::kIdle);
  if (state == State::kIdle) return std::nullopt;
  if (state == State::kAwaitsAck) return request_.early_outcome;
  if (stream_) return std::nullopt;
  ++counters_.unconfirmed;
  return Outcome::kUnconfirmed;
}

}  // namespace rubicon::networks::knx::line
