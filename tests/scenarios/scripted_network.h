#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "network/network.h"

namespace rubicon::scenarios {

/// A network whose devices are the test itself: what is sent down is kept, what comes up the test says.
class ScriptedNetwork final : public network::Network {
 public:
  ScriptedNetwork(std::pair<std::uint32_t, std::string> place, network::NetworkHost& host)
      : host_(host), place_(std::move(place)) {
    present()[place_] = this;
  }
  ~ScriptedNetwork() override { present().erase(place_); }
  ScriptedNetwork(const ScriptedNetwork&) = delete;
  ScriptedNetwork& operator=(const ScriptedNetwork&) = delete;

  Result<void> open() override {
    if (silent) return {};
    if (!cable) return fail(ErrorCode::kIo, "no carrier");
    host_.deliver("", model::State{.line = model::LineState::kUp, .reason = {}, .counters = {}});
    return {};
  }

  Result<void> send(const Message& message) override {
    sent.push_back(message);
    if (const auto* sample = std::get_if<model::Sample>(&message.body)) {
      sampled[message.destination.device] = *sample;
      acknowledge(message, sample->request);
    }
    if (const auto* actuate = std::get_if<model::Actuate>(&message.body)) {
      commands.push_back({message.destination.device, actuate->value});
      acknowledge(message, actuate->request);
    }
    return {};
  }

  void say(const std::string& device, model::Body body) { host_.deliver(device, std::move(body)); }
  /// A lost line is made again at the next attempt, unless the cable is out.
  void lose_line() { host_.failed({ErrorCode::kIo, "cable pulled"}); }
  network::NetworkHost& host() { return host_; }

  /// The live instance of an island's network; the test fails on a null one by crashing here.
  static ScriptedNetwork& of(std::uint32_t island, const std::string& id) { return *present().at({island, id}); }

  static Result<std::unique_ptr<network::Network>> make(const network::NetworkConfig& config,
                                                        network::NetworkHost& host) {
    return std::make_unique<ScriptedNetwork>(std::pair(number(config.island), config.id), host);
  }

  std::vector<Message> sent;
  std::map<std::string, model::Sample> sampled;  ///< last Sample per device
  std::vector<std::pair<std::string, Value>> commands;
  bool cable = true;
  bool silent = false;  ///< opens, and says nothing of its line

 private:
  void acknowledge(const Message& message, std::uint64_t request) {
    host_.deliver(message.destination.device, model::Acknowledge{request, model::Outcome::kSent, {}});
  }

  static std::map<std::pair<std::uint32_t, std::string>, ScriptedNetwork*>& present() {
    static std::map<std::pair<std::uint32_t, std::string>, ScriptedNetwork*> all;
    return all;
  }

  network::NetworkHost& host_;
  std::pair<std::uint32_t, std::string> place_;
};

inline constexpr network::NetworkType kScripted{.name = "scripted",
                                                .summary = "devices played by a test",
                                                .sample_config = "scripted-1: {type: scripted}\n",
                                                .make = &ScriptedNetwork::make};

}  // namespace rubicon::scenarios
