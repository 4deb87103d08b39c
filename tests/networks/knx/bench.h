#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "networks/knx/knx_network.h"
#include "networks/knx/wire/address.h"
#include "support/config_text.h"
#include "support/fake_host.h"
#include "support/knx_server.h"

namespace rubicon::networks::knx {

using namespace std::chrono_literals;

inline constexpr std::string_view kHouse = R"({"host": "10.0.0.9", "telegrams-per-second": 0, "groups": {
  "1/0/1": {"dpt": "1.001", "kind": "actuator", "state": "1/0/2", "name": "Hall light"},
  "1/0/3": {"dpt": "5.001", "kind": "actuator", "name": "Dimmer without report"},
  "1/2/7": {"dpt": "9.001", "name": "Hall temperature", "listen": ["1/2/9"]},
  "1/2/8": {"dpt": "9.007", "read": "init"},
  "1/4/6": {"dpt": "5.001", "device": "living", "device-name": "Living room", "instance": "ceiling", "kind": "actuator"},
  "1/4/7": {"dpt": "9.004", "device": "living", "read": "every 1min"}}})";

/// A network in virtual time, and the KNXnet/IP server of memory that it talks to.
class KnxBench : public ::testing::Test {
 protected:
  void make(std::string_view options = kHouse) {
    const ConfigNode node = support::config_of(options);
    ConfigReader reader(node, "networks.knx", errors);
    auto made = kType.make({"knx", IslandId{1}, reader, types, {}}, host);
    reader.finish();
    ASSERT_TRUE(made) << errors.text();
    network = std::move(*made);
  }
  void start(std::string_view options = kHouse) {
    make(options);
    ASSERT_TRUE(network->open());
    host.time.run_for(1s);
  }
  Result<void> change(std::string_view options) {
    const ConfigNode node = support::config_of(options);
    ConfigReader reader(node, "networks.knx", errors);
    return network->change({"knx", IslandId{1}, reader, types, {}});
  }
  Result<void> send(model::Body body, const std::string& device, std::optional<model::Sender> sender = {}) {
    model::Message message;
    message.source.island = IslandId{70000};
    message.destination = {IslandId{1}, "knx", device};
    message.body = std::move(body);
    message.sender = std::move(sender);
    return network->send(message);
  }
  PointId point(Kind kind, std::string_view type, std::string instance = "1") const {
    return {kind, types.find(type)->id, std::move(instance)};
  }
  static std::uint16_t group(std::string_view text) { return number(wire::parse_group(text).value()); }

  /// Reads of this address that reached the bus.
  int reads_of(std::string_view address) const { return telegrams(address, {0x00, 0x00}); }
  int telegrams(std::string_view address, const Bytes& tpdu) const {
    int count = 0;
    for (const auto& one : server.heard()) count += one.destination == group(address) && one.tpdu == tpdu ? 1 : 0;
    return count;
  }
  /// The values a device reported, as text; `-` for a bad one.
  std::vector<std::string> values_of(const std::string& device) const {
    std::vector<std::string> texts;
    for (const auto& [from, updates] : host.all<model::Updates>()) {
      for (const auto& reading : updates.readings) {
        const auto text = model::to_text(reading.value);
        if (from == device) texts.push_back(text.empty() ? "-" : text);
      }
    }
    return texts;
  }
  model::State last_state() const {
    const auto all = host.all<model::State>();
    return all.empty() ? model::State() : all.back().second;
  }

  support::FakeHost host;
  support::KnxServer server{host.time, host.net};
  TypeCatalogue types;
  ConfigErrors errors;
  std::unique_ptr<network::Network> network;
};

}  // namespace rubicon::networks::knx
