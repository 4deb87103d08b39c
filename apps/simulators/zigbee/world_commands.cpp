#include <algorithm>

#include "apps/simulators/zigbee/world.h"
#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"

// What clients ask of devices and groups: set and get (zigbee.md, sections 5 and 7).
namespace rubicon::zigbee_simulator {

namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

/// As recorded: from the set to the first message, from the echo to the report of the device.
constexpr Duration kAnswerTime = 9ms, kReportTime = 25ms, kReadTime = 12ms;
/// A cover moves a third of its way in this time.
constexpr Duration kTravelTime = 1s;
constexpr int kTravelStep = 34;

/// A bare word such as `ON` is the state; `NAME/set/PROPERTY` has the bare value of one property.
Json wanted_json(std::string_view property, std::string_view payload) {
  auto value = model::parse_json(payload);
  if (value.is_discarded()) value = std::string(payload);
  if (!property.empty()) return Json{{property, value}};
  return value.is_object() ? value : Json{{"state", value}};
}

/// What a group shows of its members (zigbee.md, section 7).
bool is_shared(std::string_view property) {
  return property == "state" || property == "brightness" || property == "color_temp" || property == "color" ||
         property == "color_mode" || property == "position";
}

}  // namespace

void World::set(std::string_view name, std::string_view property, std::string_view payload) {
  ++counters_.sets;
  const auto wanted = wanted_json(property, payload);
  if (auto* device = find(name); device != nullptr && device->usable()) return set_device(*device, wanted);
  if (auto* group = find_group(name)) return set_group(*group, wanted);
  ++counters_.rejected;
}

void World::set_device(RadioDevice& device, const Json& wanted) {
  const auto accepted = device.acceptable(wanted);
  if (accepted.empty()) {
    ++counters_.rejected;
    return;
  }
  if (device.faults.silent) return;
  if (device.model().sleeps) return device.waiting.update(accepted);
  later(device, kAnswerTime + device.faults.delay,
        [this, accepted](RadioDevice& found) { answer_set(found, accepted); });
}

/// The device is heard because it acknowledges the set; the echo has the same last_seen, or the one before if it
/// overtakes.
void World::answer_set(RadioDevice& device, const Json& accepted) {
  if (device.faults.silent) return;
  if (device.faults.refuses) return hear(device);
  const bool optimistic = options_.optimistic && device.options.value("optimistic", Json(true)) != false;
  const auto echo = optimistic ? device.echo(accepted) : Json::object();
  const auto show_echo = [&] {
    for (const auto& [property, value] : echo.items()) device.know(property, value);
    if (!echo.empty()) publish_state(device);
  };
  if (device.faults.echo_first) show_echo();
  hear(device);
  if (!device.faults.echo_first) show_echo();
  if (!echo.empty()) follow_members(device);
  if (!device.faults.ignores) do_set(device, accepted);
}

void World::do_set(RadioDevice& device, const Json& accepted) {
  const auto position = device.real("position");
  const bool stops = accepted.value("state", Json()) == "STOP";
  if (stops) travels_.erase(device.address());
  const auto done = device.execute(accepted);
  const auto goal = device.real("position");
  if (!position.is_number() || !goal.is_number() || position == goal) {
    later(device, kReportTime, [this, done](RadioDevice& found) {
      for (const auto& properties : found.by_cluster(done)) publish_report(found, properties);
    });
    return;
  }
  device.set_real("position", position);
  travel(device, goal.get<int>());
}

/// Moves a cover to its goal, with a report at each step.
void World::travel(RadioDevice& device, int goal) {
  travels_[device.address()] = scheduler_.after(kTravelTime, [this, goal, address = device.address()] {
    auto* found = find(address);
    if (found == nullptr || found->faults.silent) return;
    const auto position = found->real("position");
    if (!position.is_number()) return;
    const int now = position.get<int>();
    const int next = now + std::clamp(goal - now, -kTravelStep, kTravelStep);
    found->set_real("position", next);
    found->set_real("state", next == 0 ? "CLOSE" : "OPEN");
    publish_report(*found, {"position", "state"});
    if (next != goal) travel(*found, goal);
  });
}

void World::get(std::string_view name, std::string_view property, std::string_view payload) {
  ++counters_.gets;
  auto* device = find(name);
  if (device == nullptr || !device->usable()) {
    ++counters_.rejected;
    return;
  }
  const auto properties = device->readable(wanted_json(property, payload));
  if (properties.empty()) ++counters_.rejected;
  if (properties.empty() || device->faults.silent || device->faults.refuses || device->model().sleeps) return;
  later(*device, kReadTime + device->faults.delay,
        [this, properties](RadioDevice& found) { answer_get(found, properties); });
}

void World::answer_get(RadioDevice& device, const std::vector<std::string>& properties) {
  if (device.faults.silent) return;
  for (const auto& read : device.by_cluster(properties)) publish_report(device, read);
}

DeviceGroup* World::find_group(std::string_view name_or_id) {
  for (auto& [id, group] : groups_) {
    if (group.name == name_or_id || base::parse_number<int>(name_or_id) == id) return &group;
  }
  return nullptr;
}

/// First the group, then the echo of each member, then what the members report.
void World::set_group(DeviceGroup& group, const Json& wanted) {
  std::vector<std::pair<RadioDevice*, Json>> reached;
  for (const auto& address : group.members) {
    auto* device = find(address);
    if (device == nullptr || device->faults.silent) continue;
    if (auto accepted = device->acceptable(wanted); !accepted.empty())
      reached.emplace_back(device, std::move(accepted));
  }
  if (reached.empty()) {
    ++counters_.rejected;
    return;
  }
  for (const auto& [property, value] : reached.front().second.items()) group.state[property] = value;
  publish_group(group);
  for (auto& [device, accepted] : reached) {
    const auto echo = device->echo(accepted);
    for (const auto& [property, value] : echo.items()) device->know(property, value);
    if (!echo.empty()) publish_state(*device);
    if (!device->faults.ignores) do_set(*device, accepted);
  }
}

/// A group follows what its members report; it is off when all are.
void World::follow_members(const RadioDevice& member) {
  for (auto& [id, group] : groups_) {
    if (std::ranges::find(group.members, member.address()) == group.members.end()) continue;
    auto state = group.state;
    const auto known = member.known();
    for (const auto& [property, value] : known.items()) {
      if (is_shared(property) && !value.is_null()) state[property] = value;
    }
    const auto is_on = [this](const auto& address) {
      auto* device = find(address);
      return device != nullptr && device->known().value("state", Json()) == "ON";
    };
    if (std::ranges::any_of(group.members, is_on)) state["state"] = "ON";
    if (state == group.state) continue;
    group.state = std::move(state);
    publish_group(group);
  }
}

void World::publish_group(DeviceGroup& group) {
  say(group.name, model::dump(group.state));
}

void World::publish_group_availability(const DeviceGroup& group) {
  const auto online = [this](const auto& address) {
    const auto* device = find(address);
    return device != nullptr && device->online;
  };
  if (!options_.availability) return;
  const bool any = std::ranges::any_of(group.members, online);
  say(group.name + "/availability", any ? R"({"state":"online"})" : R"({"state":"offline"})", true);
}

}  // namespace rubicon::zigbee_simulator
