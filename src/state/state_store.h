#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "model/message.h"
#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

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
  model::Join join{};  ///< its last announcement
  std::vector<std::pair<model::PointId, std::string>>
      point_ids{};                      ///< the parts of the keys its points have: `light-1`
  WallTime first_seen{}, last_heard{};  ///< zero = never heard
  std::vector<StoredValue> values{};
  std::string given_name{}, area{};  ///< by a user, each at most kMaxGiven bytes; empty = none
};

/// Longest name or area a user may give a device, in bytes.
inline constexpr std::size_t kMaxGiven = 128;

struct StateOptions {
  /// Of the file; before it grows beyond, the devices not heard for longest are forgotten, those without a decision
  /// first. At least 256 KiB is allowed. The write-ahead log beside it takes some MiB more.
  std::uint64_t max_bytes = 256ULL << 20;
};

/// Largest text or JSON of a value that is kept, in bytes: what a message may carry (docs/gateway.cddl).
inline constexpr std::size_t kMaxStoredValue = 65536;

struct StateFile;

/// The one place that remembers across restarts: one SQLite file an island. Everything is written by the calling
/// thread in short transactions; a process that dies at any instant leaves the file as it was after one of them.
/// Commands are never stored.
class StateStore {
 public:
  /// Makes the file if there is none. kInvalid: not a state file, or damaged; kRefused: of another island or
  /// program, or made by a newer version; kBusy: another process has it open for writing; kIo: cannot be read or made.
  /// A file that may only be read is opened so, and every write fails with kRefused.
  static Result<std::unique_ptr<StateStore>> open(const std::string& path, IslandId island, StateOptions options = {});

  enum class Use {
    kWrite,  ///< as open()
    kRead,   ///< also while another process writes; every write fails with kRefused
  };
  /// For tools: opens what there is (else kNotFound), whatever island it is of.
  static Result<std::unique_ptr<StateStore>> open_existing(const std::string& path, Use use, StateOptions options = {});
  ~StateStore();

  IslandId island() const;

  /// Row of a device in the file; stays valid until the device is forgotten (then writes answer kNotFound).
  using Row = std::int64_t;

  /// Inserts or replaces what is known of (network, address), except values and first_seen of a known one (a first_seen
  /// of zero is filled in), a decision by kNone, a given name or area by an empty one, and last_heard by an earlier
  /// one. kOutOfRange: texts or lists beyond the bounds of docs/state.md; kBusy: it does not fit below the bound of the
  /// file, and a transaction goes on without it. Deadlines are kept in milliseconds, rounded up.
  Result<Row> save(const KnownDevice& device);
  /// Replaces the values of these points; the device's last_heard becomes the latest heard of them, if that is later.
  /// kOutOfRange (and nothing is written): a value beyond kMaxStoredValue; kBusy as for save.
  Result<void> save_values(Row device, std::span<const StoredValue> values);
  /// What a user called the device and where it is, empty = nothing any more. kNotFound: no such device; kOutOfRange:
  /// beyond kMaxGiven.
  Result<void> rename(Row device, const std::string& name, const std::string& area);
  /// kNotFound: no such device.
  Result<void> forget(const std::string& network, const std::string& address);

  Result<std::optional<KnownDevice>> find(const std::string& network, const std::string& address) const;
  /// The devices of one network (empty = all) in the order in which they were first saved, values included, those by
  /// kind, type and instance. What cannot be read back is left out and counted. `visit` may call everything but
  /// commit() and rollback(); what it adds is not visited.
  Result<void> each(const std::string& network, const std::function<void(Row, KnownDevice&&)>& visit) const;

  /// All writes between begin and commit are one: all of them survive or none. Without begin each write is its own.
  /// A durable commit is on the disk when it returns; another one may be lost with the power, never with the process.
  /// After a write between them failed with kIo or kInvalid the others fail the same way, and so does commit: nothing
  /// of them survives, and the next begin starts anew.
  Result<void> begin();
  Result<void> commit(bool durable);
  /// Undoes everything since begin.
  void rollback();

  /// For quiet times (once a minute, say): moves the write-ahead log into the file, so that no commit has to. Waits for
  /// the disk as a durable commit does; costs nothing if there is nothing to move.
  Result<void> tidy();

  struct Stats {
    std::uint64_t devices = 0, values = 0;
    std::uint64_t bytes = 0;                 ///< of the file, without its log
    std::uint64_t writes = 0, failures = 0;  ///< calls of save, save_values, forget, commit
    std::uint64_t pruned = 0;                ///< devices forgotten for the bound of the file
    std::uint64_t damaged = 0;               ///< devices and values that each() and find() could not read back
    bool read_only = false;
  };
  Stats stats() const;

 private:
  struct Impl;
  explicit StateStore(std::unique_ptr<Impl> impl);
  static Result<std::unique_ptr<StateStore>> make(Result<StateFile> file, const StateOptions& options);
  std::unique_ptr<Impl> impl_;
};

/// Moves a damaged file and what belongs to it to `<path>.damaged-<UTC time>`; the new name. kIo if that fails.
Result<std::string> set_aside(const std::string& path, WallTime now);

}  // namespace rubicon::state
