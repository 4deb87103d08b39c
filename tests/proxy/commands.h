#pragma once

#include <string>
#include <vector>

#include "gateway/gateway.h"
#include "island.h"

namespace rubicon::proxy {

inline const std::string kFlapPoint = "proxy.hall.7.actuator.flap-1";
inline const std::string kFlapCommand = kFlapPoint + ".command";

/// Commands to the lamp `hall/7`, which has an actuator of each sort.
class Commands : public Island {
 protected:
  void begin() {
    start();
    auto message = lamp();
    message.capabilities.push_back(capability(Kind::kActuator, kKnob));
    message.capabilities.back().minimum = 10;
    message.capabilities.back().maximum = 200;
    message.capabilities.push_back(capability(Kind::kActuator, kChime));
    message.capabilities.push_back(capability(Kind::kActuator, kMood));
    message.capabilities.back().reports = false;
    message.capabilities.push_back(capability(Kind::kProperty, kKnob, ""));
    message.capabilities.push_back(capability(Kind::kProperty, kMood, ""));
    message.capabilities.back().access = Access::kRead;
    join("7", message);
  }
  std::vector<model::Actuate> actuated() { return hall().sent_bodies<model::Actuate>(); }
  nlohmann::json command(const std::string& point = kFlapPoint) const { return json(point + ".status")["command"]; }
  /// All states a point's command goes through from now on, as `request:state`.
  void record(const std::string& point) {
    ears = space->subscribe({kIsland, point + ".status"}, {.passive = true}, [this](const Event& event) {
      const auto status = nlohmann::json::parse(event.tuple.value);
      if (!status.contains("command")) return;
      const auto line =
          std::to_string(status["command"]["request"].get<int>()) + ":" + status["command"]["state"].get<std::string>();
      if (states.empty() || states.back() != line) states.push_back(line);
    });
  }
  void sleep() {
    time.run_for(61s);
    ASSERT_EQ(json("proxy.hall.7.status")["status"], "unreachable");
  }
  tuples::Handle ears;
  std::vector<std::string> states;
};

}  // namespace rubicon::proxy
