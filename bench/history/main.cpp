// Measures src/history: rubicon-bench-history prints one JSON object (bench/README.md, "History").
#include "frame/program.h"
#include "history/measurements.h"

int main(int argc, char** argv) {
  using namespace rubicon::bench::history;
  return rubicon::bench::run_program(argc, argv, {"rubicon-bench-history", "Measures the history of values"},
                                     Plan{1000, 6, 7}, {{"day", measure_day}, {"month", measure_month}});
}
