#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "model/message.h"
#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::state {

/// The user's decision about a device that announced itself.
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

/// A stored device.
struct KnownDevice {
  std::string network;
  std::string address;
  std::string id;  ///< in keys; empty = it never had one (pending, ignored)
  Decision decision = Decision::kNone;
  model::Join join{};                                               ///< its last announcement
  std::vector<std::pair<model::PointId, std::string>> point_ids{};  ///< the ids of its points in keys: `light-1`
  WallTime first_seen{}, last_heard{};                              ///< zero = never heard
  std::vector<StoredValue> values{};
  std::string given_name{}, area{};  ///< given by a user, each at most kMaxGiven bytes; empty = none
};

/// Longest name or area a user may give a device, in bytes.
inline constexpr std::size_t kMaxGiven = 128;

struct StateOptions {
  /// Largest size of the file, at least 256 KiB. To stay within it the devices that were not heard for longest are
  /// forgotten, first those without a decision. The write-ahead log beside the file takes some MiB more.
  std::uint64_t max_bytes = 256ULL << 20;
};

/// Largest text or JSON of a stored value, in bytes, as in messages (docs/gateway.cddl).
inline constexpr std::size_t kMaxStoredValue = 65536;

struct StateFile;

/// How much a network remembers.
struct MemorySize {
  std::string network;
  std::uint64_t values = 0, bytes = 0;
};

/// Stores what an island remembers across restarts, in one SQLite file. The calling thread writes in short
/// transactions; a process that dies at any instant leaves the file as it was after one of them. Commands are never
/// stored.
class StateStore {
 public:
  /// Creates the file if it does not exist. kInvalid: not a state file, or damaged; kRefused: of another island or
  /// program, or of a newer version; kBusy: another process has it open for writing; kIo: it cannot be read or created.
  /// Without permission to write it is opened for reading, and every write fails with kRefused.
  static Result<std::unique_ptr<StateStore>> open(const std::string& path, IslandId island, StateOptions options = {});

  enum class Use {
    kWrite,  ///< as open()
    kRead,   ///< also while another process writes; every write fails with kRefused
  };
  /// For tools: opens an existing file (else kNotFound) of any island.
  static Result<std::unique_ptr<StateStore>> open_existing(const std::string& path, Use use, StateOptions options = {});
  ~StateStore();

  IslandId island() const;

  /// Row of a device in the file; stays valid until the device is forgotten (then writes answer kNotFound).
  using Row = std::int64_t;

  /// Inserts or replaces the device (network, address). Of a known device these stay: values; first_seen unless it is
  /// zero; a decision that kNone, a given name or area that an empty one, a last_heard that an earlier one would
  /// replace. kOutOfRange: texts or lists beyond the limits of docs/state.md; kBusy: the file is at its limit; the
  /// transaction continues without the device. Deadlines are stored in milliseconds, rounded up.
  Result<Row> save(const KnownDevice& device);
  /// Replaces the values of these points; a later `heard` of them becomes the device's last_heard. kOutOfRange, and
  /// nothing is written: a value beyond kMaxStoredValue; kBusy as for save().
  Result<void> save_values(Row device, std::span<const StoredValue> values);
  /// Sets the name and the area given by a user; empty = none. kNotFound: no such device; kOutOfRange: longer than
  /// kMaxGiven.
  Result<void> rename(Row device, const std::string& name, const std::string& area);
  /// kNotFound: no such device.
  Result<void> forget(const std::string& network, const std::string& address);

  Result<std::optional<KnownDevice>> find(const std::string& network, const std::string& address) const;
  /// Visits the devices of one network (empty = all) with their values, in the order in which they were first saved;
  /// values by kind, type and instance. Devices and values that cannot be read are skipped and counted. `visit` may
  /// call everything but commit() and rollback(); devices that it adds are not visited.
  Result<void> each(const std::string& network, const std::function<void(Row, KnownDevice&&)>& visit) const;

  /// Keeps a value that a network remembers, empty = removes it. A transaction of its own, so not between begin and
  /// commit; `durable` as commit() has it. kBusy: the file is at its limit, or the network has `most` other values.
  Result<void> remember(const std::string& network, std::string_view name, ByteView value, std::size_t most,
                        bool durable = true);
  /// nullopt: there is none.
  Result<std::optional<Bytes>> remembered(const std::string& network, std::string_view name) const;
  /// How much each network remembers.
  Result<std::vector<MemorySize>> memories() const;
  /// Removes all that a network remembers. kNotFound: nothing.
  Result<void> forget_memory(const std::string& network);

  /// All writes between begin and commit are one transaction; without begin each write is one. A durable commit is on
  /// the disk when it returns; others may be lost in a power failure, but not if the process dies. After a write failed
  /// with kIo or kInvalid, the following ones and commit fail too, and nothing is written; the next begin starts a new
  /// transaction.
  Result<void> begin();
  Result<void> commit(bool durable);
  /// Undoes everything since begin.
  void rollback();

  /// Moves the write-ahead log into the file, so that no commit has to; to be called at quiet times, about once a
  /// minute. Waits for the disk like a durable commit; costs nothing if the log is empty.
  Result<void> tidy();

  struct Stats {
    std::uint64_t devices = 0, values = 0;
    std::uint64_t bytes = 0;                 ///< of the file, without its log
    std::uint64_t writes = 0, failures = 0;  ///< calls of save, save_values, forget, commit
    std::uint64_t pruned = 0;                ///< devices forgotten to make room
    std::uint64_t damaged = 0;               ///< devices and values that each() and find() could not read
    bool read_only = false;
  };
  Stats stats() const;

 private:
  struct Impl;
  explicit StateStore(std::unique_ptr<Impl> impl);
  static Result<std::unique_ptr<StateStore>> make(Result<StateFile> file, const StateOptions& options);
  std::unique_ptr<Impl> impl_;
};

/// Renames a damaged file and SQLite's files beside it to `<path>.damaged-<UTC time>`; returns that name. kIo if it
/// fails.
Result<std::string> set_aside(const std::string& path, WallTime now);

}  // namespace rubicon::state
