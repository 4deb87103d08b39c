#pragma once

#include <chrono>

#include "frame/figures.h"

namespace rubicon::bench::motes {

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

// Each adds its figures (bench/README.md, "Motes").
void measure_line_rate(const Plan& plan, Json& out);
void measure_sinks(const Plan& plan, Json& out);
void measure_paced_clients(const Plan& plan, Json& out);
void measure_reboot(const Plan& plan, Json& out);
void measure_restarts(const Plan& plan, Json& out);
void measure_energy(const Plan& plan, Json& out);

}  // namespace rubicon::bench::motes
