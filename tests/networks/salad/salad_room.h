#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "networks/salad/salad_network.h"
#include "support/config_text.h"
#include "support/fake_host.h"

namespace rubicon::networks::salad {

using namespace std::chrono_literals;
using model::LineState;

inline constexpr std::string_view kRoom = R"({"salad_host": "flat", "table": {
  "7": "FRIDGE,sensor.switch", "13": "BED,sensor.pressure", "28": "TV_STATE,sensor.status,LG",
  "30": "SOUNDPROB_TAP,sensor.soundrecognition.confidence", "46": "LIGHT,actuator.light,1/1/1",
  "66": "RELAY,actuator.relay", "68": "BLIND_STOP,sensor.status"}})";

/// A network on 127.0.0.1 and its SALAD on 192.168.1.141, `flat`.
class Salad : public ::testing::Test {
 protected:
  Salad() {
    host.net.name("flat", {"192.168.1.141"});
    flat.join(host.net, "192.168.1.141");
  }

  void make(std::string_view options = kRoom) {
    const ConfigNode node = support::config_of(options);
    ConfigReader reader(node, "networks.salad", errors);
    auto made = kType.make({"salad", IslandId{1}, reader, types, {}}, host);
    reader.finish();
    ASSERT_TRUE(made) << errors.text();
    network = std::move(*made);
  }
  void start(std::string_view options = kRoom) {
    make(options);
    listen();
    ASSERT_TRUE(network->open());
    host.time.run_for(1s);
  }
  /// SALAD begins to listen.
  void listen() {
    transport::UdpCallbacks calls;
    calls.received = [this](const transport::Endpoint& from, ByteView bytes) {
      source = from;
      asked.emplace_back(base::as_text(bytes));
    };
    calls.undelivered = [](const Error&) {};
    calls.failed = [](const Error&) {};
    salad = std::move(flat.open_udp({{"", 9000}, 2048}, std::move(calls)).value());
  }
  void say(std::string_view datagram) {
    ASSERT_TRUE(salad->send({"127.0.0.1", 9100}, base::as_bytes(datagram)));
    host.time.run_for(1ms);
  }
  Result<void> send(model::Body body, const std::string& device) {
    Message message;
    message.destination = {IslandId{1}, "salad", device};
    message.body = std::move(body);
    return network->send(message);
  }
  model::PointId point(Kind kind, std::string_view type, std::string instance) const {
    return {kind, types.find(type)->id, std::move(instance)};
  }
  Result<void> command(const std::string& device, const model::PointId& to, Value value) {
    return send(model::Actuate{5, to, std::move(value)}, device);
  }
  /// `7 sensor switch-fridge=on`, for each reading so far.
  std::vector<std::string> readings() const {
    std::vector<std::string> all;
    for (const auto& [device, updates] : host.all<model::Updates>()) {
      for (const auto& reading : updates.readings) {
        const auto& p = reading.point;
        all.push_back(fmt::format("{} {} {}-{}={}", device, to_string(p.kind), types.find(p.type)->name, p.instance,
                                  model::to_text(reading.value)));
        EXPECT_EQ(reading.user_time, WallTime{}) << "SALAD sends no times";
      }
    }
    return all;
  }
  std::map<std::string, std::uint64_t> counters() {
    host.time.run_for(2s);
    return host.all<model::State>().back().second.counters;
  }
  model::State state() const { return host.all<model::State>().back().second; }
  bool line_is(LineState line, std::string_view why) const { return state().line == line && state().reason == why; }
  std::vector<std::string> joined() const {
    std::vector<std::string> devices;
    for (const auto& [device, join] : host.all<model::Join>()) devices.push_back(device);
    return devices;
  }

  TypeCatalogue types;
  ConfigErrors errors;
  support::FakeHost host;
  transport::MemoryTransports flat;
  std::unique_ptr<transport::UdpSocket> salad;
  std::vector<std::string> asked;
  transport::Endpoint source;
  std::unique_ptr<network::Network> network;
};

}  // namespace rubicon::networks::salad
