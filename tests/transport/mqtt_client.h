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
  std::vector<std::string> refused, taken, not_taken;
  std::vector<std::string> too_long;  ///< `topic bytes`
  std::vector<Error> failures;

  void open(Transports& transports, const MqttOptions& options) {
    MqttCalls calls;
    calls.connected = [this] { ++connected; };
    calls.received = [this](const MqttMessage& message) {
      received.push_back(std::string(message.topic) + ' ' + std::string(message.payload) +
                         (message.retained ? "*" : ""));
    };
    calls.too_long = [this](std::string_view topic, std::size_t bytes) {
      too_long.push_back(std::string(topic) + ' ' + std::to_string(bytes));
    };
    calls.refused = [this](std::string_view filter, const Error&) { refused.emplace_back(filter); };
    calls.taken = [this](std::string_view topic) { taken.emplace_back(topic); };
    calls.not_taken = [this](std::string_view topic, const Error& why) {
      not_taken.push_back(std::string(topic) + ' ' + why.text);
    };
    calls.failed = [this](Error why) { failures.push_back(std::move(why)); };
    auto opened = transports.open_mqtt(options, std::move(calls));
    ASSERT_TRUE(opened) << opened.error().text;
    line = std::move(*opened);
  }
};

}  // namespace rubicon::transport
