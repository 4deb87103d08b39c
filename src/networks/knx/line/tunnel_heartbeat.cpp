#include "networks/knx/line/tunnel_heartbeat.h"

#include <utility>

#include "networks/knx/wire/status.h"

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

}  // namespace rubicon::networks::knx::line
