#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "base/scheduler.h"
#include "networks/zigbee/bridge/device_record.h"

namespace rubicon::networks::zigbee::bridge {

/// The devices of a bridge, kept by its `bridge/devices` lists. Compares each list with the one before by ieee address,
/// device by device in turns of at most 5 ms; only changed records are parsed. While a list is compared, only the
/// newest of those that arrive waits.
class Inventory {
 public:
  /// Called in turns of their own, never inside a call to the inventory.
  struct Calls {
    /// A new device, interviewed and supported; or one whose record changed in any way: name, definition, power source.
    std::function<void(const DeviceRecord& record)> changed;
    /// The device is not in the list any longer: absent from two lists in a row, or for 10 s, or it said that it
    /// leaves.
    std::function<void(const std::string& address, const std::string& reason)> left;
    /// Not usable: interview pending, in progress or failed, not supported, disabled. `why` says which.
    std::function<void(const DeviceRecord& record, const std::string& why)> waiting;
    /// A list or a record cannot be read; the devices stay as they were.
    std::function<void(const Error& error)> unreadable;
    /// The newest list is compared completely.
    std::function<void()> compared;
  };
  Inventory(Scheduler& scheduler, std::size_t most_devices, Calls calls);
  ~Inventory();

  /// A payload of `bridge/devices`.
  void list(std::string_view payload);
  /// `bridge/event` reported that the device left: it leaves at once if it is absent from the next list.
  void leaving(std::string_view address);
  /// nullptr if unknown.
  const DeviceRecord* find(const std::string& address) const;
  std::size_t size() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::networks::zigbee::bridge
