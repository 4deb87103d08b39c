#include "apps/simulators/zigbee/broker_line.h"

#include <fmt/format.h>

namespace rubicon::zigbee_simulator {

namespace {

using namespace std::chrono_literals;

/// A real bridge tries again each second.
constexpr Duration kBetweenAttempts = 1s;

}  // namespace

BrokerLine::BrokerLine(World& world, transport::MqttOptions options, Scheduler& scheduler,
                       transport::Transports& transports, Log log)
    : world_(world),
      options_(std::move(options)),
      scheduler_(scheduler),
      transports_(transports),
      log_(std::move(log)) {
  options_.will = transport::MqttWill{world.options().base + "/bridge/state", R"({"state":"offline"})", true};
  world_.publish = [this](transport::MqttPublication publication) { send(std::move(publication)); };
  world_.named = [this](const std::string& name, bool used) { named(name, used); };
}

BrokerLine::~BrokerLine() {
  world_.publish = nullptr;
  world_.named = nullptr;
}

Result<void> BrokerLine::open() {
  transport::MqttCalls calls;
  calls.connected = [this](const transport::MqttConnack&) { on_connected(); };
  calls.received = [this](const transport::MqttMessage& message) {
    if (!message.retained) world_.received(message.topic, message.payload);
  };
  calls.refused = [this](std::string_view filter, const Error& why) {
    log_.error(fmt::format("the broker refuses the subscription to {}: {}", filter, why.text));
  };
  calls.failed = [this](const Error& why) { failed(why); };
  auto opened = transports_.open_mqtt(options_, std::move(calls));
  if (!opened) return fail(opened.error());
  line_ = std::move(*opened);
  return {};
}

void BrokerLine::on_connected() {
  connected_ = true;
  last_error_.clear();
  log_.info(fmt::format("connected to {}:{}", options_.host, options_.port));
  listen();
  if (std::exchange(had_started_, true)) return world_.reconnected();
  world_.start();
  if (started) started();
}

void BrokerLine::failed(const Error& why) {
  connected_ = false;
  line_.reset();
  if (why.text != last_error_) log_.error(why.text);
  last_error_ = why.text;
  again_ = scheduler_.after(kBetweenAttempts, [this] {
    if (const auto opened = open(); !opened) failed(opened.error());
  });
}

/// The filters of one name: `NAME/set/#` is for `NAME/set` too.
void BrokerLine::named(const std::string& name, bool used) {
  if (used) {
    names_.insert(name);
  } else {
    names_.erase(name);
  }
  if (!connected_) return;
  for (const auto* verb : {"/set/#", "/get/#"}) {
    const auto filter = world_.options().base + "/" + name + verb;
    const auto asked = used ? line_->subscribe(filter) : line_->unsubscribe(filter);
    if (!asked) log_.error(asked.error().text);
  }
}

void BrokerLine::listen() {
  if (const auto asked = line_->subscribe(world_.options().base + "/bridge/request/#"); !asked)
    log_.error(asked.error().text);
  for (const auto& name : std::set<std::string>(names_)) named(name, true);
}

void BrokerLine::send(transport::MqttPublication publication) {
  const auto sent = connected_ ? line_->publish(std::move(publication)) : fail(ErrorCode::kUnreachable, "no broker");
  if (!sent) ++lost_;
}

}  // namespace rubicon::zigbee_simulator
