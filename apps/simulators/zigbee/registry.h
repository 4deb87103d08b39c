#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "apps/simulators/zigbee/radio_device.h"
#include "base/scheduler.h"
#include "rubicon/result.hpp"

namespace rubicon::zigbee_simulator {

/// A group of the bridge.
struct DeviceGroup {
  int id = 0;
  std::string name;
  std::vector<std::string> members;  ///< addresses
  nlohmann::json state = nlohmann::json::object();
};

/// The devices and groups that a bridge knows, each by its names. Devices are named by friendly name or address.
class Registry {
 public:
  /// A friendly name is new, or no longer used: its topics are to be listened to. May be empty.
  std::function<void(const std::string& name, bool used)> named;

  /// kInvalid: the name is in use or not permitted.
  Result<void> check_name(std::string_view name) const;

  std::string next_address();
  RadioDevice& add(DeviceModel model, const std::string& address, const std::string& name);
  void rename(RadioDevice& device, const std::string& to);
  void erase(const RadioDevice& device);
  /// nullptr if there is none.
  RadioDevice* find(std::string_view name_or_address) const;
  /// Those that the bridge has in its list.
  std::vector<RadioDevice*> devices() const;
  std::size_t size() const { return devices_.size(); }

  /// 0: the next free id.
  DeviceGroup& add_group(int id, std::string name, std::vector<std::string> members);
  void rename_group(DeviceGroup& group, const std::string& to);
  void erase_group(int id);
  /// nullptr if there is none.
  DeviceGroup* find_group(std::string_view name_or_id);
  std::map<int, DeviceGroup>& groups() { return groups_; }
  const std::map<int, DeviceGroup>& groups() const { return groups_; }
  std::vector<DeviceGroup*> groups_of(const RadioDevice& member);

 private:
  void note(const std::string& name, bool used) const;

  std::vector<std::unique_ptr<RadioDevice>> devices_;
  std::map<std::string, RadioDevice*, std::less<>> by_name_, by_address_;
  std::map<int, DeviceGroup> groups_;
  std::uint32_t last_address_ = 0;
};

/// What a bridge does later, if it still runs and the device is still there.
class Delays {
 public:
  Delays(Scheduler& scheduler, const Registry& registry) : scheduler_(scheduler), registry_(registry) {}

  void after(Duration delay, std::function<void()> call);
  void after(const RadioDevice& device, Duration delay, std::function<void(RadioDevice&)> call);
  void clear() { timers_.clear(); }

 private:
  Scheduler& scheduler_;
  const Registry& registry_;
  std::map<std::uint64_t, Timer> timers_;
  std::uint64_t last_ = 0;
};

}  // namespace rubicon::zigbee_simulator
