#include "zigbee/records.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "apps/simulators/zigbee/bridge_json.h"
#include "apps/simulators/zigbee/world.h"
#include "base/virtual_scheduler.h"

namespace rubicon::bench::zigbee {

namespace {

using nlohmann::json;

constexpr std::size_t kRecordBytes = 3700;

/// Gives the leaves descriptions, as the library has them, until the record has its size.
void lengthen(json& record) {
  const auto size = record.dump().size();
  if (size >= kRecordBytes || !record.contains("definition")) return;
  auto& definition = record["definition"];
  const std::string text(kRecordBytes - size, 'x');
  auto& exposes = definition["exposes"];
  const auto share = text.size() / exposes.size();
  for (auto& leaf : exposes) leaf["description"] = text.substr(0, share);
}

}  // namespace

std::vector<std::string> device_records(int devices, std::string_view model) {
  VirtualScheduler time;
  base::NullLogSink silence;
  zigbee_simulator::World world({}, time, Log(silence, "world"));
  std::string list;
  world.topics().publish = [&list](const transport::MqttPublication& message) {
    if (message.topic == "zigbee2mqtt/bridge/devices") list = message.payload;
  };
  const auto models = zigbee_simulator::model_names();
  for (std::size_t i = 0; i < static_cast<std::size_t>(devices); ++i)
    std::ignore = world.add(*zigbee_simulator::find_model(model.empty() ? models[i % models.size()] : model));
  world.start();
  time.run_for(std::chrono::seconds(10));
  std::vector<std::string> records;
  for (auto& record : json::parse(list)) {
    if (record["type"] == "Coordinator") continue;
    lengthen(record);
    records.push_back(record.dump());
  }
  if (records.size() != static_cast<std::size_t>(devices)) throw std::runtime_error("the world has other devices");
  return records;
}

std::string list_of(const std::vector<std::string>& records, std::size_t count) {
  std::string list = R"([{"ieee_address":"0x00124b00deadbeef","friendly_name":"Coordinator","type":"Coordinator"})";
  for (std::size_t i = 0; i < count; ++i) list.append(",").append(records[i]);
  return list + ']';
}

std::string renamed(const std::string& record, const std::string& name) {
  auto other = json::parse(record);
  other["friendly_name"] = name;
  return other.dump();
}

std::string interviewing(const std::string& record) {
  auto other = json::parse(record);
  other.erase("definition");
  other["interview_state"] = "IN_PROGRESS";
  other["interview_completed"] = false;
  other["supported"] = false;
  return other.dump();
}

std::string state_text(WallTime seen, int count) {
  return fmt::format(R"({{"battery":97.5,"humidity":{:.2f},"last_seen":"{}","linkquality":143,"power_outage_count":12,)"
                     R"("temperature":{:.2f},"voltage":3005}})",
                     40 + (count % 997) * 0.01, zigbee_simulator::iso_8601(seen), 20 + (count % 1009) * 0.01);
}

std::string address_of(const std::string& record) {
  return json::parse(record)["ieee_address"].get<std::string>().substr(2);
}

std::string name_of(const std::string& record) {
  return json::parse(record)["friendly_name"];
}

}  // namespace rubicon::bench::zigbee
