#include "tuples/mqtt/uplink.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>
#include <utility>

namespace rubicon::tuples::mqtt {

namespace {

constexpr Duration kFirstPause = std::chrono::milliseconds(500), kMaxPause = std::chrono::seconds(10);
/// A wrong password does not become right by repetition.
constexpr Duration kRefusedPause = std::chrono::seconds(30);

}  // namespace

std::vector<SpaceBroker> with_spare(SpaceBroker first, const std::vector<base::HostPort>& spare) {
  std::vector<SpaceBroker> all{std::move(first)};
  for (const auto& [host, port] : spare) {
    all.push_back(all.front());
    all.back().line.host = host;
    all.back().line.port = port;
  }
  return all;
}

Duration about(Duration time) {
  std::random_device source;
  return time / 2 + time * (source() % 1000) / 1000;
}

Uplink::Uplink(std::vector<SpaceBroker> brokers, Duration keep_alive, Scheduler& scheduler,
               transport::Transports& transports, base::LimitedLog& log, Callbacks calls)
    : brokers_(std::move(brokers)),
      keep_alive_(keep_alive),
      scheduler_(scheduler),
      transports_(transports),
      log_(log),
      callbacks_(std::move(calls)),
      pause_(kFirstPause) {}

Result<void> Uplink::open() {
  failing_since_ = scheduler_.now();
  return connect();
}

Result<void> Uplink::connect() {
  auto options = broker().line;
  options.keep_alive = keep_alive_;
  options.will = callbacks_.begins(broker().user);
  auto opened = transports_.open_mqtt(options, calls());
  if (!opened) return fail(std::move(opened.error()));
  line_ = std::move(*opened);
  return {};
}

transport::MqttCallbacks Uplink::calls() {
  transport::MqttCallbacks calls;
  calls.connected = [this](const transport::MqttConnack& connack) { on_connected(connack); };
  calls.received = callbacks_.received;
  calls.too_long = [this](std::string_view topic, std::size_t bytes) {
    log_.warning("too long", fmt::format("a message of {} bytes at {} is dropped", bytes, topic));
  };
  calls.refused = [this](std::string_view filter, const Error& why) {
    log_.warning("refused", fmt::format("the broker refuses {}: {}", filter, why.text));
  };
  calls.taken = callbacks_.taken;
  calls.not_taken = callbacks_.not_taken;
  calls.failed = [this](const Error& why) { on_failed(why); };
  return calls;
}

std::string Uplink::name(std::size_t number) const {
  return fmt::format("{}:{}", brokers_[number].line.host, brokers_[number].line.port);
}

void Uplink::on_connected(const transport::MqttConnack& connack) {
  if (!connack.retains)
    return on_failed({ErrorCode::kRefused, "the broker keeps no retained messages, which presence needs"});
  connected_ = true;
  pause_ = kFirstPause;
  trouble_.clear();
  refusals_ = 0;
  log_.unlimited().info(fmt::format("connected with {} {}", name(at_),
                                    broker().user == kAnonymous ? "without a user" : "as " + broker().user));
  if (at_ > 0) look_back_ = scheduler_.after(about(kLookBack), [this] { look_back(0); });
  callbacks_.connected(connack);
}

/// If a broker refuses this process, the others are tried first. If all refuse, attempts become rare.
void Uplink::on_failed(const Error& why) {
  const bool was_up = std::exchange(connected_, false), refused = why.code == ErrorCode::kRefused;
  line_.reset();
  look_back_.cancel();
  scout_.reset();
  trouble_ = why.text;
  log_.warning("connection", fmt::format("{}: {}", name(at_), why.text));
  const auto now = scheduler_.now();
  if (was_up) failing_since_ = now;
  if (refused && ++refusals_ % brokers_.size() == 0) {
    pause_ = kRefusedPause;
    at_ = (at_ + 1) % brokers_.size();
  } else if (brokers_.size() > 1 && (refused || now - failing_since_ >= kPatience)) {
    at_ = (at_ + 1) % brokers_.size();
    failing_since_ = now;
    pause_ = kFirstPause;
  }
  connect_later();
  if (was_up) callbacks_.lost();
}

void Uplink::connect_later() {
  retry_ = scheduler_.after(about(pause_), [this] {
    if (auto begun = connect(); !begun) {
      trouble_ = begun.error().text;
      log_.warning("connection", begun.error().text);
      connect_later();
    }
  });
  pause_ = std::min(2 * pause_, std::max(pause_, kMaxPause));
}

/// Asks the earlier brokers, one after the other.
void Uplink::look_back(std::size_t number) {
  scout_.reset();
  if (number == at_) {
    look_back_ = scheduler_.after(about(kLookBack), [this] { look_back(0); });
    return;
  }
  transport::MqttCallbacks calls;
  calls.connected = [this, number](const transport::MqttConnack& connack) {
    look_back_ = scheduler_.after(
        {}, [this, number, retains = connack.retains] { retains ? go_back(number) : look_back(number + 1); });
  };
  calls.received = [](const transport::MqttMessage&) {};
  calls.failed = [this, number](const Error&) {
    look_back_ = scheduler_.after({}, [this, number] { look_back(number + 1); });
  };
  auto options = brokers_[number].line;
  options.keep_alive = keep_alive_;
  auto opened = transports_.open_mqtt(options, std::move(calls));
  if (opened) scout_ = std::move(*opened);
  if (!opened) look_back_ = scheduler_.after(about(kLookBack), [this] { look_back(0); });
}

void Uplink::go_back(std::size_t number) {
  log_.unlimited().info(fmt::format("{} is there again: leaving {}", name(number), name(at_)));
  scout_.reset();
  callbacks_.leaves();
  connected_ = false;
  line_.reset();
  at_ = number;
  failing_since_ = scheduler_.now();
  callbacks_.lost();
  if (auto begun = connect(); !begun) connect_later();
}

}  // namespace rubicon::tuples::mqtt
