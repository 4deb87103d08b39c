// Measures networks/wsn: rubicon-bench-motes prints one JSON object (bench/README.md, "Motes").
#include "frame/program.h"
#include "motes/measurements.h"

int main(int argc, char** argv) {
  using namespace rubicon::bench::motes;
  using namespace std::chrono_literals;
  const Plan quick{1, 5s, 3, 3s, 4s, 50, 1, 4, 1min};
  return rubicon::bench::run_program(argc, argv,
                                     {"rubicon-bench-motes", "Measures the network of motes beside bare peers"}, quick,
                                     {{"line-rate", measure_line_rate},
                                      {"sinks", measure_sinks},
                                      {"clients", measure_paced_clients},
                                      {"reboot", measure_reboot},
                                      {"restarts", measure_restarts},
                                      {"energy", measure_energy}});
}
