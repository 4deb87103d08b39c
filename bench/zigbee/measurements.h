#pragma once

#include <chrono>

#include "frame/figures.h"

namespace rubicon::bench::zigbee {

struct Plan {
  int rounds = 5;  ///< of the measurements in memory; medians are reported
  int devices = 300;
  int devices_of_longest_list = 4000;  ///< of 15 MB, nearly the longest packet
  int lists = 1164;                    ///< of a burst
  int states = 200'000;                ///< messages of a round
  std::chrono::seconds traffic{30};    ///< how long processor time of the daemon is measured
  int commands = 1000;
  int restarts = 20;  ///< of the broker, with and without persistence
};

// Each adds its figures (bench/README.md, "ZigBee"). The last four need mosquitto in a private network.
void measure_lists(const Plan& plan, Json& out);
void measure_texts(const Plan& plan, Json& out);
void measure_states(const Plan& plan, Json& out);
void measure_traffic(const Plan& plan, Json& out);
void measure_commands(const Plan& plan, Json& out);
void measure_gaps(const Plan& plan, Json& out);
void measure_restarts(const Plan& plan, Json& out);

}  // namespace rubicon::bench::zigbee
