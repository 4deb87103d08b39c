#include "networks/zigbee/broker_line.h"

#include <fmt/format.h>

#include <utility>

#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee {

BrokerLine::BrokerLine(network::NetworkHost& host, transport::MqttBrokerOptions options, Callbacks calls)
    : host_(host), options_(std::move(options)), callbacks_(std::move(calls)) {}

transport::MqttCallbacks BrokerLine::line_calls() {
  transport::MqttCallbacks calls;
  calls.connected = [this](const transport::MqttConnack&) {
    connected_ = true;
    refusal_ = {};
    callbacks_.connected();
  };
  calls.received = [this](const transport::MqttMessage& message) { callbacks_.received(message); };
  calls.too_long = [this](std::string_view topic, std::size_t bytes) { callbacks_.too_long(topic, bytes); };
  calls.refused = [this](std::string_view filter, Error why) { callbacks_.forbidden(filter, why); };
  calls.taken = [this](const transport::MqttOutcome& outcome) { callbacks_.taken(outcome.topic); };
  calls.not_taken = [this](const transport::MqttOutcome& outcome, Error why) {
    callbacks_.not_taken(outcome.topic, why);
  };
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
    refusal_ = {};
    callbacks_.lost(std::move(why));
    return;
  }
  refusal_ = std::move(why);
  wait();
  callbacks_.refused();
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
  if (callbacks_.unsubscribed) callbacks_.unsubscribed(filter);
  return line_->unsubscribe(filter);
}

Result<void> BrokerLine::publish(std::string topic, std::string payload) {
  if (!connected_) return fail(ErrorCode::kUnreachable, "the broker is not connected");
  if (callbacks_.published) callbacks_.published(topic, payload);
  return line_->publish({std::move(topic), std::move(payload), false, 1, transport::MqttQueue::kInOrder});
}

transport::MqttCounters BrokerLine::counters() const {
  auto sum = before_;
  if (line_) sum += line_->counters();
  return sum;
}

using model::LineState;

BridgeState::BridgeState(Scheduler& scheduler, const std::string& base, std::function<void()> changed)
    : scheduler_(scheduler), base_(base), changed_(std::move(changed)) {}

void BridgeState::connected() {
  online_.reset();
  ++connections_;
  set(LineState::kConnecting, "waiting for Zigbee2MQTT");
  patience_ = scheduler_.after(kStateTime, [this] {
    set(LineState::kDown, fmt::format("Zigbee2MQTT is not there: the broker has no message on {}/bridge/state", base_));
  });
}

void BridgeState::lost(const std::string& why) {
  patience_.cancel();
  online_.reset();
  set(LineState::kDown, why);
}

Result<void> BridgeState::state(std::string_view payload, bool retained) {
  const auto online = bridge::read_online(payload);
  if (!online) return fail(online.error());
  const bool again = online_ == true && *online && scheduler_.now() - online_since_ > kRepetition;
  const bool fresh = online_ != *online;
  online_ = *online;
  if (*online) started_ = !retained;
  if (*online && (fresh || again)) online_since_ = scheduler_.now();
  if (fresh)
    decide();
  else if (again && line_ == LineState::kUp)
    changed_();
  return {};
}

void BridgeState::info(bridge::BridgeDescription info) {
  const auto version = bridge::check_version(info);
  unsupported_ = version ? std::string() : version.error().text;
  described_ = true;
  if (online_) decide();
}

void BridgeState::decide() {
  patience_.cancel();
  if (!unsupported_.empty()) return set(LineState::kRefused, unsupported_);
  if (!*online_) return set(LineState::kDown, "Zigbee2MQTT is offline");
  if (described_) return set(LineState::kUp, {});
  set(LineState::kConnecting, "waiting for bridge/info of Zigbee2MQTT");
  patience_ = scheduler_.after(kInfoTime, [this] { set(LineState::kUp, {}); });
}

void BridgeState::set(LineState line, std::string reason) {
  if (line_ == line && reason_ == reason) return;
  line_ = line;
  reason_ = std::move(reason);
  changed_();
}

namespace {

std::string first_of(const std::set<std::string>& topics) {
  return fmt::format("{}{}", model::quoted(*topics.begin()),
                     topics.size() == 1 ? "" : fmt::format(" and {} more", topics.size() - 1));
}

std::string who(const LineFacts& facts) {
  return facts.user.empty() ? "clients without a user" : "the user " + model::quoted(facts.user);
}

std::string missing_list(const LineFacts& facts) {
  if (facts.too_long)
    return fmt::format(
        "the list of devices was not read: it has {} bytes, more than largest-packet ({}); raise largest-packet",
        *facts.too_long, facts.largest_packet);
  if (!facts.retains)
    return "the list of devices was not received: the broker does not keep it for clients that come later; set "
           "mqtt.force_disable_retain of Zigbee2MQTT to false";
  if (!facts.others_came)
    return "the broker has no list of devices: it was restarted without its retained messages; restart Zigbee2MQTT";
  return fmt::format(
      "the list of devices was not received, though other messages of Zigbee2MQTT were: the broker limits the length "
      "of messages (mosquitto: message_size_limit, max_packet_size), or the list has more than largest-packet ({} "
      "bytes); raise that limit and restart Zigbee2MQTT",
      facts.largest_packet);
}

}  // namespace

std::string line_trouble(const LineFacts& facts) {
  if (!facts.forbidden.empty())
    return fmt::format("the broker forbids to subscribe to {}: let {} read {} in its access rules",
                       first_of(facts.forbidden), who(facts), model::quoted(facts.base + "/#"));
  if (facts.list_missing) return missing_list(facts);
  if (facts.silent_devices > 0)
    return fmt::format(
        "no state of any of {} devices: the access rules of the broker hide them (let {} read {}), or no device is in "
        "reach",
        facts.silent_devices, who(facts), model::quoted(facts.base + "/#"));
  if (!facts.not_taken.empty())
    return fmt::format("the broker does not take messages to {}: let {} write there in its access rules",
                       first_of(facts.not_taken), who(facts));
  return {};
}

}  // namespace rubicon::networks::zigbee
