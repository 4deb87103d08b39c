#include <benchmark/benchmark.h>
#include <unistd.h>

#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "state/state_store.h"

// The state file: what an island with 10,000 known devices reads at its start, and what remembering costs.

namespace rubicon::state {
namespace {

namespace fs = std::filesystem;

constexpr int kDevices = 10'000;
constexpr IslandId kIsland{6541};

WallTime at(std::int64_t seconds) {
  return WallTime(std::chrono::seconds(1'790'000'000 + seconds));
}

model::PointId point(int number) {
  return {Kind::kSensor, TypeId(static_cast<std::uint16_t>(number + 1)), "1"};
}

std::vector<StoredValue> values_of(int device, std::int64_t time) {
  std::vector<StoredValue> values;
  for (int i = 0; i < 4; ++i) {
    values.push_back({point(i), static_cast<double>(device) / 8 + i, at(time), at(time), at(time), false});
  }
  return values;
}

/// `alike`: announcements are those of one kind of device; else each is different.
KnownDevice device_of(int number, bool alike) {
  KnownDevice device;
  device.network = "wsn-1";
  device.address = std::to_string(number);
  device.id = "mote_" + device.address;
  device.decision = Decision::kApproved;
  device.join = {"mote", "Mote " + std::to_string(number), "Advantic EM1000", {}, true};
  for (int i = 0; i < 4; ++i) {
    model::Capability capability;
    capability.point = point(i);
    capability.unit = "Cel";
    capability.minimum = alike ? -40 : -number;
    capability.maximum = 125;
    capability.deadline = std::chrono::seconds(60);
    device.join.capabilities.push_back(capability);
    device.point_ids.emplace_back(capability.point, "temperature-" + std::to_string(i));
  }
  device.first_seen = device.last_heard = at(number);
  device.values = values_of(number, number);
  return device;
}

struct Folder {
  fs::path path = fs::temp_directory_path() / ("rubicon-state-bench-" + std::to_string(::getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  std::string file() const { return path / "island.state"; }
};

std::vector<StateStore::Row> fill(StateStore& store, bool alike) {
  std::vector<StateStore::Row> rows;
  std::ignore = store.begin();
  for (int i = 0; i < kDevices; ++i) rows.push_back(*store.save(device_of(i, alike)));
  std::ignore = store.commit(true);
  return rows;
}

void open_and_read(benchmark::State& state, bool alike) {
  Folder folder;
  fill(**StateStore::open(folder.file(), kIsland), alike);
  std::size_t values = 0;
  for (auto unused : state) {
    const auto store = *StateStore::open(folder.file(), kIsland);
    values = 0;
    std::ignore = store->each("", [&](StateStore::Row, KnownDevice&& device) { values += device.values.size(); });
  }
  if (values != 4 * kDevices) state.SkipWithError("values are missing");
  state.counters["file_bytes"] = static_cast<double>(fs::file_size(folder.file()));
}

void open_only(benchmark::State& state) {
  Folder folder;
  fill(**StateStore::open(folder.file(), kIsland), true);
  for (auto unused : state) benchmark::DoNotOptimize(StateStore::open(folder.file(), kIsland));
}

void save_again(benchmark::State& state) {
  Folder folder;
  const auto store = *StateStore::open(folder.file(), kIsland);
  fill(*store, true);
  std::vector<KnownDevice> devices;
  for (int i = 0; i < kDevices; ++i) devices.push_back(device_of(i, true));
  for (auto unused : state) {
    std::ignore = store->begin();
    for (const auto& device : devices) benchmark::DoNotOptimize(store->save(device));
    std::ignore = store->commit(false);
  }
  state.SetItemsProcessed(state.iterations() * kDevices);
}

/// A thousand values of 250 devices anywhere in the file.
void save_values(benchmark::State& state, bool durable) {
  Folder folder;
  const auto store = *StateStore::open(folder.file(), kIsland);
  const auto rows = fill(*store, true);
  std::mt19937 random(42);
  std::int64_t time = kDevices;
  for (auto unused : state) {
    ++time;
    std::ignore = store->begin();
    for (int i = 0; i < 250; ++i) {
      const auto device = random() % rows.size();
      benchmark::DoNotOptimize(store->save_values(rows[device], values_of(static_cast<int>(device), time)));
    }
    std::ignore = store->commit(durable);
  }
  if (store->stats().failures > 0) state.SkipWithError("a write failed");
  state.SetItemsProcessed(state.iterations() * 1000);
}

BENCHMARK_CAPTURE(open_and_read, alike, true)->Name("state/open-and-read")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(open_and_read, unlike, false)->Name("state/open-and-read-unlike")->Unit(benchmark::kMillisecond);
BENCHMARK(open_only)->Name("state/open")->Unit(benchmark::kMillisecond);
BENCHMARK(save_again)->Name("state/save-10000-again")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(save_values, no, false)->Name("state/save-1000-values")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(save_values, yes, true)->Name("state/save-1000-values-durable")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rubicon::state
