#include "components/program.h"
#include "sites/engine.h"
#include "sites/measurements.h"

int main(int count, char** values) {
  using namespace rubicon::bench;
  ComponentProgram program;
  program.purpose = "Measures the tuple space of several sites at mosquitto. Prints one JSON object.";
  program.open_engine = sites::open_at_broker;
  program.measurements = {{"latency", sites::measure_latency},
                          {"throughput", sites::measure_throughput},
                          {"remote-sets", sites::measure_remote_sets},
                          {"join", sites::measure_join},
                          {"idle", sites::measure_idle},
                          {"reading", sites::measure_reading},
                          {"restarts", sites::measure_restarts},
                          {"death", sites::measure_death},
                          {"crowd", sites::measure_crowd},
                          {"sites", sites::measure_sites}};
  program.roles = {{"bare-ping", sites::bare_ping},
                   {"bare-pong", sites::bare_pong},
                   {"steady-commander", sites::steady_commander},
                   {"steady-desk", sites::steady_desk},
                   {"idle-island", sites::idle_island},
                   {"many-sites", sites::many_sites},
                   {"lister", sites::lister},
                   {"switcher", sites::switcher}};
  program.awaits_by_name = true;
  program.add_options = sites::add_options;
  return run_components(count, values, program);
}
