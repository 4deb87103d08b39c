#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "base/virtual_scheduler.h"
#include "config/yaml.h"
#include "island/island.h"
#include "island/network_types.h"
#include "support/memory/memory_transports.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon {
namespace {

constexpr OwnerId kIsland{6541};

/// Devices it never speaks of: what there is of them is remembered.
class QuietNetwork final : public network::Network {
 public:
  Result<void> open() override { return {}; }
  Result<void> send(const Message&) override { return fail(ErrorCode::kUnsupported, "quiet"); }
};

Result<std::unique_ptr<network::Network>> make_quiet(const network::NetworkConfig&, network::NetworkHost&) {
  return std::make_unique<QuietNetwork>();
}

constexpr network::NetworkType kQuiet{.name = "quiet", .summary = "nothing", .sample_config = "", .make = &make_quiet};

template <class T>
T must(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().text);
  return std::move(*result);
}

std::string state_of(std::size_t devices) {
  std::string folder = std::filesystem::temp_directory_path() / "rubicon-bench-XXXXXX";
  if (::mkdtemp(folder.data()) == nullptr) throw std::runtime_error(folder);
  auto store = must(state::StateStore::open(folder + "/island.state", kIsland));
  const TypeCatalogue types;
  std::ignore = store->begin();
  for (std::size_t i = 0; i < devices; ++i) {
    state::KnownDevice device{.network = "quiet-1", .address = std::to_string(i), .id = std::to_string(i)};
    device.join.name = fmt::format("Device {}", i);
    for (const auto* type : {"temperature", "light", "humidity", "switch"}) {
      model::Capability capability;
      capability.point = {Kind::kSensor, types.find(type)->id, "1"};
      device.join.capabilities.push_back(capability);
      state::StoredValue value;
      value.point = capability.point;
      value.value = std::string(type == std::string_view("switch") ? "on" : fmt::format("{}.5", i % 50));
      value.heard = value.changed = WallTime(std::chrono::seconds(1'700'000'000));
      device.values.push_back(value);
    }
    must(store->save(device));
  }
  std::ignore = store->commit(true);
  return folder + "/island.state";
}

/// From the opening of the state file until the last known device has its tuples.
void restart(benchmark::State& state) {
  const auto devices = static_cast<std::size_t>(state.range(0));
  const auto path = state_of(devices);
  const auto last = fmt::format("proxy.quiet-1.{}.sensor.light-1.value", devices - 1);
  for (auto _ : state) {
    VirtualScheduler scheduler;
    transport::MemoryTransports transports;
    base::NullLogSink log;
    tuples::MemoryEcology ecology(scheduler);
    base::ConfigErrors errors;
    const auto tree =
        must(config::parse_yaml("island: {id: 6541, name: bench}\nnetworks: {quiet-1: {type: quiet}}\n", "bench.yaml"));
    auto config = island::read_island_config(tree, std::span(&kQuiet, 1), errors);
    auto store = must(state::StateStore::open(path, kIsland));
    auto island =
        must(island::Island::make(std::move(config), scheduler, transports, log, ecology, errors, std::move(store)));
    island->start();
    scheduler.run_ready();
    if (!island->space().find(last)) state.SkipWithError("not all devices are there");
    state.PauseTiming();
    island.reset();
    state.ResumeTiming();
  }
  std::filesystem::remove_all(std::filesystem::path(path).parent_path());
}
BENCHMARK(restart)->Name("island/restart")->Arg(10000)->Unit(benchmark::kMillisecond);

/// What a user of 5,000 devices writes; `name` is that of one of them.
std::string big_file(int devices, const std::string& name) {
  std::string text = "island: {id: 6541, name: bench}\nnetworks:\n  dummy-1:\n    type: dummy\n    simulate:\n";
  for (int i = 0; i < devices; ++i) {
    text += fmt::format("      d{}: {{name: {}, sensors: {{temperature-1: {{wave: constant, value: 20}}}}}}\n", i,
                        i == devices / 2 ? name : fmt::format("Device {}", i));
  }
  return text;
}

/// Reading the file, comparing, taking what changed: one device.
void reload(benchmark::State& state) {
  const auto devices = static_cast<int>(state.range(0));
  const std::string files[] = {big_file(devices, "Kitchen"), big_file(devices, "Hall")};
  VirtualScheduler scheduler;
  transport::MemoryTransports transports;
  base::NullLogSink log;
  tuples::MemoryEcology ecology(scheduler);
  base::ConfigErrors errors;
  const auto read = [&](const std::string& text) {
    return island::read_island_config(must(config::parse_yaml(text, "bench.yaml")), island::network_types(), errors);
  };
  auto island = must(island::Island::make(read(files[0]), scheduler, transports, log, ecology, errors));
  island->start();
  scheduler.run_for(std::chrono::seconds(1));
  int turn = 0;
  for (auto _ : state) {
    const auto plan = must(island->reload(read(files[++turn % 2]), errors));
    scheduler.run_ready();
    if (plan.lines.size() != 1) state.SkipWithError("one device changed");
  }
}
BENCHMARK(reload)->Name("island/reload")->Arg(5000)->Unit(benchmark::kMillisecond);

/// The floor of a reload: the YAML alone.
void reload_floor(benchmark::State& state) {
  const auto text = big_file(static_cast<int>(state.range(0)), "Kitchen");
  for (auto _ : state) benchmark::DoNotOptimize(config::parse_yaml(text, "bench.yaml"));
}
BENCHMARK(reload_floor)->Name("island/reload-yaml")->Arg(5000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rubicon
