#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace rubicon::bench::motes {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Plan {
  int rounds = 3;                    ///< of each measurement; medians are reported
  std::chrono::seconds line{40};     ///< a round of the line rate
  int sinks = 100;                   ///< in one daemon
  std::chrono::seconds sampled{30};  ///< how long processor time is measured
  std::chrono::seconds silence{60};  ///< of the motes of these sinks
  int commands = 1000;               ///< unpaced, of all clients
  int reboots = 5;                   ///< of all motes, a round
  int restarts = 100;                ///< of the island
  std::chrono::minutes quiet{10};    ///< without a subscriber, and with one
};

/// 0 for none.
double median(std::vector<double> values);
/// `part` of the values are not above it; 0 <= part <= 1. 0 for none.
double percentile(std::vector<double> values, double part);
double milliseconds(Clock::duration span);
/// Rounded to this many decimals.
double rounded(double value, int digits);

// Each adds its figures (docs/benchmarks.md, "Motes").
void measure_line_rate(const Plan& plan, Json& out);
void measure_sinks(const Plan& plan, Json& out);
void measure_paced_clients(const Plan& plan, Json& out);
void measure_reboot(const Plan& plan, Json& out);
void measure_restarts(const Plan& plan, Json& out);
void measure_energy(const Plan& plan, Json& out);

}  // namespace rubicon::bench::motes
