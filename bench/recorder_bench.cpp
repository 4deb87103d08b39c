#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "base/virtual_scheduler.h"
#include "gateway/gateway.h"
#include "network/supervisor.h"
#include "networks/log/log_network.h"
#include "proxy/proxy.h"
#include "recorder/recorder.h"
#include "recording/recording_reader.h"
#include "transport/local_transports.h"
#include "tuples/memory/memory_ecology.h"

// What a recorder costs the pipeline of 10,000 devices when everything is written to a real file, and how fast a
// recording is read and replayed. The floors: the same pipeline without a recorder; the bytes of the same file only
// read.

namespace rubicon {
namespace {

constexpr int kRecordedDevices = 10'000;
constexpr int kRecordedSensors = 4;
constexpr int kRecordedPerTurn = 100;
constexpr OwnerId kRecordedIsland{6541};

std::string scratch_file() {
  return (std::filesystem::temp_directory_path() / ("rubicon-bench-" + std::to_string(getpid()) + ".rec")).string();
}

class Mouth final : public network::Network {
 public:
  explicit Mouth(network::NetworkHost& host) : host_(host) { present = this; }
  Result<void> open() override {
    host_.deliver({}, model::State{model::LineState::kUp, {}, {}});
    return {};
  }
  Result<void> send(const Message&) override { return {}; }
  void say(const std::string& device, model::Body body) { host_.deliver(device, std::move(body)); }
  static Result<std::unique_ptr<network::Network>> make(const network::NetworkConfig&, network::NetworkHost& host) {
    return std::make_unique<Mouth>(host);
  }
  static inline Mouth* present = nullptr;

 private:
  network::NetworkHost& host_;
};

/// A whole island with joined devices, one listener to all values and, if wanted, a recorder.
struct Recorded {
  explicit Recorded(const std::vector<std::string>& patterns) {
    for (const auto* type : types.all()) {
      if (type->data != model::DataType::kReal || type->minimum > 0 || type->maximum < 200) continue;
      if (type->report == model::Report::kState && sensors.size() < kRecordedSensors)
        sensors.push_back({Kind::kSensor, type->id, "1"});
    }
    gate.connect(networks);
    proxy = std::make_unique<proxy::Proxy>(config, time, space, gate, types, log);
    ConfigNode options;
    options.kind = ConfigNode::Kind::kMap;
    ConfigErrors errors;
    ConfigReader reader(options, "networks.wsn-1", errors);
    std::ignore = networks.add({"mouth", "", "", &Mouth::make}, {"wsn-1", kRecordedIsland, reader, types, {}});
    networks.start();
    model::Join join;
    for (const auto& point : sensors) {
      join.capabilities.emplace_back();
      join.capabilities.back().point = point;
    }
    for (int device = 0; device < kRecordedDevices; ++device) Mouth::present->say(std::to_string(device), join);
    time.run_ready();
    ears = space.subscribe({kRecordedIsland, "proxy.*.*.sensor.*.value"}, {{}, {}, 0, true},
                           [this](const tuples::Event&) { ++heard; });
    if (!patterns.empty()) {
      config::RecorderSetup setup;
      setup.name = "bench";
      setup.file = scratch_file();
      for (const auto& text : patterns) setup.patterns.push_back(*Pattern::parse(text));
      setup.rotation = {};
      setup.rotation.keep = 0;
      recorder = std::make_unique<recorder::Recorder>(std::move(setup),
                                                      recorder::Recorder::Context{time, space, disk, log, "proxy", ""});
      recorder->start();
    }
    for (int device = 0; device < kRecordedDevices; ++device) names.push_back(std::to_string(device));
    std::shuffle(names.begin(), names.end(), std::mt19937(42));
    time.run_for(std::chrono::seconds(5));
    heard = 0;
  }

  /// `turns` of the loop with a hundred readings each, at 100,000 readings a second of virtual time.
  void feed(int turns) {
    for (int turn = 0; turn < turns; ++turn) {
      for (int i = 0; i < kRecordedPerTurn; ++i, ++said) {
        model::Updates updates;
        updates.readings.push_back(
            {sensors[sensor % kRecordedSensors], 20.0 + static_cast<double>(said % 997) / 10, time.wall_now()});
        Mouth::present->say(names[next], std::move(updates));
        if (++next < names.size()) continue;
        next = 0;
        ++sensor;
      }
      time.run_ready();
      time.run_for(std::chrono::microseconds(10) * kRecordedPerTurn);
    }
  }

  base::NullLogSink log;
  VirtualScheduler time;
  tuples::MemoryEcology ecology{time};
  std::unique_ptr<tuples::Link> link = *ecology.join(kRecordedIsland);
  TupleSpace space{kRecordedIsland, time, *link};
  TypeCatalogue types;
  transport::LocalTransports disk;
  proxy::ProxyConfig config;
  std::unique_ptr<recorder::Recorder> recorder;
  gateway::Gateway gate{time, space, log};
  network::Supervisor networks{kRecordedIsland, time, disk, log, gate};
  std::unique_ptr<proxy::Proxy> proxy;
  tuples::Handle ears;
  std::vector<PointId> sensors;
  std::vector<std::string> names;
  std::uint64_t heard = 0, said = 0;
  std::size_t next = 0, sensor = 0;
};

void pipeline(benchmark::State& state, const std::vector<std::string>& patterns) {
  std::filesystem::remove(scratch_file());
  {
    Recorded island(patterns);
    for (auto unused : state) island.feed(1);
    if (island.heard != island.said) state.SkipWithError("readings were lost on the way");
    state.SetItemsProcessed(static_cast<std::int64_t>(island.said));
    if (island.recorder) {
      const auto& counters = island.recorder->counters();
      if (counters.dropped > 0) state.SkipWithError("records were dropped");
      state.counters["records_per_reading"] = static_cast<double>(counters.records) / static_cast<double>(island.said);
      state.counters["bytes_per_record"] = static_cast<double>(counters.bytes) / static_cast<double>(counters.records);
    }
  }
  std::filesystem::remove(scratch_file());
}

/// A recording of a million readings of 10,000 devices.
const std::string& recording() {
  static const struct File {
    File() {
      std::filesystem::remove(path);
      Recorded island({"proxy.**"});
      island.feed(10'000);
    }
    ~File() { std::filesystem::remove(path); }
    std::string path = scratch_file();
  } file;
  return file.path;
}

/// Only the bytes, in the same pieces.
void floor_of_bytes(benchmark::State& state) {
  transport::LocalTransports disk;
  Bytes piece(64 << 10);
  const auto& path = recording();
  for (auto unused : state) {
    auto file = disk.open_file(path);
    while (*(*file)->read(piece) > 0) benchmark::DoNotOptimize(piece.data());
  }
  state.SetItemsProcessed(state.iterations() * 1'000'000);
}

void read_records(benchmark::State& state) {
  transport::LocalTransports disk;
  Bytes piece(64 << 10);
  std::int64_t records = 0;
  for (auto unused : state) {
    auto file = disk.open_file(recording());
    recording::RecordingReader reader;
    while (!reader.ended()) {
      const auto count = *(*file)->read(piece);
      if (count > 0) reader.feed(ByteView(piece).first(count));
      if (count == 0) reader.end();
      while (const auto item = reader.next()) records += std::holds_alternative<recording::Record>(*item) ? 1 : 0;
    }
  }
  state.SetItemsProcessed(records);
}

struct CountingHost final : network::NetworkHost {
  using NetworkHost::deliver;
  void deliver(Message&& message) override {
    if (const auto* updates = std::get_if<model::Updates>(&message.body)) readings += updates->readings.size();
    if (const auto* line = std::get_if<model::State>(&message.body)) ended |= line->line == model::LineState::kEnded;
  }
  void failed(Error) override { ended = true; }
  Scheduler& scheduler() override { return time; }
  transport::Transports& transports() override { return disk; }
  const Log& log() const override { return voice; }

  VirtualScheduler time;
  transport::LocalTransports disk;
  base::NullLogSink sink;
  Log voice{sink, "bench"};
  std::uint64_t readings = 0;
  bool ended = false;
};

void replay(benchmark::State& state) {
  const TypeCatalogue types;
  std::uint64_t readings = 0;
  ConfigNode options;
  options.kind = ConfigNode::Kind::kMap;
  for (const auto& [key, text] : {std::pair<std::string, std::string>{"file", recording()}, {"speed", "max"}}) {
    options.entries.emplace_back(key, ConfigNode{});
    options.entries.back().second.kind = ConfigNode::Kind::kScalar;
    options.entries.back().second.text = text;
  }
  for (auto unused : state) {
    CountingHost host;
    ConfigErrors errors;
    ConfigReader reader(options, "networks.log-1", errors);
    auto network = networks::log::kType.make({"log-1", kRecordedIsland, reader, types, {}}, host);
    std::ignore = (*network)->open();
    while (!host.ended) host.time.run_for(std::chrono::milliseconds(1));
    readings += host.readings;
  }
  if (readings < static_cast<std::uint64_t>(state.iterations()) * 1'000'000)
    state.SkipWithError("readings are missing");
  state.SetItemsProcessed(static_cast<std::int64_t>(readings));
}

BENCHMARK_CAPTURE(pipeline, floor, {})->Name("recorder/floor");
BENCHMARK_CAPTURE(pipeline, values, {"proxy.*.*.*.*.value"})->Name("recorder/values");
BENCHMARK_CAPTURE(pipeline, everything, {"proxy.**"})->Name("recorder/everything");
BENCHMARK(floor_of_bytes)->Name("replay/floor")->Unit(benchmark::kMillisecond);
BENCHMARK(read_records)->Name("replay/records")->Unit(benchmark::kMillisecond);
BENCHMARK(replay)->Name("replay/readings")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rubicon
