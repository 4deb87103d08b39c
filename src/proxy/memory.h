#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "proxy/device_directory.h"
#include "state/state_store.h"

namespace rubicon::proxy {

/// Decides what of the devices is written to the state file, and when (docs/state.md). Records are written within a
/// second, values every save period, decisions and properties set by users within 100 ms and durably. What could not be
/// written is retried. Without a state file nothing is remembered.
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
  /// Visits all that is remembered of a network (empty = of all), in the order in which the devices were first seen.
  void each(const std::string& network, const std::function<void(Row, state::KnownDevice&&)>& visit);

  /// The device joined, for the first time or with other capabilities or names.
  void record_changed(Device& device);
  /// Values or qualities of the device are newer than those written. Cheap.
  void values_changed(DeviceNumber number);
  /// The value of the point is newer than that written.
  static void note_value(Point& point) { point.storage.unsaved = true; }
  static void restore_origin(Point& point, bool set_by_user) { point.storage.set_by_user = set_by_user; }
  /// A user set a property, and the device accepted it.
  void property_set(Device& device, Point& point);
  /// A user approved the device, which is listed now.
  void approved(Device& device);
  /// Writes given_name and given_area durably before it returns. kRefused: there is no state file that can be written;
  /// kBusy: too many names at once.
  Result<void> save_names(Device& device);
  /// Remembers a device that is not listed: it is pending (kNone), ignored, or approved and without room.
  void save_unlisted(const std::string& network, const std::string& address, const model::Join& join,
                     state::Decision decision);
  /// Forgets a device that is not listed.
  void forget(const std::string& network, const std::string& address);
  /// The decision of a user about a device that is not listed ends. Forgets the device, unless a user named it.
  void end_decision(const std::string& network, const std::string& address, const model::Join& join);
  /// The device left for good: forgets it but for the decision of a user. Call before it leaves the directory.
  void left(const Device& device);
  /// The devices leave the directory for other reasons: writes what is newer than the file.
  void save_before_removal(std::span<Device* const> devices);

  static void restore_decision(Device& device, const state::KnownDevice& known) {
    device.storage.decision = known.decision;
  }
  static void restore_row(Device& device, Row row) { device.storage.row = row; }

 private:
  using Name = std::pair<std::string, std::string>;

  void mark(Device& device, Duration within);
  void write_soon();
  void schedule_flush(Duration within);
  void flush();
  void tidy();
  std::vector<Name> write_unlisted(std::size_t most, bool& written);
  bool write_devices(std::span<Device* const> devices);
  bool write_one(const Name& name, const std::optional<state::KnownDevice>& known);
  bool write_one(Device& device);
  Result<void> save(Device& device);
  Result<void> save_values(const Device& device);
  Result<void> save_name(Device& device);
  std::vector<Device*> next_devices(std::size_t most);
  bool transaction(bool durable, const std::function<bool()>& write);
  void keep_decision(const Device& device);
  bool can_continue(const Result<void>& result);

  ProxyContext& context_;
  DeviceDirectory& directory_;
  state::StateStore* store_;
  bool writable_;
  std::vector<DeviceNumber> dirty_;
  std::map<Name, std::optional<state::KnownDevice>> unlisted_;  ///< not written yet; nullopt = to be forgotten
  base::Deadline next_flush_;
  SteadyTime tidy_at_{}, durable_at_{};
  SteadyTime names_since_{};
  int names_ = 0;         ///< written since names_since_
  bool durable_ = false;  ///< the next flush must reach the disk
};

/// The announcement of a listed device, without initial values: those are outdated.
model::Join announcement(const Device& device);
/// Equal names and capabilities, but for initial values.
bool is_announcement(const model::Join& known, const model::Join& join);

}  // namespace rubicon::proxy
