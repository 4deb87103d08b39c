#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "apps/simulators/zigbee/world.h"
#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"

namespace rubicon::zigbee_simulator {

/// A world in virtual time and all that it publishes.
class SimulatedBridge : public ::testing::Test {
 protected:
  struct Published {
    std::string topic, payload;
    bool retain = false;
    nlohmann::json json() const { return nlohmann::json::parse(payload, nullptr, false); }
  };

  void make(WorldOptions options = {}) {
    world = std::make_unique<World>(std::move(options), time, Log(words, "world"));
    world->topics().publish = [this](transport::MqttPublication one) {
      published.push_back({one.topic.substr(one.topic.find('/') + 1), one.payload, one.retain});
    };
  }
  RadioDevice& add(std::string_view model, std::string name) {
    const auto added = world->add(find_model(model).value(), std::move(name));
    EXPECT_TRUE(added) << added.error().text;
    return **added;
  }
  /// Starts the world and forgets what it published of that.
  void start() {
    world->start();
    time.run_for(std::chrono::milliseconds(1));
    published.clear();
  }
  void ask(const std::string& topic, std::string_view payload) { world->received("zigbee2mqtt/" + topic, payload); }
  std::vector<std::string> topics() const {
    std::vector<std::string> all;
    for (const auto& one : published) all.push_back(one.topic);
    return all;
  }
  std::vector<nlohmann::json> of(std::string_view topic) const {
    std::vector<nlohmann::json> all;
    for (const auto& one : published) {
      if (one.topic == topic) all.push_back(one.json());
    }
    return all;
  }
  /// What a property was in each message of a device.
  std::vector<std::string> values(std::string_view name, const char* property) const {
    std::vector<std::string> all;
    for (const auto& message : of(name)) all.push_back(message.value(property, nlohmann::json("absent")).dump());
    return all;
  }

  VirtualScheduler time;
  support::CollectingLog words;
  std::unique_ptr<World> world;
  std::vector<Published> published;
};

}  // namespace rubicon::zigbee_simulator
