#include <benchmark/benchmark.h>

#include "frame/program.h"

int main(int argc, char** argv) {
  if (rubicon::bench::refuses_to_measure("rubicon-bench")) return 2;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
