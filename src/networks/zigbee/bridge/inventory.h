#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "base/scheduler.h"
#include "networks/zigbee/bridge/device_record.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::zigbee::bridge {

/// Whether the lists of the bridge have a device, and when their lack of it means that it is gone: a list can be
/// published in the middle of a change (zigbee.md, section 9), and a retained copy can be older than the bridge.
class Presence {
 public:
  static constexpr Duration kAbsence = std::chrono::seconds(10);
  /// The same for a device that only a retained copy lacks: a living device with a battery reports within this time.
  static constexpr Duration kRetainedAbsence = std::chrono::hours(25);

  /// A list has the device. `list`: its number; `received`: number of messages received up to then.
  void listed(std::uint64_t list, std::uint64_t received);
  bool in_list(std::uint64_t list) const { return listed_in_ == list; }
  /// A complete list lacks it. Why it is gone, or nullptr if it is not gone yet.
  const char* lacked(bool live_list, SteadyTime now);
  /// The same by the time alone.
  const char* overdue(SteadyTime now) const;
  /// When overdue() is to be asked; nullopt: the last list has the device, or nothing is known.
  std::optional<SteadyTime> due() const;
  /// A live message of the device or about it.
  void heard();
  /// Number of lists that had arrived when the bridge reported that the device left, or removed it.
  void leaving(std::uint64_t received) { leaving_after_ = received; }
  /// Another connection, another chance.
  void line_lost();

 private:
  std::uint64_t listed_in_ = 0;
  std::optional<SteadyTime> missing_since_;
  bool missing_live_ = false;  ///< a live list lacks it
  bool heard_ = false;         ///< since the line was lost
  std::optional<std::uint64_t> leaving_after_;
};

/// The devices of a bridge, kept by its `bridge/devices` lists; the coordinator is none. Compares each list with the
/// one before by ieee address, in turns of bounded work; a list equal to the one before is dropped, and only records
/// that changed are parsed. While a list is compared, only the newest of those that arrive waits. A retained copy may
/// be older than what the bridge knows: a broker that was killed comes back with the copy it saved last.
class Inventory {
 public:
  /// Work of one turn, in bytes: records that are only compared, and records that are parsed. One record may exceed it.
  static constexpr std::size_t kComparedPerTurn = std::size_t{1} * 1024 * 1024, kParsedPerTurn = std::size_t{48} * 1024;

  /// Called in turns of their own, never inside a call to the inventory. Each may destroy the inventory.
  struct Callbacks {
    /// A new device, interviewed and supported; or one whose record changed in any way: name, definition, power source.
    /// A device that was usable stays so while it is interviewed again.
    std::function<void(const DeviceRecord& record)> changed;
    /// The device is not in the list any longer: absent from two different lists in a row, or for
    /// Presence::kAbsence (from a retained copy: for kRetainedAbsence without a sign of life), or the bridge reported
    /// that it left. Also a device of expect() that no list has.
    std::function<void(const std::string& address, const std::string& reason)> left;
    /// Not usable: interview pending, in progress or failed, not supported, disabled. `why` says which, and what the
    /// user can do.
    std::function<void(const DeviceRecord& record, const std::string& why)> waiting;
    /// A list or a record cannot be read, or there are too many devices; the devices stay as they were. Once per text.
    std::function<void(const Error& error)> unreadable;
    /// The newest list is compared completely; also if it is equal to the one before.
    std::function<void()> compared;
  };
  /// What it did since it exists.
  struct Counters {
    std::uint64_t lists = 0;       ///< received
    std::uint64_t repeated = 0;    ///< equal to the one before
    std::uint64_t replaced = 0;    ///< by a newer one, before it was compared
    std::uint64_t compared = 0;    ///< completely
    std::uint64_t parsed = 0;      ///< records
    std::uint64_t unreadable = 0;  ///< lists and records
    std::size_t longest_turn = 0;  ///< most bytes parsed in one turn
  };
  Inventory(Scheduler& scheduler, std::size_t most_devices, Callbacks calls);
  ~Inventory();

  /// A payload of `bridge/devices`, copied once. An empty payload is ignored. `retained`: as the broker marks it; after
  /// a live list of the same connection it counts as live.
  void list(std::string_view payload, bool retained = false);
  /// The device was there before this inventory: if the lists lack it, it leaves by the same rules. At most as many as
  /// devices; others are ignored.
  void expect(const std::string& address);
  /// A live message of the device or about it, on this connection: the bridge has it, also if a retained copy lacks it.
  void heard(const std::string& address);
  /// `bridge/event` reported that the device left, or the bridge removed it for us: it leaves at once if the newest
  /// list lacks it, or the next one.
  void leaving(std::string_view address);
  /// The bridge or the broker is gone: devices that were absent from the last list get another chance in the next one.
  void line_lost();
  /// Also devices that wait. nullptr if unknown. Valid until the next turn.
  const DeviceRecord* find(const std::string& address) const;
  /// By friendly name.
  const DeviceRecord* find_named(std::string_view name) const;
  /// Every device in the order of the addresses; `why` is empty if it is usable.
  void each(const std::function<void(const DeviceRecord& record, const std::string& why)>& call) const;
  std::size_t size() const;
  const Counters& counters() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::networks::zigbee::bridge
