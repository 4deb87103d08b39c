#include "apps/simulators/zigbee/registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/text.h"

namespace rubicon::zigbee_simulator {

/// As the bridge checks friendly names [zigbee.md, section 1].
Result<void> Registry::check_name(std::string_view name) const {
  const auto wrong = [](std::string why) { return fail(ErrorCode::kInvalid, std::move(why)); };
  if (name.empty()) return wrong("friendly_name must be at least 1 char long");
  if (name.starts_with('/') || name.ends_with('/')) return wrong("friendly_name is not allowed to end or start with /");
  if (name.find_first_of("+#") != name.npos)
    return wrong(fmt::format("MQTT wildcard (+ and #) not allowed in friendly_name ('{}')", name));
  if (std::ranges::any_of(name, [](char one) { return static_cast<unsigned char>(one) < 0x20 || one == 0x7f; }))
    return wrong("friendly_name is not allowed to contain control char");
  const auto slash = name.rfind('/');
  if (slash != name.npos && name.find_first_not_of("0123456789", slash + 1) == name.npos)
    return wrong(fmt::format("Friendly name cannot end with a \"/DIGIT\" ('{}')", name));
  const bool group = std::ranges::any_of(groups_, [&](auto& one) { return one.second.name == name; });
  if (group || by_name_.contains(name)) return wrong(fmt::format("friendly_name '{}' is already in use", name));
  return {};
}

void Registry::note(const std::string& name, bool used) const {
  if (named) named(name, used);
}

std::string Registry::next_address() {
  return fmt::format("0x00124b00{:08x}", 0x10000000U + last_address_++);
}

RadioDevice& Registry::add(DeviceModel model, const std::string& address, const std::string& name) {
  devices_.push_back(std::make_unique<RadioDevice>(std::move(model), address, name,
                                                   static_cast<std::uint16_t>(4096 + devices_.size() % 60000)));
  auto& device = *devices_.back();
  by_name_[name] = by_address_[address] = &device;
  note(name, true);
  return device;
}

void Registry::rename(RadioDevice& device, const std::string& to) {
  const auto from = device.name();
  by_name_.erase(from);
  by_name_[to] = &device;
  device.rename(to);
  note(from, false);
  note(to, true);
}

void Registry::erase(const RadioDevice& device) {
  note(device.name(), false);
  by_name_.erase(device.name());
  by_address_.erase(device.address());
  for (auto& [id, group] : groups_) std::erase(group.members, device.address());
  std::erase_if(devices_, [&](const auto& one) { return one.get() == &device; });
}

RadioDevice* Registry::find(std::string_view name_or_address) const {
  if (const auto named_so = by_name_.find(name_or_address); named_so != by_name_.end()) return named_so->second;
  const auto found = by_address_.find(name_or_address);
  return found == by_address_.end() ? nullptr : found->second;
}

std::vector<RadioDevice*> Registry::devices() const {
  std::vector<RadioDevice*> all;
  for (const auto& device : devices_) {
    if (device->joined) all.push_back(device.get());
  }
  return all;
}

DeviceGroup& Registry::add_group(int id, std::string name, std::vector<std::string> members) {
  if (id == 0) id = groups_.empty() ? 1 : groups_.rbegin()->first + 1;
  note(name, true);
  return groups_[id] = {id, std::move(name), std::move(members)};
}

void Registry::rename_group(DeviceGroup& group, const std::string& to) {
  const auto from = std::exchange(group.name, to);
  note(from, false);
  note(to, true);
}

void Registry::erase_group(int id) {
  const auto gone = groups_.extract(id);
  if (!gone.empty()) note(gone.mapped().name, false);
}

DeviceGroup* Registry::find_group(std::string_view name_or_id) {
  for (auto& [id, group] : groups_) {
    if (group.name == name_or_id || base::parse_number<int>(name_or_id) == id) return &group;
  }
  return nullptr;
}

std::vector<DeviceGroup*> Registry::groups_of(const RadioDevice& member) {
  std::vector<DeviceGroup*> all;
  for (auto& [id, group] : groups_) {
    if (std::ranges::find(group.members, member.address()) != group.members.end()) all.push_back(&group);
  }
  return all;
}

void Delays::after(Duration delay, std::function<void()> call) {
  const auto id = ++last_;
  timers_[id] = scheduler_.after(delay, [this, id, call = std::move(call)] {
    const auto run = call;
    timers_.erase(id);
    run();
  });
}

void Delays::after(const RadioDevice& device, Duration delay, std::function<void(RadioDevice&)> call) {
  after(delay, [this, address = device.address(), call = std::move(call)] {
    if (auto* found = registry_.find(address)) call(*found);
  });
}

}  // namespace rubicon::zigbee_simulator
