#include "components/program.h"
#include "peis/measurements.h"

int main(int count, char** values) {
  using namespace rubicon::bench;
  return run_components(
      count, values,
      {"Measures the tuple space over PEIS with several processes on this host. Prints one JSON object.",
       open_peis,
       {{"latency", peis::measure_latency},
        {"throughput", peis::measure_throughput},
        {"remote-sets", peis::measure_remote_sets},
        {"join", peis::measure_join},
        {"stall", peis::measure_stall},
        {"death", peis::measure_death},
        {"crowd", peis::measure_crowd},
        {"kernel", peis::measure_kernel}},
       {{"bare-ping", peis::bare_ping},
        {"bare-pong", peis::bare_pong},
        {"bare-source", peis::bare_source},
        {"bare-sink", peis::bare_sink},
        {"slow-kernel", peis::slow_kernel}}});
}
