#include <fmt/format.h>

#include <functional>
#include <stdexcept>

#include "frame/process_figures.h"
#include "networks/zigbee/bridge/device_record.h"
#include "networks/zigbee/bridge/messages.h"
#include "zigbee/records.h"

namespace rubicon::bench::zigbee {

namespace {

namespace bridge = networks::zigbee::bridge;

constexpr int kReads = 20;
constexpr int kLeaves = 500, kNeighbours = 20;

/// Milliseconds of processor time that each call takes.
Json timed(std::size_t bytes, const std::function<void()>& call) {
  std::vector<double> took;
  for (int i = 0; i < kReads; ++i) {
    const auto before = thread_seconds();
    call();
    took.push_back((thread_seconds() - before) * 1e3);
  }
  return {{"bytes", bytes}, {"ms", rounded(median(took), 2)}, {"worst_ms", rounded(percentile(took, 1), 2)}};
}

/// The record of a device with about as many leaves, and bytes, as are read.
std::string large_record(const std::string& record) {
  auto large = Json::parse(record);
  auto& exposes = large["definition"]["exposes"] = Json::array();
  const std::string description(100, 'x');
  for (int i = 0; i < kLeaves; ++i)
    exposes.push_back({{"type", "numeric"},
                       {"name", fmt::format("leaf_{}", i)},
                       {"label", fmt::format("Leaf {}", i)},
                       {"property", fmt::format("leaf_{}", i)},
                       {"access", 7},
                       {"unit", "V"},
                       {"value_max", 100},
                       {"value_min", 0},
                       {"description", description}});
  return large.dump();
}

/// The response of a network in which each device hears some others, in the form of Zigbee2MQTT 2.14.
std::string map_response(const std::vector<std::string>& records) {
  auto nodes = Json::array(), links = Json::array();
  const auto ieee = [&](std::size_t i) { return "0x" + address_of(records[i % records.size()]); };
  for (std::size_t i = 0; i < records.size(); ++i) {
    nodes.push_back({{"definition", {{"description", "a device"}, {"model", "M"}, {"supports", "x"}, {"vendor", "V"}}},
                     {"failed", Json::array()},
                     {"friendlyName", name_of(records[i])},
                     {"ieeeAddr", ieee(i)},
                     {"lastSeen", 1795358803796},
                     {"manufacturerName", "V"},
                     {"modelID", "M"},
                     {"networkAddress", i},
                     {"type", "Router"}});
    for (std::size_t n = 1; n <= kNeighbours; ++n)
      links.push_back({{"depth", 1},
                       {"linkquality", 120},
                       {"lqi", 120},
                       {"relationship", 2},
                       {"routes", Json::array()},
                       {"source", {{"ieeeAddr", ieee(i)}, {"networkAddress", i}}},
                       {"sourceIeeeAddr", ieee(i)},
                       {"sourceNwkAddr", i},
                       {"target", {{"ieeeAddr", ieee(i + n)}, {"networkAddress", i + n}}},
                       {"targetIeeeAddr", ieee(i + n)}});
  }
  return Json{{"data", {{"routes", false}, {"type", "raw"}, {"value", {{"links", links}, {"nodes", nodes}}}}},
              {"status", "ok"},
              {"transaction", "7"}}
      .dump();
}

}  // namespace

/// Texts that are read in one turn of the loop.
void measure_texts(const Plan& plan, Json& out) {
  const auto records = device_records(plan.devices);
  const auto record = large_record(records.front());
  const auto map = map_response(records);
  out["texts"] = {
      {"record", timed(record.size(), [&] { must(bridge::read_device_record(record)); })},
      {"map", timed(map.size(), [&] { must(bridge::read_network_map(must(bridge::read_response(map)).data)); })}};
}

}  // namespace rubicon::bench::zigbee
