#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

namespace rubicon::bench::zigbee {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Plan {
  int rounds = 5;  ///< of the measurements in memory; medians are reported
  int devices = 300;
  int lists = 1164;                  ///< of a burst
  int states = 200'000;              ///< messages of a round
  std::chrono::seconds traffic{30};  ///< how long processor time of the daemon is measured
  int commands = 1000;
  int restarts = 20;  ///< of the broker, with and without persistence
};

/// 0 for none.
double median(std::vector<double> values);
/// `part` of the values are not above it; 0 <= part <= 1. 0 for none.
double percentile(std::vector<double> values, double part);
double milliseconds(Clock::duration span);
/// Rounded to this many decimals.
double rounded(double value, int digits);

// Each adds its figures (docs/benchmarks.md, "ZigBee"). The last three need mosquitto in a private network.
void measure_lists(const Plan& plan, Json& out);
void measure_states(const Plan& plan, Json& out);
void measure_traffic(const Plan& plan, Json& out);
void measure_commands(const Plan& plan, Json& out);
void measure_restarts(const Plan& plan, Json& out);

}  // namespace rubicon::bench::zigbee
