#pragma once

#include <chrono>

#include "frame/figures.h"

namespace rubicon::bench::mqtt {

struct Plan {
  int devices = 1000;  ///< of five points each
  std::chrono::seconds mirrored{10}, idle{30};
  int readings_per_second = 20'000;
  int commands = 1000;
  int restarts = 20;  ///< of the broker, which loses what it retained
  /// For the first minute a bridge reads what it publishes, to find what an earlier run left.
  std::chrono::seconds settled{65};
};

// Each adds its figures (bench/README.md, "MQTT bridge"); all need mosquitto in a private network.
void measure_announcement(const Plan& plan, Json& out);
void measure_mirror(const Plan& plan, Json& out);
void measure_commands(const Plan& plan, Json& out);
void measure_restarts(const Plan& plan, Json& out);
void measure_idle(const Plan& plan, Json& out);

}  // namespace rubicon::bench::mqtt
