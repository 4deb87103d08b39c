#include "apps/simulators/zigbee/commands.h"

#include <utility>

#include "model/json_text.h"

namespace rubicon::zigbee_simulator {

namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

/// As recorded: from the set to the first message, from the echo to the report of the device.
constexpr Duration kAnswerTime = 9ms, kReportTime = 25ms, kReadTime = 12ms;

/// A bare word such as `ON` is the state; `NAME/set/PROPERTY` has the bare value of one property.
Json wanted_json(std::string_view property, std::string_view payload) {
  auto value = model::parse_json(payload);
  if (value.is_discarded()) value = std::string(payload);
  if (!property.empty()) return Json{{property, value}};
  return value.is_object() ? value : Json{{"state", value}};
}

}  // namespace

Commands::Commands(BridgeState& state, Registry& registry, BridgeTopics& topics, Radio& radio, Delays& delays)
    : state_(state), registry_(registry), topics_(topics), radio_(radio), delays_(delays) {
  radio_.woke = [this](RadioDevice& device, const Json& wanted) {
    delays_.after(device, kAnswerTime, [this, wanted](RadioDevice& found) { answer_set(found, wanted); });
  };
}

void Commands::set(std::string_view name, std::string_view property, std::string_view payload) {
  ++state_.counters.sets;
  const auto wanted = wanted_json(property, payload);
  if (auto* device = registry_.find(name); device != nullptr && device->usable()) return set_device(*device, wanted);
  if (auto* group = registry_.find_group(name)) return set_group(*group, wanted);
  ++state_.counters.rejected;
}

void Commands::set_device(RadioDevice& device, const Json& wanted) {
  const auto accepted = device.acceptable(wanted);
  if (accepted.empty()) {
    ++state_.counters.rejected;
    return;
  }
  if (device.faults.silent) return;
  if (device.model().sleeps) return device.waiting.update(accepted);
  delays_.after(device, kAnswerTime + device.faults.delay,
                [this, accepted](RadioDevice& found) { answer_set(found, accepted); });
}

/// The device is heard because it acknowledges the set; the echo has the same last_seen, or the one before if it
/// overtakes.
void Commands::answer_set(RadioDevice& device, const Json& accepted) {
  if (device.faults.silent) return;
  if (device.faults.refuses) return radio_.hear(device);
  const bool optimistic = state_.options.optimistic && device.options.value("optimistic", Json(true)) != false;
  const auto echo = optimistic ? device.echo(accepted) : Json::object();
  if (device.faults.echo_first) show_echo(device, echo);
  radio_.hear(device);
  if (!device.faults.echo_first) show_echo(device, echo);
  if (!echo.empty()) radio_.follow(device);
  if (!device.faults.ignores) do_set(device, accepted);
}

void Commands::show_echo(RadioDevice& device, const Json& echo) {
  for (const auto& [property, value] : echo.items()) device.know(property, value);
  if (!echo.empty()) topics_.state(device);
}

void Commands::do_set(RadioDevice& device, const Json& accepted) {
  const auto position = device.real("position");
  const bool stops = accepted.value("state", Json()) == "STOP";
  if (stops) radio_.stop_travel(device);
  const auto done = device.execute(accepted);
  const auto goal = device.real("position");
  if (!position.is_number() || !goal.is_number() || position == goal) {
    delays_.after(device, kReportTime, [this, done](RadioDevice& found) {
      for (const auto& properties : found.by_cluster(done)) radio_.report(found, properties);
    });
    return;
  }
  device.set_real("position", position);
  radio_.travel(device, goal.get<int>());
}

void Commands::get(std::string_view name, std::string_view property, std::string_view payload) {
  ++state_.counters.gets;
  auto* device = registry_.find(name);
  if (device == nullptr || !device->usable()) {
    ++state_.counters.rejected;
    return;
  }
  const auto properties = device->readable(wanted_json(property, payload));
  if (properties.empty()) ++state_.counters.rejected;
  if (properties.empty() || device->faults.silent || device->faults.refuses || device->model().sleeps) return;
  delays_.after(*device, kReadTime + device->faults.delay,
                [this, properties](RadioDevice& found) { answer_get(found, properties); });
}

void Commands::answer_get(RadioDevice& device, const std::vector<std::string>& properties) {
  if (device.faults.silent) return;
  for (const auto& read : device.by_cluster(properties)) radio_.report(device, read);
}

/// First the group, then the echo of each member, then what the members report.
void Commands::set_group(DeviceGroup& group, const Json& wanted) {
  std::vector<std::pair<RadioDevice*, Json>> reached;
  for (const auto& address : group.members) {
    auto* device = registry_.find(address);
    if (device == nullptr || device->faults.silent) continue;
    if (auto accepted = device->acceptable(wanted); !accepted.empty())
      reached.emplace_back(device, std::move(accepted));
  }
  if (reached.empty()) {
    ++state_.counters.rejected;
    return;
  }
  for (const auto& [property, value] : reached.front().second.items()) group.state[property] = value;
  topics_.group(group);
  for (auto& [device, accepted] : reached) {
    show_echo(*device, device->echo(accepted));
    if (!device->faults.ignores) do_set(*device, accepted);
  }
}

}  // namespace rubicon::zigbee_simulator
