// Measures networks/zigbee: rubicon-bench-zigbee prints one JSON object (bench/README.md, "ZigBee").
#include "frame/program.h"
#include "zigbee/measurements.h"

int main(int argc, char** argv) {
  using namespace rubicon::bench::zigbee;
  using namespace std::chrono_literals;
  const Plan quick{1, 30, 60, 60, 2000, 3s, 40, 2};
  return rubicon::bench::run_program(
      argc, argv, {"rubicon-bench-zigbee", "Measures the ZigBee network beside a real broker"}, quick,
      {{"lists", measure_lists},
       {"texts", measure_texts},
       {"states", measure_states},
       {"traffic", measure_traffic},
       {"commands", measure_commands},
       {"gaps", measure_gaps},
       {"restarts", measure_restarts}});
}
