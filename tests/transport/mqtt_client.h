#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "transport/transports.h"

namespace rubicon::transport {

/// A line to a broker, and all that it said.
struct MqttClient {
  std::unique_ptr<MqttLine> line;
  int connected = 0;
  std::vector<std::string> heard;  ///< `topic payload`, with `*` if retained
  std::vector<std::string> refused;
  std::vector<Error> failures;

  void open(Transports& transports, const MqttOptions& options) {
    MqttCalls calls;
    calls.connected = [this] { ++connected; };
    calls.received = [this](const MqttMessage& message) {
      heard.push_back(std::string(message.topic) + ' ' + std::string(message.payload) + (message.retained ? "*" : ""));
    };
    calls.refused = [this](std::string_view filter, const Error&) { refused.emplace_back(filter); };
    calls.failed = [this](Error why) { failures.push_back(std::move(why)); };
    auto opened = transports.open_mqtt(options, std::move(calls));
    ASSERT_TRUE(opened) << opened.error().text;
    line = std::move(*opened);
  }
};

}  // namespace rubicon::transport
