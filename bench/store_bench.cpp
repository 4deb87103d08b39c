#include <benchmark/benchmark.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "base/virtual_scheduler.h"
#include "rubicon/tuple_space.hpp"
#include "tuples/link.h"
#include "tuples/memory/memory_ecology.h"

// The tuple store alone: what a set costs among many tuples and patterns, and what a tuple costs in time and memory.

namespace rubicon::tuples {
namespace {

constexpr OwnerId kIsland{6541};

struct Space {
  VirtualScheduler time;
  MemoryEcology ecology{time};
  std::unique_ptr<Link> link = *ecology.join(kIsland);
  TupleSpace space{kIsland, time, *link};
};

/// 45 characters for devices from 100000 on.
std::string key_of(int device, int sensor) {
  static const char* const sensors[] = {"temperature-1", "humidity-0001", "light-0000001", "pressure-0001"};
  return "proxy.wsn-1." + std::to_string(device) + ".sensor." + sensors[sensor] + ".value";
}

/// 100,000 tuples; 10 patterns match each of the tuples that are set, all others match something else.
void subscribe_match(benchmark::State& state) {
  constexpr int kDevices = 25'000;
  constexpr int kMatching = 10;
  constexpr int kSetsPerTurn = 1000;
  Space island;
  std::vector<TupleRef> tuples;
  for (int device = 0; device < kDevices; ++device) {
    for (int sensor = 0; sensor < 4; ++sensor) {
      const auto tuple = island.space.declare(key_of(100'000 + device, sensor));
      if (device % 10 == 0) tuples.push_back(*tuple);
    }
  }
  std::uint64_t heard = 0;
  std::vector<Handle> handles;
  const EventCall call = [&](const Event& event) { heard += event.tuple.value.size(); };
  for (int i = 0; i < kMatching; ++i) handles.push_back(island.space.subscribe({kIsland, "proxy.**"}, {}, call));
  for (int device = 0; static_cast<int>(handles.size()) < state.range(0); ++device) {
    if (device % 10 == 0) continue;
    const auto name = std::to_string(100'000 + device);
    handles.push_back(island.space.subscribe({kIsland, "proxy.*." + name + ".sensor.*.value"}, {}, call));
  }
  island.time.run_ready();
  std::shuffle(tuples.begin(), tuples.end(), std::mt19937(42));
  std::size_t next = 0;
  for (auto unused : state) {
    for (int i = 0; i < kSetsPerTurn; ++i) {
      benchmark::DoNotOptimize(island.space.set(tuples[next], "686.6"));
      if (++next == tuples.size()) next = 0;
    }
    island.time.run_ready();
  }
  benchmark::DoNotOptimize(heard);
  state.SetItemsProcessed(state.iterations() * kSetsPerTurn);
}

/// One subscriber to everything, 40,000 tuples in shuffled order: the store's share of a reading.
void set_and_hear(benchmark::State& state) {
  constexpr int kSetsPerTurn = 1000;
  Space island;
  std::vector<TupleRef> tuples;
  for (int device = 0; device < 10'000; ++device) {
    for (int sensor = 0; sensor < 4; ++sensor) tuples.push_back(*island.space.declare(key_of(device, sensor)));
  }
  std::uint64_t heard = 0;
  const auto ears = island.space.subscribe({kIsland, "proxy.*.*.sensor.*.value"}, {}, [&](const Event& event) {
    heard += event.tuple.key.size() + event.tuple.value.size();
  });
  island.time.run_ready();
  std::shuffle(tuples.begin(), tuples.end(), std::mt19937(42));
  std::size_t next = 0;
  for (auto unused : state) {
    for (int i = 0; i < kSetsPerTurn; ++i) {
      benchmark::DoNotOptimize(island.space.set(tuples[next], "686.6"));
      if (++next == tuples.size()) next = 0;
    }
    island.time.run_ready();
  }
  benchmark::DoNotOptimize(heard);
  state.SetItemsProcessed(state.iterations() * kSetsPerTurn);
}

double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  double total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

/// A million tuples of 45-character keys and 6-character values, with one subscriber to everything.
void create_million(benchmark::State& state) {
  constexpr int kTuples = 1'000'000;
  double bytes = 0, key_size = 0;
  for (auto unused : state) {
    malloc_trim(0);
    const auto before = resident_bytes();
    const auto begin = std::chrono::steady_clock::now();
    auto island = std::make_unique<Space>();
    for (int i = 0; i < kTuples; ++i) {
      const auto key = key_of(100'000 + i / 4, i % 4);
      key_size = static_cast<double>(key.size());
      benchmark::DoNotOptimize(island->space.set(key, "686.61"));
    }
    const auto end = std::chrono::steady_clock::now();
    state.SetIterationTime(std::chrono::duration<double>(end - begin).count());
    island->time.run_ready();
    bytes = (resident_bytes() - before) / kTuples;
  }
  state.counters["bytes_per_tuple"] = bytes;
  state.counters["key_characters"] = key_size;
}

/// Subscribing among a million tuples: to one device, and back.
void subscribe_one_device(benchmark::State& state) {
  Space island;
  for (int i = 0; i < 1'000'000; ++i) std::ignore = island.space.declare(key_of(100'000 + i / 4, i % 4));
  island.time.run_ready();
  int device = 0;
  for (auto unused : state) {
    const auto handle = island.space.subscribe({kIsland, "proxy.wsn-1." + std::to_string(100'000 + device) + ".**"}, {},
                                               [](const Event&) {});
    island.time.run_ready();
    device = (device + 7919) % 250'000;
  }
}

BENCHMARK(subscribe_match)->Name("store/subscribe-match")->Arg(10)->Arg(10'000);
BENCHMARK(set_and_hear)->Name("store/set");
BENCHMARK(create_million)->Name("store/create-million")->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(subscribe_one_device)->Name("store/subscribe-device")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace rubicon::tuples
