#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/virtual_scheduler.h"
#include "network/supervisor.h"
#include "proxy/proxy.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::proxy {

using namespace std::chrono_literals;
using model::Acknowledge;
using model::Join;
using model::Outcome;
using tuples::Event;
using tuples::Flow;
using tuples::Reply;
using tuples::Verdict;

/// Types of these tests only, so that they do not depend on the catalogue.
inline constexpr TypeId kGlow{0x8001}, kFlap{0x8002}, kKnob{0x8003}, kChime{0x8004}, kMood{0x8005};

TypeCatalogue test_types();

/// A network whose devices are played by the test.
class PlayedNetwork final : public network::Network {
 public:
  PlayedNetwork(std::string id, network::NetworkHost& host) : id_(std::move(id)), host_(host) { present()[id_] = this; }
  ~PlayedNetwork() override { present().erase(id_); }

  Result<void> open() override;
  Result<void> send(const Message& message) override;

  void say(const std::string& device, model::Body body) { host_.deliver(device, std::move(body)); }
  void lose_line();
  template <class Body>
  std::vector<Body> sent_bodies() const {
    std::vector<Body> bodies;
    for (const auto& message : sent) {
      if (const auto* body = std::get_if<Body>(&message.body)) bodies.push_back(*body);
    }
    return bodies;
  }

  static std::map<std::string, PlayedNetwork*>& present();
  static Result<std::unique_ptr<network::Network>> make(const network::NetworkConfig& config,
                                                        network::NetworkHost& host);

  std::vector<Message> sent;
  std::map<std::string, model::Sample> sampled;  ///< the last Sample of each device
  bool line_works = true;
  bool announces = true;  ///< State{kUp} after open
  bool answers = true;    ///< acknowledges requests
  Outcome outcome = Outcome::kSent;
  std::string why;

 private:
  std::string id_;
  network::NetworkHost& host_;
};

struct LogLines final : base::LogSink {
  void write(base::LogLevel, std::string_view, std::string_view text) override { lines.emplace_back(text); }
  bool contain(const std::string& part) const;
  std::vector<std::string> lines;
};

struct NoTransports final : transport::Transports {
  Result<std::unique_ptr<transport::FileSource>> open_file(const std::string& path) override {
    return fail(ErrorCode::kNotFound, path);
  }
};

Capability capability(Kind kind, TypeId type, const std::string& instance = "1");
inline PointId sensor(TypeId type, const std::string& instance = "1") {
  return {Kind::kSensor, type, instance};
}
inline PointId actuator(TypeId type, const std::string& instance = "1") {
  return {Kind::kActuator, type, instance};
}
model::Updates updates(const PointId& point, Value value, WallTime user_time = {});

/// An island 6541 with one network `hall`, and a component 70001 beside it.
class Island : public ::testing::Test {
 protected:
  static constexpr OwnerId kIsland{6541}, kRobot{70001};

  Island();
  ~Island() override;
  /// Call once, first. Change the configuration before.
  void start();
  /// Ends everything but the state file and the robot, and starts again.
  void restart();
  /// Gives the island a state file. Call before start.
  void remember();
  PlayedNetwork& hall() { return *PlayedNetwork::present().at("hall"); }
  NetworkRules& rules() { return config.networks["hall"]; }

  /// A lamp: sensors glow-1 and glow-2, actuator flap-1.
  Join lamp() const;
  void join(const std::string& device, const Join& message) { say(device, message); }
  void say(const std::string& device, model::Body body);
  void report(const std::string& device, const PointId& point, Value value, WallTime user_time = {});

  bool exists(const std::string& key) const { return space->get(kIsland, key).has_value(); }
  std::string text(const std::string& key) const;
  nlohmann::json json(const std::string& key) const { return nlohmann::json::parse(text(key)); }
  std::string quality(const std::string& point) const { return json(point + ".status")["quality"]; }
  std::string command_state(const std::string& point) const;
  /// The robot sets a tuple of the island and gets the answer.
  Reply set(const std::string& key, const std::string& value, Duration time_to_live = 0s);

  VirtualScheduler time;
  tuples::MemoryEcology ecology{time};
  LogLines log;
  TypeCatalogue types = test_types();
  NoTransports transports;
  ProxyConfig config;
  gateway::GatewayLimits limits;
  state::StateOptions state_options;
  std::unique_ptr<tuples::Link> link, robot_link;
  std::unique_ptr<TupleSpace> space, robot;
  std::unique_ptr<gateway::Gateway> gate;
  std::unique_ptr<network::Supervisor> networks;
  std::unique_ptr<state::StateStore> store;
  std::unique_ptr<Proxy> proxy;

 private:
  void end();
  std::string state_file_;
};

}  // namespace rubicon::proxy
