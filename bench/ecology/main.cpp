#include "components/program.h"
#include "ecology/measurements.h"
#include "ecology/trust/measurements.h"

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
      {"churn", measure_churn}};
  program.of_trust = {{"latency", trust::measure_latency},
                      {"throughput", trust::measure_throughput},
                      {"remote-sets", trust::measure_remote_sets},
                      {"meeting", trust::measure_meeting},
                      {"memory", trust::measure_memory},
                      {"get", trust::measure_get},
                      {"crowd", trust::measure_crowd},
                      {"renewal", trust::measure_renewal}};
  program.roles = {
      {"holder", holder},          {"taker", taker},         {"keeper", keeper},        {"bare-ping", bare_ping},
      {"bare-pong", bare_pong},    {"visitors", visitors},   {"stayer", trust::stayer}, {"newcomer", trust::newcomer},
      {"renewer", trust::renewer}, {"reader", trust::reader}};
  program.highest_domain = rubicon::tuples::dds::kMaxDomain;
  return run_components(count, values, program);
}
