#include "apps/simulators/zigbee/radio.h"

#include <algorithm>
#include <utility>

namespace rubicon::zigbee_simulator {

namespace {

using namespace std::chrono_literals;

/// Availability: when the bridge gives a device up (zigbee.md, section 6; timeout 1 min, measured 62.5 s).
constexpr Duration kMainsSilence = 62500ms, kBatterySilence = 1500min + 1s;
/// A cover moves a third of its way in this time.
constexpr Duration kTravelTime = 1s;
constexpr int kTravelStep = 34;

/// What a group shows of its members (zigbee.md, section 7).
bool is_shared(std::string_view property) {
  return property == "state" || property == "brightness" || property == "color_temp" || property == "color" ||
         property == "color_mode" || property == "position";
}

}  // namespace

void Radio::hear(RadioDevice& device) {
  device.heard(state_.scheduler.wall_now(), random_);
  topics_.state(device);
  mark(device, true);
}

void Radio::announce(RadioDevice& device) {
  hear(device);
  topics_.event("device_announce", device);
}

void Radio::mark(RadioDevice& device, bool online) {
  if (device.online == online) return;
  device.online = online;
  topics_.availability(device);
  for (const auto* group : registry_.groups_of(device)) topics_.group_availability(*group);
}

void Radio::set_faults(RadioDevice& device, Faults faults) {
  const bool was_silent = device.faults.silent;
  device.faults = faults;
  if (faults.silent == was_silent) return;
  if (!faults.silent) return hear(device);
  const auto limit = device.model().battery ? kBatterySilence : kMainsSilence;
  silences_[device.address()] = state_.scheduler.after(limit, [this, address = device.address()] {
    auto* found = registry_.find(address);
    if (found != nullptr && found->faults.silent) mark(*found, false);
  });
}

void Radio::change(RadioDevice& device, const std::string& property, Json value) {
  device.set_real(property, std::move(value));
  if (device.faults.silent) return;
  report(device, {property});
  clear_later(device, property);
}

void Radio::act(RadioDevice& device, const std::string& property, const Json& value) {
  if (device.faults.silent) return;
  device.heard(state_.scheduler.wall_now(), random_);
  topics_.state(device, {{property, value}});
  mark(device, true);
}

void Radio::report(RadioDevice& device) {
  if (device.faults.silent) return;
  device.walk(random_);
  const auto groups = device.by_cluster(device.measured());
  if (groups.empty()) hear(device);
  for (const auto& properties : groups) report(device, properties);
  if (!device.waiting.empty() && woke) woke(device, std::exchange(device.waiting, Json::object()));
}

/// One message, with a new last_seen and the new values. A device that reports two clusters at once sends two, which
/// have the same last_seen.
void Radio::report(RadioDevice& device, const std::vector<std::string>& properties) {
  device.heard(state_.scheduler.wall_now(), random_);
  device.report(properties);
  topics_.state(device);
  mark(device, true);
  follow(device);
}

/// The bridge sets an occupancy back by itself: the message has the last_seen of the one before.
void Radio::clear_later(RadioDevice& device, const std::string& property) {
  const auto& clears = device.model().clears;
  if (!clears || clears->property != property) return;
  clearings_[device.address()] = state_.scheduler.after(clears->after, [this, address = device.address()] {
    auto* found = registry_.find(address);
    if (found == nullptr || !state_.runs) return;
    const auto& clearing = *found->model().clears;
    found->set_real(clearing.property, clearing.value);
    found->report({clearing.property});
    topics_.state(*found);
  });
}

void Radio::begin(RadioDevice& device) {
  if (device.every <= Duration{} || !device.usable()) return;
  const auto first = Duration(random_.between(1, device.every.count()));
  periods_[device.address()] =
      state_.scheduler.after(first, [this, address = device.address()] { next_period(address); });
}

void Radio::next_period(const std::string& address) {
  auto* device = registry_.find(address);
  if (device == nullptr) return;
  periods_[address] = state_.scheduler.after(device->every, [this, address] { next_period(address); });
  report(*device);
}

void Radio::travel(RadioDevice& device, int goal) {
  travels_[device.address()] = state_.scheduler.after(kTravelTime, [this, goal, address = device.address()] {
    auto* found = registry_.find(address);
    if (found == nullptr || found->faults.silent) return;
    const auto position = found->real("position");
    if (!position.is_number()) return;
    const int now = position.get<int>();
    const int next = now + std::clamp(goal - now, -kTravelStep, kTravelStep);
    found->set_real("position", next);
    found->set_real("state", next == 0 ? "CLOSE" : "OPEN");
    report(*found, {"position", "state"});
    if (next != goal) travel(*found, goal);
  });
}

void Radio::follow(const RadioDevice& member) {
  for (auto* group : registry_.groups_of(member)) {
    auto state = group->state;
    const auto known = member.known();
    for (const auto& [property, value] : known.items()) {
      if (is_shared(property) && !value.is_null()) state[property] = value;
    }
    const auto is_on = [this](const auto& address) {
      const auto* device = registry_.find(address);
      return device != nullptr && device->known().value("state", Json()) == "ON";
    };
    if (std::ranges::any_of(group->members, is_on)) state["state"] = "ON";
    if (state == group->state) continue;
    group->state = std::move(state);
    topics_.group(*group);
  }
}

void Radio::forget(const std::string& address) {
  for (auto* timers : {&periods_, &silences_, &clearings_, &travels_}) timers->erase(address);
}

}  // namespace rubicon::zigbee_simulator
