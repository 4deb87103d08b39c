#include <fmt/format.h>
#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <map>
#include <new>
#include <stdexcept>

#include "base/virtual_scheduler.h"
#include "config/yaml.h"
#include "ets_export.h"
#include "knx/measurements.h"
#include "networks/knx/dpt/dpt.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/groups/import.h"
#include "networks/knx/knx_network.h"
#include "support/memory/memory_transports.h"

namespace {

/// Of the whole program.
std::atomic<std::uint64_t> allocations{0};

}  // namespace

void* operator new(std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  if (void* memory = std::malloc(size)) return memory;  // NOLINT(cppcoreguidelines-no-malloc)
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept {
  std::free(memory);  // NOLINT(cppcoreguidelines-no-malloc)
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);  // NOLINT(cppcoreguidelines-no-malloc)
}

namespace rubicon::bench::knx {

namespace {

using namespace networks::knx::dpt;
using namespace networks::knx::groups;
using namespace networks::knx::wire;

/// Of so many decodes of the types that are numbers; what they need to be found is not counted.
std::uint64_t allocations_of(const Dpt& type, PayloadView payload, int decodes) {
  const auto before = allocations.load();
  for (int i = 0; i < decodes; ++i) {
    auto value = decode(type, payload);
    asm volatile("" : : "r"(&value) : "memory");
  }
  return allocations.load() - before;
}

double nanoseconds(const Dpt& type, PayloadView payload, int decodes) {
  double sum = 0;
  const auto start = Clock::now();
  for (int i = 0; i < decodes; ++i) {
    auto value = decode(type, payload);
    asm volatile("" : : "r"(&value) : "memory");
    sum += value.has_value() ? 1 : 0;
  }
  return sum > 0 ? seconds_since(start) * 1e9 / decodes : 0;
}

/// A host that keeps what a network says of its devices only.
class DeafHost final : public network::NetworkHost {
 public:
  DeafHost() { files_.join(net_); }
  DeafHost(const DeafHost&) = delete;
  DeafHost& operator=(const DeafHost&) = delete;

  using NetworkHost::deliver;
  void deliver(model::Message&& message) override {
    auto* join = std::get_if<model::Join>(&message.body);
    if (join == nullptr) return;
    auto& points = devices[message.source.device];
    for (const auto& one : join->capabilities) points.push_back(one.point);
  }
  void failed(Error) override {}
  Scheduler& scheduler() override { return time; }
  transport::Transports& transports() override { return files_; }
  const Log& log() const override { return log_; }

  VirtualScheduler time;
  std::map<std::string, std::vector<PointId>> devices;

 private:
  transport::MemoryNet net_{time};
  transport::MemoryTransports files_;
  base::NullLogSink sink_;
  Log log_{sink_, "bench"};
};

std::size_t in_use() {
  ::malloc_trim(0);
  const auto heap = ::mallinfo2();
  return heap.uordblks + heap.hblkhd;
}

double megabytes(std::size_t before) {
  return static_cast<double>(in_use() - before) / 1e6;
}

/// Of a network that is open, has told its devices and is asked for the values of all; without what the configuration
/// and the host keep.
void measure_memory(const std::vector<GroupPoint>& points, Json& out) {
  auto node = config::parse_yaml(to_yaml(points, "bench"), "bench.yaml").value();
  ConfigNode host;
  host.kind = ConfigNode::Kind::kScalar;
  host.text = "127.0.0.1";
  node.entries.emplace_back("host", host);
  const TypeCatalogue types;
  ConfigErrors errors;
  ConfigReader reader(node, "networks.knx", errors);
  DeafHost deaf;
  const auto before = in_use();
  const auto made = networks::knx::kType.make({"knx", IslandId{1}, reader, types, {}}, deaf);
  if (!made) throw std::runtime_error(errors.text());
  out["network_made_mb"] = megabytes(before);
  if (const auto opened = (*made)->open(); !opened) throw std::runtime_error(opened.error().text);
  deaf.time.run_for(std::chrono::milliseconds(100));
  for (const auto& [device, wanted] : deaf.devices) {
    model::Message message;
    message.source.island = IslandId{1};
    message.destination = {IslandId{1}, "knx", device};
    message.body = model::Sample{1, wanted, std::chrono::seconds(1)};
    if (const auto taken = (*made)->send(message); !taken) throw std::runtime_error(taken.error().text);
  }
  deaf.time.run_for(std::chrono::milliseconds(100));
  deaf.devices.clear();
  out["network_mb"] = megabytes(before);
}

}  // namespace

void measure_dpt(const Plan& plan, Json& out) {
  struct Case {
    DptId id;
    Payload payload;
  };
  const Case cases[] = {{{1, 1}, {{1}, true}},
                        {{5, 1}, {{0x80}, false}},
                        {{9, 1}, {{0x0c, 0x33}, false}},
                        {{13, 1}, {{0xff, 0xff, 0xff, 0xff}, false}},
                        {{14, 56}, {{0x41, 0xac, 0, 0}, false}},
                        {{16, 1}, {{'Z', 'u', 'e', 'r', 'i', 'c', 'h', 0, 0, 0, 0, 0, 0, 0}, false}},
                        {{10, 1}, {{0xad, 0x1e, 0x0f}, false}}};
  constexpr int kCounted = 1'000'000;
  std::uint64_t allocated = 0;
  for (const auto& one : cases) {
    const auto* type = find_dpt(one.id);
    const bool text = std::holds_alternative<std::string>(decode(*type, one.payload).value());
    if (!text) allocated += allocations_of(*type, one.payload, kCounted);
    std::vector<double> rounds;
    for (int round = 0; round < plan.rounds; ++round) rounds.push_back(nanoseconds(*type, one.payload, plan.decodes));
    out["dpt_ns"][to_string(one.id)] = median(rounds);
  }
  out["dpt_allocations"] = allocated;
}

void measure_import(const Plan& plan, Json& out) {
  const auto text = export_of(plan.addresses);
  std::vector<double> rounds;
  std::vector<GroupPoint> points;
  for (int round = 0; round < plan.rounds; ++round) {
    const auto start = Clock::now();
    points = import_text(text, "bench.csv").value().points;
    rounds.push_back(seconds_since(start) * 1e3);
  }
  out["import_ms"] = median(rounds);
  out["import_addresses"] = plan.addresses;
  out["import_points"] = points.size();
  measure_memory(points, out);
}

}  // namespace rubicon::bench::knx
