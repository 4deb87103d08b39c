#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/deadline.h"
#include "proxy/device_directory.h"
#include "state/state_store.h"

namespace rubicon::proxy {

/// What the proxy remembers across restarts (docs/state.md): decides what is written when; the state file does the
/// rest. Records are written within a second, values every save period, decisions and properties set by users within
/// 100 ms and durably. What could not be written is tried again. Without a state file nothing is remembered.
class Memory {
 public:
  Memory(ProxyContext& context, DeviceDirectory& directory, state::StateStore* store);
  /// Writes what is not written yet.
  ~Memory();
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;

  /// What is remembered of a device; nullopt also when the file cannot be read.
  std::optional<state::KnownDevice> recall(const std::string& network, const std::string& address);
  using Row = state::StateStore::Row;
  /// All that is remembered of a network (empty = all), in the order in which the devices were first seen.
  void each(const std::string& network, const std::function<void(Row, state::KnownDevice&&)>& visit);

  /// Joined, or joined anew with other capabilities or names.
  void record_changed(Device& device);
  /// Cheap: notes that some value or quality of the device is newer than what is written.
  void values_changed(DeviceNumber number);
  /// A user set a property, and the device took it.
  void property_set(Device& device, Point& point);
  /// A user approved the device, which has just joined.
  void approved(Device& device);
  /// A user gave the device its given_name and given_area: on the disk when this returns. kRefused: nothing can be
  /// remembered here; kBusy: too many at once.
  Result<void> save_names(Device& device);
  /// A device that is not in the directory waits (kNone), was ignored, or was approved and found no room.
  void absent(const std::string& network, const std::string& address, const model::Join& join,
              state::Decision decision);
  /// A waiting device said that it is gone for good.
  void forget(const std::string& network, const std::string& address);
  /// The device said that it is gone for good: what the user decided about it stays.
  void left(const Device& device);
  /// They go out of the directory, for reasons that say nothing about them: everything stays.
  void dropped(std::span<Device* const> devices);

 private:
  using Name = std::pair<std::string, std::string>;

  void mark(Device& device, Duration within);
  void soon();
  void ask(Duration within);
  void flush();
  void tidy();
  std::vector<Name> write_absent(std::size_t most, bool& written);
  bool write_devices(std::span<Device* const> devices);
  bool write_one(const Name& name, const std::optional<state::KnownDevice>& known);
  bool write_one(Device& device);
  Result<void> save(Device& device);
  Result<void> save_values(const Device& device);
  Result<void> save_name(Device& device);
  std::vector<Device*> next_devices(std::size_t most);
  bool transaction(bool durable, const std::function<bool()>& write);
  void keep_decision(const Device& device);
  bool goes_on(const Result<void>& result);

  ProxyContext& context_;
  DeviceDirectory& directory_;
  state::StateStore* store_;
  bool writable_;
  std::vector<DeviceNumber> dirty_;
  std::map<Name, std::optional<state::KnownDevice>> absent_;  ///< not written yet; nullopt = to be forgotten
  base::Deadline next_flush_;
  SteadyTime tidy_at_{}, durable_at_{};
  SteadyTime names_since_{};
  int names_ = 0;         ///< written since then
  bool durable_ = false;  ///< what waits must be on the disk
};

/// What the device said of itself, put together again; without initial values, which are old by now.
model::Join announcement(const Device& device);
/// The same as `join` says, but for its initial values.
bool is_announcement(const model::Join& known, const model::Join& join);

}  // namespace rubicon::proxy
