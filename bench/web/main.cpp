// Measures src/web and web/: rubicon-bench-web prints one JSON object (bench/README.md, "The page"). It starts
// itself again as what is measured, or as what publishes to the peer.
#include <string_view>

#include "frame/program.h"
#include "web/measurements.h"
#include "web/roles.h"

int main(int argc, char** argv) {
  using namespace rubicon::bench::web;
  using namespace std::chrono_literals;
  if (const auto code = play_role(argc, argv)) return *code;
  const Plan quick{100, 1, 8, 1s, 1s};
  return rubicon::bench::run_program(argc, argv, {"rubicon-bench-web", "Measures the page, its server and its API"},
                                     quick,
                                     {{"updates", measure_updates},
                                      {"connections", measure_connections},
                                      {"slow-reader", measure_slow_reader},
                                      {"values", measure_values},
                                      {"devices", measure_devices},
                                      {"browser", measure_browser}});
}
