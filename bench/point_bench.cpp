#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <malloc.h>

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/virtual_scheduler.h"
#include "config/yaml.h"
#include "ets_export.h"
#include "island/island.h"
#include "island/network_types.h"
#include "support/memory/memory_transports.h"
#include "tuples/memory/memory_ecology.h"

// What a point of a large KNX list takes in memory, beside its tuples in the store alone.

namespace rubicon {
namespace {

template <class T>
T must_parse(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().text);
  return std::move(*result);
}

/// Of the heap, what is handed out now.
double in_use() {
  ::malloc_trim(0);
  const auto heap = ::mallinfo2();
  return static_cast<double>(heap.uordblks + heap.hblkhd);
}

void memory_of_points(benchmark::State& state) {
  const auto addresses = static_cast<int>(state.range(0));
  double island_bytes = 0, store_bytes = 0, tuples = 0;
  for (auto unused : state) {
    VirtualScheduler scheduler;
    transport::MemoryNet net(scheduler);
    transport::MemoryTransports transports;
    transports.join(net);
    transports.put("flat.csv", bench::export_of(addresses));
    base::NullLogSink log;
    tuples::MemoryEcology ecology(scheduler);
    base::ConfigErrors errors;
    const auto before = in_use();
    auto island = [&] {
      auto config = island::read_island_config(
          must_parse(config::parse_yaml("island: {id: 6541, name: bench}\nlimits: {devices: 200000}\n"
                                        "networks: {knx: {type: knx, host: 127.0.0.1, import: flat.csv}}\n",
                                        "bench.yaml")),
          island::network_types(), errors);
      return must_parse(island::Island::make(std::move(config), scheduler, transports, log, ecology, errors));
    }();
    island->start();
    scheduler.run_for(std::chrono::seconds(3));
    island_bytes = in_use() - before;
    std::vector<std::pair<std::string, std::string>> all;
    island->space().list({OwnerId(6541), "**"},
                         [&](const TupleView& tuple) { all.emplace_back(tuple.key, tuple.value); });
    tuples = static_cast<double>(all.size());
    const auto link = must_parse(ecology.join(OwnerId(7)));
    const auto alone = in_use();
    TupleSpace space(OwnerId(7), scheduler, *link);
    for (const auto& [key, value] : all) must_parse(space.set(key, value));
    scheduler.run_ready();
    store_bytes = in_use() - alone;
  }
  state.counters["tuples"] = tuples;
  state.counters["bytes_per_address"] = island_bytes / addresses;
  state.counters["store_bytes_per_address"] = store_bytes / addresses;
}
BENCHMARK(memory_of_points)
    ->Name("island/memory-of-points")
    ->Arg(5'000)
    ->Arg(20'000)
    ->Arg(60'000)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rubicon
