// Measures bridges/mqtt: rubicon-bench-mqtt prints one JSON object (bench/README.md, "MQTT bridge").
#include "frame/program.h"
#include "mqtt/measurements.h"

int main(int argc, char** argv) {
  using namespace rubicon::bench::mqtt;
  using namespace std::chrono_literals;
  const Plan quick{50, 1s, 1s, 2000, 20, 2, 1s};
  return rubicon::bench::run_program(argc, argv,
                                     {"rubicon-bench-mqtt", "Measures the MQTT bridge beside a real broker"}, quick,
                                     {{"announcement", measure_announcement},
                                      {"mirror", measure_mirror},
                                      {"commands", measure_commands},
                                      {"restarts", measure_restarts},
                                      {"idle", measure_idle}});
}
