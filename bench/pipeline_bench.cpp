#include <benchmark/benchmark.h>

#include <algorithm>
#include <charconv>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/virtual_scheduler.h"
#include "gateway/gateway.h"
#include "network/supervisor.h"
#include "proxy/proxy.h"
#include "tuples/memory/memory_ecology.h"

// From a network that has nothing to decode to one subscriber's callback, against the least that could be done with
// the same keys in the same order: one hash table of strings.

namespace rubicon {
namespace {

constexpr int kDevices = 10000;
constexpr int kSensors = 4;
constexpr int kMessagesPerTurn = 100;
constexpr OwnerId kPipelineIsland{6541};

struct NoTransports final : transport::Transports {
  Result<std::unique_ptr<transport::FileSource>> open_file(const std::string& path) override {
    return fail(ErrorCode::kNotFound, path);
  }
};

class Feed final : public network::Network {
 public:
  explicit Feed(network::NetworkHost& host) : host_(host) { present = this; }
  Result<void> open() override {
    host_.deliver({}, model::State{model::LineState::kUp, {}, {}});
    return {};
  }
  Result<void> send(const Message& message) override {
    const auto* sample = std::get_if<model::Sample>(&message.body);
    if (sample) host_.deliver(message.destination.device, model::Acknowledge{sample->request, {}, {}});
    return {};
  }
  void say(const std::string& device, model::Body body) { host_.deliver(device, std::move(body)); }

  static Result<std::unique_ptr<network::Network>> make(const network::NetworkConfig&, network::NetworkHost& host) {
    return std::make_unique<Feed>(host);
  }
  static inline Feed* present = nullptr;

 private:
  network::NetworkHost& host_;
};

std::vector<int> shuffled_devices() {
  std::vector<int> order(kDevices);
  for (int i = 0; i < kDevices; ++i) order[static_cast<std::size_t>(i)] = i;
  std::mt19937 dice(42);
  std::shuffle(order.begin(), order.end(), dice);
  return order;
}

double value_of(std::uint64_t count) {
  return 20.0 + static_cast<double>(count % 997) / 10;
}

/// A whole island with its devices joined and one subscriber to all their sensors.
struct Island {
  Island() {
    for (const auto* type : types.all()) {
      if (type->data != model::DataType::kReal || type->minimum > 0 || type->maximum < 200) continue;
      if (type->report == model::Report::kState && sensors.size() < kSensors) {
        sensors.push_back({Kind::kSensor, type->id, "1"});
      }
    }
    gate.connect(networks);
    proxy = std::make_unique<proxy::Proxy>(config, time, space, gate, types, log);
    ConfigNode options;
    options.kind = ConfigNode::Kind::kMap;
    ConfigErrors errors;
    ConfigReader reader(options, "networks.wsn-1", errors);
    const network::NetworkType type{.name = "feed", .summary = "", .sample_config = "", .make = &Feed::make};
    std::ignore = networks.add(type, {"wsn-1", kPipelineIsland, reader, types, {}});
    networks.start();
    model::Join join;
    for (const auto& sensor : sensors) {
      join.capabilities.emplace_back();
      join.capabilities.back().point = sensor;
    }
    for (int device = 0; device < kDevices; ++device) Feed::present->say(std::to_string(device), join);
    time.run_ready();
    ears = space.subscribe({kPipelineIsland, "proxy.*.*.sensor.*.value"}, {}, [this](const tuples::Event& event) {
      ++heard;
      last_size = event.tuple.value.size();
    });
    time.run_for(std::chrono::seconds(5));
    heard = 0;
  }

  base::NullLogSink log;
  VirtualScheduler time;
  tuples::MemoryEcology ecology{time};
  std::unique_ptr<tuples::Link> link = *ecology.join(kPipelineIsland);
  TupleSpace space{kPipelineIsland, time, *link};
  TypeCatalogue types;
  NoTransports transports;
  proxy::ProxyConfig config;
  gateway::Gateway gate{time, space, log};
  network::Supervisor networks{kPipelineIsland, time, transports, log, gate};
  std::unique_ptr<proxy::Proxy> proxy;
  tuples::Handle ears;
  std::vector<PointId> sensors;
  std::uint64_t heard = 0;
  std::size_t last_size = 0;
};

/// Time moves by what the goal of a million readings a second allows, so that once-a-second work is in the figure.
void pipeline(benchmark::State& state, int readings_per_message) {
  Island island;
  const auto order = shuffled_devices();
  std::vector<std::string> names;
  for (const int device : order) names.push_back(std::to_string(device));
  std::uint64_t said = 0;
  std::size_t next = 0, sensor = 0;
  for (auto unused : state) {
    for (int i = 0; i < kMessagesPerTurn; ++i) {
      model::Updates updates;
      updates.readings.reserve(static_cast<std::size_t>(readings_per_message));
      for (int r = 0; r < readings_per_message; ++r) {
        const auto& point = island.sensors[(sensor + static_cast<std::size_t>(r)) % kSensors];
        updates.readings.push_back({point, value_of(said++), {}});
      }
      Feed::present->say(names[next], std::move(updates));
      if (++next < names.size()) continue;
      next = 0;
      ++sensor;
    }
    island.time.run_ready();
    island.time.run_for(std::chrono::microseconds(kMessagesPerTurn * readings_per_message));
  }
  if (island.heard != said) state.SkipWithError("readings were lost on the way");
  state.SetItemsProcessed(static_cast<std::int64_t>(said));
}

void floor_of_strings(benchmark::State& state, int readings_per_message) {
  const auto order = shuffled_devices();
  std::vector<std::string> keys;  // in the order of the visits
  std::unordered_map<std::string, std::string> table;
  const char* const sensors[] = {"temperature-1", "humidity-1", "light-1", "pressure-1"};
  for (int pass = 0; pass < kSensors / readings_per_message; ++pass) {
    for (const int device : order) {
      for (int r = 0; r < readings_per_message; ++r) {
        keys.push_back("proxy.wsn-1." + std::to_string(device) + ".sensor." + sensors[pass + r] + ".value");
      }
    }
  }
  for (int device = 0; device < kDevices; ++device) {
    for (const auto* sensor : sensors) {
      table["proxy.wsn-1." + std::to_string(device) + ".sensor." + sensor + ".value"] = {};
    }
  }
  std::uint64_t said = 0, heard = 0;
  std::size_t next = 0;
  std::function<void(const std::string&, const std::string&)> call = [&](const std::string&, const std::string& value) {
    ++heard;
    benchmark::DoNotOptimize(value.size());
  };
  for (auto unused : state) {
    for (int i = 0; i < kMessagesPerTurn * readings_per_message; ++i) {
      char text[32];
      const auto end = std::to_chars(text, text + sizeof text, value_of(said++)).ptr;
      const auto found = table.find(keys[next]);
      found->second.assign(text, end);
      call(found->first, found->second);
      if (++next == keys.size()) next = 0;
    }
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(heard));
}

BENCHMARK_CAPTURE(floor_of_strings, one, 1)->Name("pipeline/floor");
BENCHMARK_CAPTURE(pipeline, one, 1)->Name("pipeline/reading");
BENCHMARK_CAPTURE(floor_of_strings, four, 4)->Name("pipeline/floor4");
BENCHMARK_CAPTURE(pipeline, four, 4)->Name("pipeline/reading4");

}  // namespace
}  // namespace rubicon
