#include "mqtt/bare_publisher.h"

#include <mqtt_protocol.h>

#include <stdexcept>

namespace rubicon::bench::mqtt {

namespace {

void check_library(int code) {
  if (code != MOSQ_ERR_SUCCESS) throw std::runtime_error(std::string("libmosquitto: ") + ::mosquitto_strerror(code));
}

}  // namespace

BarePublisher::BarePublisher(std::uint16_t port) {
  constexpr int kKeepAlive = 600, kLoopMs = 100;
  ::mosquitto_lib_init();
  client_ = ::mosquitto_new(nullptr, true, this);
  ::mosquitto_int_option(client_, MOSQ_OPT_PROTOCOL_VERSION, MQTT_PROTOCOL_V5);
  ::mosquitto_int_option(client_, MOSQ_OPT_TCP_NODELAY, 1);
  ::mosquitto_connect_callback_set(
      client_, [](mosquitto*, void* self, int code) { static_cast<BarePublisher*>(self)->accepted_ = code == 0; });
  check_library(::mosquitto_connect(client_, "127.0.0.1", port, kKeepAlive));
  while (!accepted_) check_library(::mosquitto_loop(client_, kLoopMs, 1));
}

BarePublisher::~BarePublisher() {
  ::mosquitto_disconnect(client_);
  ::mosquitto_destroy(client_);
}

void BarePublisher::publish(const std::string& topic, const std::string& payload) {
  check_library(
      ::mosquitto_publish(client_, nullptr, topic.c_str(), static_cast<int>(payload.size()), payload.data(), 0, true));
}

}  // namespace rubicon::bench::mqtt
