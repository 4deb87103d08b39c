// Measures networks/knx: rubicon-bench-knx prints one JSON object (bench/README.md, "KNX").
#include "frame/program.h"
#include "knx/measurements.h"

int main(int argc, char** argv) {
  using namespace rubicon::bench::knx;
  const Plan quick{1, 1000, 40, 100'000, 1000, 200, 10'000, 5};
  return rubicon::bench::run_program(
      argc, argv, {"rubicon-bench-knx", "Measures the KNX network beside knxd and a bare loop"}, quick,
      {{"telegrams", measure_telegrams},
       {"loss", measure_loss},
       {"dpt", measure_dpt},
       {"import", measure_import},
       {"secure", measure_secure},
       {"projects", measure_projects}});
}
