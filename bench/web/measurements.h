#pragma once

#include <chrono>

#include "frame/figures.h"

namespace rubicon::bench::web {

struct Plan {
  int devices = 10'000;              ///< each has kPointsPerDevice points
  int rounds = 5;                    ///< of lists; medians are reported
  int connections = 64;              ///< at once
  std::chrono::seconds watched{10};  ///< how long processor time is measured
  std::chrono::seconds silence{10};  ///< of the client that reads nothing
};

// Each adds its figures (bench/README.md, "The page"). The peer is mosquitto's WebSocket listener.
void measure_updates(const Plan& plan, Json& out);
void measure_connections(const Plan& plan, Json& out);
void measure_slow_reader(const Plan& plan, Json& out);
void measure_values(const Plan& plan, Json& out);
void measure_devices(const Plan& plan, Json& out);
void measure_browser(const Plan& plan, Json& out);

}  // namespace rubicon::bench::web
