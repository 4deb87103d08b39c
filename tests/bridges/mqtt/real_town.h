#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bridges/bridge.h"
#include "support/collecting_log.h"
#include "support/config_text.h"
#include "support/memory/mqtt_broker.h"
#include "support/mosquitto.h"
#include "support/private_network.h"
#include "transport/worlds.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::bridges::mqtt {

using namespace std::chrono_literals;

/// What a client sees that subscribes to all topics of a broker.
class Spy {
 public:
  explicit Spy(transport::MachineWorld& world) : world_(world) {
    transport::MqttCallbacks calls;
    calls.connected = [this](const transport::MqttConnack&) {
      EXPECT_TRUE(line_->subscribe("#", 1));
      EXPECT_TRUE(line_->publish({"spy", "0", false, 1}));
    };
    calls.received = [this](const transport::MqttMessage& message) {
      seen.emplace_back(message.topic, message.payload);
      correlation[seen.back().first] = message.correlation;
    };
    calls.failed = [](const Error& why) { ADD_FAILURE() << why.text; };
    transport::MqttOptions options;
    options.host = "127.0.0.1";
    line_ = world.local.open_mqtt(options, std::move(calls)).value();
    EXPECT_TRUE(world_.until([this] { return has("spy", "0"); }));
  }
  bool has(std::string_view topic, std::string_view payload) const {
    return std::any_of(seen.begin(), seen.end(),
                       [&](const auto& one) { return one.first == topic && one.second == payload; });
  }
  std::vector<std::string> payloads(std::string_view topic) const {
    std::vector<std::string> all;
    for (const auto& [at, payload] : seen)
      if (at == topic) all.push_back(payload);
    return all;
  }
  std::vector<std::string> topics_with(std::string_view text) const {
    std::vector<std::string> all;
    for (const auto& [topic, payload] : seen)
      if (topic.find(text) != topic.npos) all.push_back(topic);
    return all;
  }
  void publish(const std::string& topic, const std::string& payload) {
    EXPECT_TRUE(line_->publish({topic, payload, false, 1}));
  }
  /// Messages there and back, one after the other: what goes round would go round meanwhile.
  void rounds() {
    for (int i = 0; i < 50; ++i) {
      const auto text = std::to_string(++round_);
      publish("spy", text);
      EXPECT_TRUE(world_.until([&] { return has("spy", text); }));
    }
  }

  std::vector<std::pair<std::string, std::string>> seen;  ///< topics and payloads
  std::map<std::string, std::string> correlation;         ///< of the last message

 private:
  transport::MachineWorld& world_;
  int round_ = 0;
  std::unique_ptr<transport::MqttLine> line_;
};

/// A mosquitto in a network of its own; islands and bridges beside it in the time of the machine.
class RealTown : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!own_network.entered()) GTEST_SKIP() << own_network.reason();
    if (const auto missing = support::Mosquitto::missing(); !missing.empty()) GTEST_SKIP() << missing;
    begin({});
  }
  void TearDown() override {
    bridges.clear();
    components.clear();
  }
  void begin(support::MosquittoOptions options) {
    broker.reset();
    broker = std::make_unique<support::Mosquitto>(std::move(options));
    ASSERT_TRUE(world.until([this] { return broker->ready(); })) << broker->errors();
  }
  TupleSpace& component(std::uint32_t id) {
    auto& place = components[id];
    if (!place.space) {
      place.link = ecology.join(OwnerId(id)).value();
      place.space = std::make_unique<TupleSpace>(OwnerId(id), world.loop.scheduler(), *place.link);
    }
    return *place.space;
  }
  void put(std::uint32_t island, const std::string& key, const std::string& value) {
    ASSERT_TRUE(component(island).set(key, value)) << key;
  }
  /// With one device `proxy.knx.1` that has a lamp.
  void island(std::uint32_t id, const std::string& lamp = "off") {
    ASSERT_TRUE(component(id).describe(fmt::format(R"({{"name":"home {}","prefix":"proxy"}})", id)));
    put(id, "proxy.knx.status", R"({"line":"up"})");
    put(id, "proxy.knx.1.description", R"({"name":"Hall","actuators":["lamp-1"]})");
    put(id, "proxy.knx.1.status", R"({"status":"reachable"})");
    point(id, "actuator.lamp-1",
          R"({"type":"lamp","data_type":"boolean","unit":"1","access":"read-write","report":"state"})", lamp);
  }
  void point(std::uint32_t island, const std::string& at, const std::string& description, const std::string& value) {
    put(island, "proxy.knx.1." + at + ".description", description);
    put(island, "proxy.knx.1." + at + ".status", R"({"quality":"good"})");
    put(island, "proxy.knx.1." + at + ".value", value);
  }
  /// On a component of its own, for this island.
  Bridge& bridge(std::uint32_t component_id, std::uint32_t island, ConfigReader& options) {
    const BridgeHost host{
        "ha", world.loop.scheduler(), component(component_id), world.local, log, OwnerId(island), "proxy", judge};
    auto made = find_bridge_type("mqtt")->make(options, "", &host);
    EXPECT_TRUE(made) << options.errors().text();
    bridges.push_back(std::move(made));
    bridges.back()->start();
    return *bridges.back();
  }
  Bridge& bridge(std::uint32_t component_id, std::uint32_t island, const std::string& options) {
    configs.push_back(support::config_of(std::string_view(options)));
    base::ConfigErrors errors;
    ConfigReader reader(configs.back(), "bridges.ha", errors);
    return bridge(component_id, island, reader);
  }

  const support::PrivateNetwork own_network;
  transport::MachineWorld world;
  std::unique_ptr<support::Mosquitto> broker;
  support::CollectingLog log;
  tuples::MemoryEcology ecology{world.loop.scheduler()};
  tuples::Judge* judge = nullptr;
  struct Component {
    std::unique_ptr<tuples::Link> link;
    std::unique_ptr<TupleSpace> space;
  };
  std::map<std::uint32_t, Component> components;
  std::list<ConfigNode> configs;
  std::vector<std::unique_ptr<Bridge>> bridges;
};

}  // namespace rubicon::bridges::mqtt
