#include "bridges/mqtt/broker_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>
#include <utility>

namespace rubicon::bridges::mqtt {

namespace {

/// A busy line has sent some of what waits after this time.
constexpr Duration kRoomPause = std::chrono::milliseconds(10);
/// Named in the status; further ones are counted only.
constexpr std::size_t kMaxForbidden = 8;

Duration with_jitter(Duration pause) {
  static std::minstd_rand random{std::random_device{}()};
  return pause + pause * static_cast<int>(random() % 100) / 400;
}

}  // namespace

BrokerLine::BrokerLine(const BridgeHost& host, const transport::MqttBrokerOptions& options, transport::MqttWill will,
                       Callbacks calls)
    : host_(host),
      options_(options),
      will_(std::move(will)),
      callbacks_(std::move(calls)),
      log_({host.log, "bridge " + host.name}, host.scheduler) {}

transport::MqttCallbacks BrokerLine::line_calls() {
  transport::MqttCallbacks calls;
  calls.connected = [this](const transport::MqttConnack& connack) {
    connected_ = true;
    refused_ = false;
    ++connections_;
    reason_.clear();
    forbidden_.clear();
    pause_ = kFirstPause;
    limits_ = connack.retains ? "" : "the broker retains nothing: programs that connect later see no values";
    if (!limits_.empty()) log_.warning("retain", limits_);
    callbacks_.connected(connack);
  };
  calls.received = [this](const transport::MqttMessage& message) { callbacks_.received(message); };
  calls.refused = [this](std::string_view filter, const Error& why) {
    if (forbidden_.size() < kMaxForbidden) forbidden_.emplace(filter);
    log_.warning("filter", why.text);
  };
  calls.not_taken = [this](const transport::MqttOutcome& outcome, const Error& why) {
    if (forbidden_.size() < kMaxForbidden) forbidden_.emplace(outcome.topic);
    log_.warning("topic", why.text);
  };
  calls.failed = [this](const Error& why) { failed(why); };
  return calls;
}

void BrokerLine::open() {
  if (auto begun = begin(); !begun) failed(begun.error());
}

Result<void> BrokerLine::begin() {
  auto options = options_.with_password(host_.transports);
  if (!options) return fail(options.error());
  options->will = will_;
  auto line = host_.transports.open_mqtt(*options, line_calls());
  if (!line) return fail(std::move(line.error()));
  line_ = std::move(*line);
  return {};
}

void BrokerLine::failed(const Error& why) {
  if (line_) before_ += line_->counters();
  line_.reset();
  room_.cancel();
  dropped_ += waiting_.size();
  waiting_.clear();
  waiting_bytes_ = 0;
  // A broker that retains nothing refuses a will that is to be retained.
  if (why.code == ErrorCode::kUnsupported) will_.retain = false;
  refused_ = why.code == ErrorCode::kRefused;
  const bool was = std::exchange(connected_, false);
  if (std::exchange(reason_, why.text) != why.text || was) log_.warning("line", why.text + "; it is tried again");
  const auto pause = refused_ ? kRefusedPause : pause_;
  pause_ = std::min(2 * pause_, kMaxPause);
  retry_ = host_.scheduler.after(with_jitter(pause), [this] { open(); });
  if (was) callbacks_.lost();
}

void BrokerLine::subscribe(const std::string& filter, std::uint8_t qos) {
  if (!line_) return;
  if (auto asked = line_->subscribe(filter, qos); !asked) log_.warning("filter", asked.error().text);
}

void BrokerLine::unsubscribe(const std::string& filter) {
  if (line_) std::ignore = line_->unsubscribe(filter);
}

bool BrokerLine::publish(transport::MqttPublication publication) {
  if (!connected_ || room_.pending()) return false;
  if (is_burst(publication.topic.size() + publication.payload.size())) {
    await_room();
    return false;
  }
  const auto sent = line_->publish(std::move(publication));
  if (sent) return true;
  if (sent.error().code == ErrorCode::kBusy) {
    await_room();
    return false;
  }
  ++dropped_;
  log_.warning("publication", sent.error().text);
  return true;
}

bool BrokerLine::is_burst(std::size_t bytes) {
  const auto now = host_.scheduler.now();
  if (now - burst_began_ >= kRoomPause) {
    burst_began_ = now;
    burst_ = 0;
  }
  if (burst_ > kMaxBurst) return true;
  burst_ += bytes;
  return false;
}

void BrokerLine::publish_in_order(transport::MqttPublication publication) {
  if (waiting_.empty() && publish(publication)) return;
  const auto bytes = waiting_bytes_ + publication.topic.size() + publication.payload.size();
  if (connected_ && waiting_.size() < kMaxWaiting && bytes <= kMaxWaitingBytes) {
    waiting_bytes_ = bytes;
    waiting_.push_back(std::move(publication));
    return await_room();
  }
  ++dropped_;
  if (connected_) log_.warning("queue", "events are dropped: the broker is slow");
}

void BrokerLine::await_room() {
  if (!room_.pending()) room_ = host_.scheduler.after(kRoomPause, [this] { go_on(); });
}

void BrokerLine::go_on() {
  if (drain()) callbacks_.roomy();
}

/// False: it is busy again.
bool BrokerLine::drain() {
  while (!waiting_.empty()) {
    const auto& next = waiting_.front();
    const auto bytes = next.topic.size() + next.payload.size();
    if (!publish(next)) return false;
    waiting_bytes_ -= bytes;
    waiting_.pop_front();
  }
  return true;
}

BridgeStatus BrokerLine::status() const {
  auto sum = before_;
  if (line_) sum += line_->counters();
  BridgeStatus status;
  status.state = connected_ ? "up" : refused_ ? "refused" : "connecting";
  status.reason = connected_ ? limits_ : reason_;
  for (const auto& one : connected_ ? forbidden_ : std::set<std::string>())
    status.reason += fmt::format("{}the broker refuses {}", status.reason.empty() ? "" : "; ", one);
  status.peer = fmt::format("{}:{}", options_.line.host, options_.line.port);
  status.counters = {{"connections", connections_},
                     {"sent", sum.sent},
                     {"received", sum.received},
                     {"not-taken", sum.not_taken},
                     {"dropped", dropped_}};
  return status;
}

}  // namespace rubicon::bridges::mqtt
