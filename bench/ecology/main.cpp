#include "components/program.h"
#include "ecology/measurements.h"

int main(int count, char** values) {
  using namespace rubicon::bench;
  ComponentProgram program;
  program.purpose =
      "Measures the tuple space with several processes on this host, over DDS or in a folder. Prints one JSON object.";
  program.open_engine = open_one;
  program.engines = {"dds", "host"};
  program.measurements = {
      {"latency", measure_latency}, {"throughput", measure_throughput}, {"remote-sets", measure_remote_sets},
      {"joins", measure_joins},     {"memory", measure_memory},         {"crowd", measure_crowd},
      {"stops", measure_stops},     {"churn", measure_churn},           {"lamp", measure_lamp}};
  program.roles = {{"holder", holder},       {"taker", taker},         {"keeper", keeper},
                   {"bare-ping", bare_ping}, {"bare-pong", bare_pong}, {"bare-member", bare_member},
                   {"visitors", visitors},   {"lamp", lamp},           {"switcher", switcher}};
  program.add_options = add_crowd_options;
  program.highest_domain = rubicon::tuples::dds::kMaxDomain;
  return run_components(count, values, program);
}
