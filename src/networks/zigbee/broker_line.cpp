#include "networks/zigbee/broker_line.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::networks::zigbee {

BrokerLine::BrokerLine(network::NetworkHost& host, transport::MqttBrokerOptions options, Calls calls)
    : host_(host), options_(std::move(options)), calls_(std::move(calls)) {}

transport::MqttCalls BrokerLine::line_calls() {
  transport::MqttCalls calls;
  calls.connected = [this](const transport::MqttConnack&) {
    connected_ = true;
    refusal_.clear();
    calls_.connected();
  };
  calls.received = [this](const transport::MqttMessage& message) { calls_.received(message); };
  calls.too_long = [this](std::string_view topic, std::size_t bytes) { calls_.too_long(topic, bytes); };
  calls.refused = [this](std::string_view filter, Error why) { calls_.forbidden(filter, why); };
  calls.taken = [this](const transport::MqttOutcome& outcome) { calls_.taken(outcome.topic); };
  calls.not_taken = [this](const transport::MqttOutcome& outcome, Error why) { calls_.not_taken(outcome.topic, why); };
  calls.failed = [this](Error why) { failed(std::move(why)); };
  return calls;
}

Result<void> BrokerLine::open() {
  if (line_ || retry_.pending()) return {};
  next_attempt_ = {};
  warn_of_password();
  const auto options = options_.with_password(host_.transports());
  if (!options) return fail(options.error());
  auto line = host_.transports().open_mqtt(*options, line_calls());
  if (!line) return fail(std::move(line.error()));
  line_ = std::move(*line);
  return {};
}

/// Not at each attempt: a lost broker is tried for ever.
void BrokerLine::warn_of_password() {
  if (warned_) return;
  const auto warning = options_.password_warning(host_.transports());
  warned_ = !warning.empty();
  if (warned_) host_.log().warning(warning);
}

void BrokerLine::close() {
  retry_.cancel();
  next_attempt_ = {};
  drop_line();
}

void BrokerLine::drop_line() {
  if (line_) before_ = counters();
  connected_ = false;
  line_.reset();
}

void BrokerLine::failed(Error why) {
  drop_line();
  if (why.code != ErrorCode::kRefused) {
    refusal_.clear();
    calls_.lost(std::move(why));
    return;
  }
  refusal_ = std::move(why.text);
  wait();
  calls_.refused();
}

void BrokerLine::wait() {
  next_attempt_ = host_.scheduler().wall_now() + std::chrono::duration_cast<WallTime::duration>(kRefusedPause);
  retry_ = host_.scheduler().after(kRefusedPause, [this] { retry(); });
}

bool BrokerLine::reopen() {
  if (!retry_.pending()) return false;
  retry_ = host_.scheduler().after(Duration::zero(), [this] { retry(); });
  return true;
}

void BrokerLine::retry() {
  ++attempts_;
  if (auto opened = open(); !opened) failed(std::move(opened.error()));
}

/// QoS 1 for what the bridge publishes with it and seldom repeats (zigbee.md, section 1).
Result<void> BrokerLine::subscribe(std::string_view filter) {
  if (!connected_) return fail(ErrorCode::kUnreachable, "the broker is not connected");
  const bool seldom = filter.ends_with("/bridge/state") || filter.ends_with("/availability");
  return line_->subscribe(filter, seldom ? 1 : 0);
}

Result<void> BrokerLine::unsubscribe(std::string_view filter) {
  if (!connected_) return fail(ErrorCode::kUnreachable, "the broker is not connected");
  return line_->unsubscribe(filter);
}

Result<void> BrokerLine::publish(std::string topic, std::string payload) {
  if (!connected_) return fail(ErrorCode::kUnreachable, "the broker is not connected");
  return line_->publish({std::move(topic), std::move(payload), false, 1, transport::MqttQueue::kInOrder});
}

transport::MqttCounters BrokerLine::counters() const {
  auto sum = before_;
  if (line_) sum += line_->counters();
  return sum;
}

}  // namespace rubicon::networks::zigbee
