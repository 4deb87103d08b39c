#include <fmt/format.h>
#include <malloc.h>

#include "base/virtual_scheduler.h"
#include "knx/measurements.h"
#include "networks/knx/dpt/dpt.h"
#include "networks/knx/groups/import.h"
#include "networks/knx/groups/record.h"
#include "networks/knx/knx_network.h"
#include "runtime/yaml.h"
#include "transport/memory_transports.h"

namespace rubicon::bench::knx {

namespace {

using namespace networks::knx;

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

/// An ETS export of so many switches, dimmers, temperatures and their states.
std::string export_of(int addresses) {
  std::string text =
      "\"Group name\";\"Address\";\"Central\";\"Unfiltered\";\"Description\";\"DatapointType\";\"Security\"\r\n";
  static constexpr const char* kTypes[] = {"DPST-1-1", "DPST-1-11", "DPST-5-1", "DPST-9-1"};
  static constexpr const char* kWords[] = {"switch", "switch status", "brightness", "temperature"};
  for (int i = 1; i <= addresses; ++i) {
    text += fmt::format("\"Room {} {}\";\"{}/{}/{}\";\"\";\"\";\"\";\"{}\";\"Auto\"\r\n", i / 4, kWords[i % 4], i >> 11,
                        i >> 8 & 7, i & 255, kTypes[i % 4]);
  }
  return text;
}

/// A host that forgets what it is told.
class DeafHost final : public network::NetworkHost {
 public:
  using NetworkHost::deliver;
  void deliver(Message) override {}
  void failed(Error) override {}
  Scheduler& scheduler() override { return time_; }
  transport::Transports& transports() override { return files_; }
  const Log& log() const override { return log_; }

 private:
  VirtualScheduler time_;
  transport::MemoryNet net_{time_};
  transport::MemoryTransports files_;
  base::NullLogSink sink_;
  Log log_{sink_, "bench"};
};

double network_megabytes(const std::vector<GroupPoint>& points) {
  auto node = runtime::parse_yaml(to_yaml(points, "bench"), "bench.yaml").value();
  ConfigNode host;
  host.kind = ConfigNode::Kind::kScalar;
  host.text = "127.0.0.1";
  node.entries.emplace_back("host", host);
  const TypeCatalogue types;
  DeafHost deaf;
  ConfigErrors errors;
  ConfigReader reader(node, "networks.knx", errors);
  ::malloc_trim(0);
  const auto before = ::mallinfo2().uordblks;
  const auto made = kType.make({"knx", IslandId{1}, reader, types, {}}, deaf);
  if (!made) return -1;
  return static_cast<double>(::mallinfo2().uordblks - before) / 1e6;
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
  for (const auto& one : cases) {
    const auto* type = find_dpt(one.id);
    std::vector<double> rounds;
    for (int round = 0; round < plan.rounds; ++round) rounds.push_back(nanoseconds(*type, one.payload, plan.decodes));
    out["dpt_ns"][to_string(one.id)] = median(rounds);
  }
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
  out["network_mb"] = network_megabytes(points);
}

}  // namespace rubicon::bench::knx
