#include "apps/simulators/zigbee/bridge_topics.h"

#include <algorithm>

#include "apps/simulators/zigbee/bridge_json.h"
#include "model/json_text.h"

namespace rubicon::zigbee_simulator {

namespace {

/// A longer list is not queued a second time for a slow broker.
constexpr std::size_t kLongList = 256 * 1024;

std::string availability_text(bool online) {
  return online ? R"({"state":"online"})" : R"({"state":"offline"})";
}

}  // namespace

void BridgeTopics::say(const std::string& topic, std::string payload, bool retain) {
  if (!state_.runs || !publish) return;
  ++state_.counters.published;
  if (payload.empty())  // the topic is no longer used
    own_.erase(topic);
  else
    own_.insert(topic);
  const auto queue = payload.size() > kLongList ? transport::MqttQueue::kLatest : transport::MqttQueue::kInOrder;
  const bool sure = topic == "bridge/state" || topic == "bridge/health" || topic.ends_with("/availability");
  publish(
      {state_.options.base + "/" + topic, std::move(payload), retain, sure ? std::uint8_t{1} : std::uint8_t{0}, queue});
}

void BridgeTopics::forget(const std::string& name) {
  own_.erase(name);
  own_.erase(name + "/availability");
}

void BridgeTopics::info() {
  say("bridge/info",
      model::dump(info_json(state_.options, registry_.devices(), state_.joining(), state_.joining_end,
                            state_.restart_required)),
      true);
}

void BridgeTopics::devices(const std::set<std::string>& without) {
  if (!state_.runs || !publish) return;
  auto list = "[" + model::dump(coordinator_record());
  for (auto* device : registry_.devices()) {
    if (!without.contains(device->address())) list += "," + device->record_text();
  }
  say("bridge/devices", list + "]", true);
}

void BridgeTopics::groups() {
  std::vector<const DeviceGroup*> all;
  for (const auto& [id, group] : registry_.groups()) all.push_back(&group);
  say("bridge/groups", model::dump(groups_json(all)), true);
}

void BridgeTopics::health() {
  const auto& counters = state_.counters;
  const auto now = state_.scheduler.now();
  say("bridge/health",
      model::dump(health_json(registry_.devices(), state_.scheduler.wall_now(), now - state_.began, counters.published,
                              counters.sets + counters.gets)),
      true);
}

void BridgeTopics::event(std::string_view type, const RadioDevice& device, Json more) {
  more["friendly_name"] = device.name();
  more["ieee_address"] = device.address();
  say("bridge/event", model::dump(Json{{"type", type}, {"data", std::move(more)}}));
}

void BridgeTopics::left(const std::string& name, const std::string& address) {
  Json gone{{"friendly_name", name}, {"ieee_address", address}};
  say("bridge/event", model::dump(Json{{"type", "device_leave"}, {"data", std::move(gone)}}));
}

void BridgeTopics::state(const RadioDevice& device, const Json& more) {
  auto known = device.known();
  known.update(more);
  if (const auto seen = last_seen_json(state_.options.last_seen, device.last_seen()); !seen.is_null())
    known["last_seen"] = seen;
  say(device.name(), model::dump(known));
}

void BridgeTopics::availability(const RadioDevice& device) {
  if (!state_.options.availability || device.options.value("availability", Json(true)) == false) return;
  say(device.name() + "/availability", availability_text(device.online), true);
}

void BridgeTopics::group(const DeviceGroup& group) {
  say(group.name, model::dump(group.state));
}

void BridgeTopics::group_availability(const DeviceGroup& group) {
  if (!state_.options.availability) return;
  const bool any = std::ranges::any_of(group.members, [this](const auto& address) {
    const auto* device = registry_.find(address);
    return device != nullptr && device->online;
  });
  say(group.name + "/availability", availability_text(any), true);
}

}  // namespace rubicon::zigbee_simulator
