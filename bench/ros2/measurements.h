#pragma once

#include <chrono>

#include "frame/figures.h"

namespace rubicon::bench::ros2 {

struct Plan {
  int devices = 200;  ///< of five points each
  int pings = 5000;
  std::chrono::seconds flood{10}, idle{30};
};

// Each adds its figures (bench/README.md, "ROS 2 bridge"); all need a private network.
void measure_topics(const Plan& plan, Json& out);
void measure_latency(const Plan& plan, Json& out);
void measure_flood(const Plan& plan, Json& out);
void measure_idle(const Plan& plan, Json& out);

}  // namespace rubicon::bench::ros2
