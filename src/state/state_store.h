#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "model/address.h"
#include "model/message.h"

namespace rubicon::state {

/// What the user said about a device that announced itself.
enum class Decision : std::uint8_t { kNone, kApproved, kIgnored };
std::string_view to_string(Decision decision);

/// The last value of one point.
struct StoredValue {
  model::PointId point;
  model::Value value;
  WallTime heard{};  ///< zero = never heard (a property the user set)
  WallTime changed{};
  WallTime user_time{};  ///< zero = not known
  bool set_by_user = false;

  friend bool operator==(const StoredValue&, const StoredValue&) = default;
};

/// A device as it is remembered.
struct KnownDevice {
  std::string network;
  std::string address;
  std::string id;  ///< its part of the keys; empty = it never had one (waiting, ignored)
  Decision decision = Decision::kNone;
  model::Join join;                                               ///< its last announcement
  std::vector<std::pair<model::PointId, std::string>> point_ids;  ///< the parts of the keys its points have: `light-1`
  WallTime first_seen{}, last_heard{};                            ///< zero = never heard
  std::vector<StoredValue> values;
};

struct StateOptions {
  std::uint64_t max_bytes = 256ULL << 20;  ///< of the file; beyond it the devices not heard for longest are forgotten
};

/// The one place that remembers across restarts: one SQLite file an island. Everything is written by the calling
/// thread in short transactions; a process that dies at any instant leaves the file as it was after one of them.
/// Commands are never stored.
class StateStore {
 public:
  /// Makes the file if there is none. kInvalid: not a state file, or damaged; kRefused: of another island, or made by a
  /// newer version; kBusy: another process has it open for writing; kIo: cannot be read or made. A file that may only
  /// be read is opened so, and every write fails with kRefused.
  static Result<std::unique_ptr<StateStore>> open(const std::string& path, IslandId island, StateOptions options = {});
  ~StateStore();

  /// Row of a device in the file; stays valid until the device is forgotten (then writes answer kNotFound).
  using Row = std::int64_t;

  /// Inserts or replaces what is known of (network, address), except values and first_seen of a known one.
  Result<Row> save(const KnownDevice& device);
  /// Replaces the values of these points; the device's last_heard becomes the latest heard of them.
  Result<void> save_values(Row device, std::span<const StoredValue> values);
  Result<void> forget(const std::string& network, const std::string& address);

  Result<std::optional<KnownDevice>> find(const std::string& network, const std::string& address) const;
  /// The devices of one network (empty = all) in the order in which they were first seen, values included.
  Result<void> each(const std::string& network, const std::function<void(Row, KnownDevice&&)>& visit) const;

  /// All writes between begin and commit are one: all of them survive or none. Without begin each write is its own.
  /// A durable commit is on the disk when it returns; another one may be lost with the power, never with the process.
  Result<void> begin();
  Result<void> commit(bool durable);

  struct Stats {
    std::uint64_t devices = 0, values = 0, bytes = 0, writes = 0, failures = 0, pruned = 0;
    bool read_only = false;
  };
  Stats stats() const;

 private:
  struct Parts;
  explicit StateStore(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace rubicon::state
