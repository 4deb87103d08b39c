#include "zigbee/real_rig.h"

#include <unistd.h>

#include <stdexcept>

namespace rubicon::bench::zigbee {

using namespace std::chrono_literals;

RealRig::RealRig(Json& out, const std::string& what, bool persistent) {
  auto reason = support::Mosquitto::missing();
  if (reason.empty() && !network_.entered()) reason = network_.reason();
  if (!reason.empty()) {
    out[what + "_skipped"] = reason;
    return;
  }
  support::MosquittoOptions options;
  options.port = kPort;
  options.persistent = persistent;
  broker_.emplace(options);
  await_broker();
}

void RealRig::await_broker() {
  for (int i = 0; i < 2000 && !broker_->ready(); ++i) ::usleep(5'000);
  if (!broker_->ready()) throw std::runtime_error("mosquitto does not come up: " + broker_->errors());
}

void RealRig::run(Duration span) {
  const auto end = scheduler().after(span, [this] { loop_.stop(); });
  loop_.run();
}

void RealRig::run_until(const std::function<bool()>& done, const char* what) {
  for (int i = 0; i < 6000 && !done(); ++i) run(10ms);
  if (!done()) throw std::runtime_error(what);
}

std::unique_ptr<transport::MqttLine> RealRig::connect(std::function<void(const transport::MqttMessage&)> received,
                                                      transport::MqttOptions options,
                                                      std::function<void(std::string_view, std::size_t)> too_long) {
  options.host = "127.0.0.1";
  options.port = kPort;
  bool connected = false;
  transport::MqttCallbacks calls;
  calls.connected = [&connected](const transport::MqttConnack&) { connected = true; };
  calls.received = std::move(received);
  calls.too_long = std::move(too_long);
  calls.refused = [](std::string_view, const Error&) {};
  calls.failed = [](const Error& why) { throw std::runtime_error(why.text); };
  auto line = must(transports_.open_mqtt(options, std::move(calls)));
  run_until([&connected] { return connected; }, "no connection to mosquitto");
  return line;
}

void publish_bridge(transport::MqttLine& line, const std::string& list) {
  const auto say = [&line](const char* what, std::string payload) {
    transport::MqttPublication publication;
    publication.topic = std::string("zigbee2mqtt/bridge/") + what;
    publication.payload = std::move(payload);
    publication.retain = true;
    must(line.publish(std::move(publication)));
  };
  say("info", std::string(kBridgeInfo));
  say("state", R"({"state":"online"})");
  say("devices", list);
}

}  // namespace rubicon::bench::zigbee
