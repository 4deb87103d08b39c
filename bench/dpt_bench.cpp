#include <benchmark/benchmark.h>

#include "networks/knx/dpt/dpt.h"

// What it costs to read a payload of KNX; the goal is at most 20 ns for these types.

namespace rubicon::networks::knx::dpt {
namespace {

void dpt_decode(benchmark::State& state, DptId id, Bytes bytes) {
  const auto* type = find_dpt(id);
  const wire::PayloadView payload{bytes, type->bits <= 6};
  for (auto _ : state) {
    auto value = decode(*type, payload);
    benchmark::DoNotOptimize(value);
  }
}
BENCHMARK_CAPTURE(dpt_decode, 1.001, DptId{1, 1}, Bytes{0x01})->Name("DptDecode/1.001");
BENCHMARK_CAPTURE(dpt_decode, 5.001, DptId{5, 1}, Bytes{0x80})->Name("DptDecode/5.001");
BENCHMARK_CAPTURE(dpt_decode, 9.001, DptId{9, 1}, Bytes{0x0c, 0x33})->Name("DptDecode/9.001");
BENCHMARK_CAPTURE(dpt_decode, 13.001, DptId{13, 1}, Bytes{0xff, 0xff, 0xff, 0xfe})->Name("DptDecode/13.001");
BENCHMARK_CAPTURE(dpt_decode, 14.056, DptId{14, 56}, Bytes{0x41, 0xac, 0x00, 0x00})->Name("DptDecode/14.056");

}  // namespace
}  // namespace rubicon::networks::knx::dpt
