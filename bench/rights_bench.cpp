#include <benchmark/benchmark.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "base/virtual_scheduler.h"
#include "rights/rights_judge.h"
#include "rubicon/tuple_space.hpp"
#include "tuples/memory/memory_ecology.h"

// What rights cost: 100,000 tuples, 1,000 rules about the subscriber, who sees all but one tuple in fifty. The
// argument: 0 = no judge, 1 = with the rules.

namespace rubicon::rights {
namespace {

constexpr OwnerId kIsland{6541}, kRobot{70000};
constexpr int kDevices = 25'000;

std::string device_key(int device) {
  return "proxy.wsn-1." + std::to_string(100'000 + device);
}

RightSet reading() {
  RightSet rights;
  rights.add(Right::kRead);
  rights.add(Right::kDemand);
  return rights;
}

/// One rule for all keys, 999 that name a device each.
std::vector<Rule> many_rules() {
  std::vector<Rule> rules{
      {.who = {"everybody"}, .may = reading(), .keys = {"proxy.**"}, .except = {"proxy.*.*.sensor.motion-*.**"}}};
  for (int i = 1; i < 1000; ++i) {
    const auto device = device_key(i * 25);
    rules.push_back(
        {.who = {"robot"},
         .may = reading(),
         .keys = {device + ".**"},
         .except = i % 2 == 0 ? std::vector<std::string>{device + ".sensor.*.value"} : std::vector<std::string>{}});
  }
  return rules;
}

/// An island and a robot that subscribes to all its tuples.
struct Ecology {
  explicit Ecology(bool judged) {
    if (judged) ecology.judge(kIsland, std::make_shared<RightsJudge>(Rights(many_rules())));
    ecology.certify(kRobot, {.name = "robot", .roles = {"machine"}});
    island_link = *ecology.join(kIsland);
    robot_link = *ecology.join(kRobot);
    island.emplace(kIsland, time, *island_link);
    robot.emplace(kRobot, time, *robot_link);
    for (int device = 0; device < kDevices; ++device) {
      for (const auto* sensor : {"temperature-1", "humidity-1", "light-1", "pressure-1"})
        tuples.push_back(*island->declare(device_key(device) + ".sensor." + sensor + ".value", "21.5"));
    }
    time.run_ready();
  }
  tuples::Handle subscribe() {
    return robot->subscribe({kIsland, "**"}, {}, [this](const tuples::Event&) { ++heard; });
  }

  VirtualScheduler time;
  tuples::MemoryEcology ecology{time};
  std::unique_ptr<tuples::Link> island_link, robot_link;
  std::optional<tuples::TupleSpace> island, robot;
  std::vector<tuples::TupleRef> tuples;
  std::uint64_t heard = 0;
};

/// A turn of 1,000 sets, as the robot hears them.
void publish(benchmark::State& state) {
  constexpr int kSetsPerTurn = 1000;
  Ecology all(state.range(0) != 0);
  const auto handle = all.subscribe();
  all.time.run_ready();
  std::size_t next = 0;
  for (auto unused : state) {
    for (int i = 0; i < kSetsPerTurn; ++i) {
      benchmark::DoNotOptimize(all.island->set(all.tuples[next], "686.6"));
      next = (next + 7) % all.tuples.size();
    }
    all.time.run_ready();
  }
  state.counters["heard"] = static_cast<double>(all.heard);
  state.SetItemsProcessed(state.iterations() * kSetsPerTurn);
}

/// From the subscription until all its tuples have arrived.
void join(benchmark::State& state) {
  Ecology all(state.range(0) != 0);
  for (auto unused : state) {
    all.heard = 0;
    const auto begin = std::chrono::steady_clock::now();
    auto handle = all.subscribe();
    all.time.run_ready();
    state.SetIterationTime(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    handle.reset();
    all.time.run_ready();
  }
  state.counters["tuples"] = static_cast<double>(all.heard);
}

/// The question alone.
void access(benchmark::State& state) {
  const RightsJudge judge{Rights(many_rules())};
  const tuples::Member robot{.name = "robot", .roles = {"machine"}};
  std::vector<std::string> keys;
  for (int device = 0; device < 1000; ++device) keys.push_back(device_key(device * 7) + ".sensor.light-1.value");
  std::size_t next = 0;
  for (auto unused : state) {
    benchmark::DoNotOptimize(judge.access(robot, keys[next]));
    next = (next + 1) % keys.size();
  }
}

BENCHMARK(publish)->Name("rights/publish")->Arg(0)->Arg(1);
BENCHMARK(join)->Name("rights/join")->Arg(0)->Arg(1)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(access)->Name("rights/access");

}  // namespace
}  // namespace rubicon::rights
