#include "apps/simulators/zigbee/bridge_json.h"

#include <fmt/format.h>

#include "apps/simulators/zigbee/world.h"
#include "base/config_reader.h"

namespace rubicon::zigbee_simulator {

namespace {

using Json = nlohmann::json;

constexpr std::string_view kCoordinator = "0x00124b00deadbeef";

std::int64_t milliseconds_of(WallTime time) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(time.time_since_epoch()).count();
}

Json config_json(const WorldOptions& options, const std::vector<RadioDevice*>& devices) {
  auto of_devices = Json::object();
  for (const auto* device : devices) {
    auto entry = device->options;
    entry["friendly_name"] = device->name();
    of_devices[device->address()] = std::move(entry);
  }
  auto device_options = Json::object();
  if (!options.optimistic) device_options["optimistic"] = false;
  return {{"advanced",
           {{"cache_state", true},
            {"cache_state_persistent", true},
            {"cache_state_send_on_startup", true},
            {"channel", 11},
            {"last_seen", options.last_seen},
            {"log_level", "info"},
            {"output", options.output},
            {"pan_id", 6754}}},
          {"availability",
           {{"enabled", options.availability},
            {"active", {{"timeout", 1}, {"max_jitter", 30000}, {"backoff", true}, {"pause_on_backoff_gt", 0}}},
            {"passive", {{"timeout", 1500}}}}},
          {"device_options", device_options},
          {"devices", of_devices},
          {"groups", Json::object()},
          {"homeassistant", {{"enabled", options.nulls}, {"discovery_topic", "homeassistant"}}},
          {"mqtt", {{"base_topic", options.base}, {"force_disable_retain", false}, {"keepalive", 60}, {"version", 4}}},
          {"version", 5}};
}

Json map_node(std::string_view address, std::string_view name, std::string_view type, int network_address) {
  return {{"ieeeAddr", address},     {"friendlyName", name}, {"type", type}, {"networkAddress", network_address},
          {"failed", Json::array()}, {"lastSeen", nullptr}};
}

Json map_end(std::string_view address, int network_address) {
  return {{"ieeeAddr", address}, {"networkAddress", network_address}};
}

Json map_link(const Json& from, const Json& to, int quality) {
  return {{"source", from},
          {"target", to},
          {"sourceIeeeAddr", from["ieeeAddr"]},
          {"targetIeeeAddr", to["ieeeAddr"]},
          {"sourceNwkAddr", from["networkAddress"]},
          {"linkquality", quality},
          {"lqi", quality},
          {"depth", 1},
          {"relationship", 1},
          {"routes", Json::array()}};
}

}  // namespace

std::string iso_8601(WallTime time) {
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const auto of_day = std::chrono::duration_cast<std::chrono::milliseconds>(time - day).count();
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", int(date.year()), unsigned(date.month()),
                     unsigned(date.day()), of_day / 3600000, of_day / 60000 % 60, of_day / 1000 % 60, of_day % 1000);
}

Json last_seen_json(const std::string& setting, WallTime time) {
  if (setting == "disable") return {};
  if (setting == "epoch") return milliseconds_of(time);
  if (setting != "ISO_8601_local") return iso_8601(time);
  // The simulator's home lies one hour east of Greenwich: 2026-11-21T01:16:49+01:00, without milliseconds.
  return iso_8601(time + std::chrono::hours(1)).substr(0, 19) + "+01:00";
}

Json coordinator_record() {
  const Json endpoint{{"bindings", Json::array()},
                      {"clusters", {{"input", Json::array()}, {"output", Json::array()}}},
                      {"configured_reportings", Json::array()},
                      {"scenes", Json::array()}};
  return {{"ieee_address", kCoordinator},
          {"friendly_name", "Coordinator"},
          {"network_address", 0},
          {"type", "Coordinator"},
          {"supported", true},
          {"disabled", false},
          {"interview_state", "SUCCESSFUL"},
          {"interview_completed", true},
          {"interviewing", false},
          {"endpoints", {{"1", endpoint}, {"242", endpoint}}}};
}

Json info_json(const WorldOptions& options, const std::vector<RadioDevice*>& devices, bool joining,
               WallTime joining_end, bool restart_required) {
  Json info{{"version", options.version},
            {"commit", "3c3d8c1a"},
            {"coordinator", {{"ieee_address", kCoordinator}, {"type", "simulated"}, {"meta", {{"revision", 1}}}}},
            {"network", {{"channel", 11}, {"pan_id", 6754}, {"extended_pan_id", "0xdddddddddddddddd"}}},
            {"log_level", "info"},
            {"permit_join", joining},
            {"restart_required", restart_required},
            {"zigbee_herdsman", {{"version", "10.9.2"}}},
            {"zigbee_herdsman_converters", {{"version", "26.105.0"}}},
            {"config", config_json(options, devices)}};
  if (joining) info["permit_join_end"] = milliseconds_of(joining_end);
  return info;
}

Json groups_json(const std::vector<const DeviceGroup*>& groups) {
  auto all = Json::array();
  for (const auto* group : groups) {
    auto members = Json::array();
    for (const auto& address : group->members) members.push_back({{"ieee_address", address}, {"endpoint", 1}});
    all.push_back({{"id", group->id}, {"friendly_name", group->name}, {"scenes", Json::array()}, {"members", members}});
  }
  return all;
}

Json health_json(const std::vector<RadioDevice*>& devices, WallTime now, Duration up, std::uint64_t published,
                 std::uint64_t received) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(up).count();
  auto of_devices = Json::object();
  for (const auto* device : devices) {
    const auto rate = static_cast<double>(device->messages) / static_cast<double>(std::max<std::int64_t>(seconds, 1));
    of_devices[device->address()] = {
        {"messages", device->messages}, {"messages_per_sec", rate}, {"leave_count", 0}, {"network_address_changes", 0}};
  }
  return {{"response_time", milliseconds_of(now)},
          {"os", {{"load_average", {0.12, 0.1, 0.05}}, {"memory_used_mb", 812.5}, {"memory_percent", 10.2}}},
          {"process", {{"uptime_sec", seconds}, {"memory_used_mb", 151.4}, {"memory_percent", 1.9}}},
          {"mqtt", {{"connected", true}, {"queued", 0}, {"published", published}, {"received", received}}},
          {"devices", of_devices}};
}

Json map_json(const std::vector<RadioDevice*>& devices, bool routes) {
  auto nodes = Json::array({map_node(kCoordinator, "Coordinator", "Coordinator", 0)});
  auto links = Json::array();
  Json before = map_end(kCoordinator, 0);
  for (const auto* device : devices) {
    const auto record = device->record();
    const auto end = map_end(device->address(), record["network_address"]);
    auto node =
        map_node(device->address(), device->name(), record["type"].get<std::string>(), record["network_address"]);
    node["definition"] = {{"model", device->model().definition.value("model", "")},
                          {"vendor", device->model().definition.value("vendor", "")}};
    node["manufacturerName"] = device->model().manufacturer;
    node["modelID"] = device->model().model_id;
    node["lastSeen"] = milliseconds_of(device->last_seen());
    if (device->faults.silent) node["failed"] = {"lqi"};
    nodes.push_back(std::move(node));
    links.push_back(map_link(end, before, 180));
    if (!device->model().battery) before = end;
  }
  return {{"type", "raw"}, {"routes", routes}, {"value", {{"nodes", nodes}, {"links", links}}}};
}

}  // namespace rubicon::zigbee_simulator
