#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "transport/transports.h"

namespace rubicon::transport {

/// A line to a broker, and all that it reported.
struct MqttClient {
  std::unique_ptr<MqttLine> line;
  int connected = 0;
  std::vector<std::string> received;  ///< `topic payload`, with `*` if retained
  MqttConnack connack;                ///< without its client id
  std::vector<std::string> subscribed, refused, taken, not_taken;
  std::vector<std::string> outcomes;  ///< `number reason`, of both kinds
  std::vector<std::string> order;     ///< of `received`, and of `subscribed` as `+filter`
  std::vector<std::string> asked;     ///< `response topic|correlation|seconds` of messages that want an answer
  std::vector<std::string> too_long;  ///< `topic bytes`
  std::vector<Error> failures;

  static std::string text_of(const MqttOutcome& outcome) {
    return std::to_string(outcome.number) + ' ' + std::to_string(static_cast<int>(outcome.reason));
  }
  void open(Transports& transports, const MqttOptions& options) {
    MqttCallbacks calls;
    calls.connected = [this](const MqttConnack& told) {
      ++connected;
      connack = told;
    };
    calls.received = [this](const MqttMessage& message) {
      received.push_back(std::string(message.topic) + ' ' + std::string(message.payload) +
                         (message.retained ? "*" : ""));
      order.push_back(received.back());
      if (message.response_topic.empty()) return;
      const auto seconds = std::chrono::ceil<std::chrono::seconds>(message.expiry).count();
      asked.push_back(std::string(message.response_topic) + '|' + std::string(message.correlation) + '|' +
                      std::to_string(seconds));
    };
    calls.too_long = [this](std::string_view topic, std::size_t bytes) {
      too_long.push_back(std::string(topic) + ' ' + std::to_string(bytes));
    };
    calls.refused = [this](std::string_view filter, const Error&) { refused.emplace_back(filter); };
    calls.subscribed = [this](std::string_view filter) {
      subscribed.emplace_back(filter);
      order.push_back('+' + std::string(filter));
    };
    calls.taken = [this](const MqttOutcome& outcome) {
      taken.emplace_back(outcome.topic);
      outcomes.push_back(text_of(outcome));
    };
    calls.not_taken = [this](const MqttOutcome& outcome, const Error& why) {
      not_taken.push_back(std::string(outcome.topic) + ' ' + why.text);
      outcomes.push_back(text_of(outcome));
    };
    calls.failed = [this](Error why) { failures.push_back(std::move(why)); };
    auto opened = transports.open_mqtt(options, std::move(calls));
    ASSERT_TRUE(opened) << opened.error().text;
    line = std::move(*opened);
  }
};

}  // namespace rubicon::transport
