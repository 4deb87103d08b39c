#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/compare_text.h"
#include "base/hash_index.h"
#include "networks/log/recorded_device.h"
#include "networks/log/recording.h"
#include "recording/file_format.h"
#include "recording/record.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::log {

/// The names of the networks in a recording; at most 1000.
class RecordedNetworks {
 public:
  /// Takes the parts of a key after the prefix, `wsn-1.7.sensor.light-1.value`. True: they name a new network.
  bool note(const std::vector<std::string_view>& parts);
  std::size_t size() const { return names_.size(); }
  /// The error that one of them must be chosen, with all names.
  Error ambiguous() const;

 private:
  std::set<std::string, std::less<>> names_;
};

/// The keys of a recording: which device and which of its tuples each one names. Owns the devices, which never move.
/// Bounded, whatever the recording holds. What the constructor takes by reference must outlive it.
class RecordedKeys {
 public:
  static constexpr std::size_t kMaxDevices = 20'000;
  static constexpr std::size_t kMaxPoints = 2048;  ///< of one device
  static constexpr std::size_t kMaxKeys = 500'000;
  static constexpr std::size_t kMaxText = 64 << 20;  ///< bytes of all keys

  /// `network`: the one to be played; empty = the only one there is.
  RecordedKeys(std::string network, ForeignTypes& types, WorkBudget& budget, RecordingFaults& faults);

  enum class Role : std::uint8_t { kUnresolved, kIgnored, kDevice, kPoint, kValue, kStatus };
  /// What a key names: of kDevice the description of a device, of kPoint that of a point.
  struct Target {
    Role role = Role::kUnresolved;
    RecordedDevice* device = nullptr;
    RecordedPoint* point = nullptr;
  };
  Target target_of(const recording::Record& record);
  /// target_of() these records comes next: what it and its callers touch comes into the cache meanwhile.
  void fetch(std::span<const recording::Record> next);

  /// The key numbers of records begin again.
  void begin_block() { by_number_.clear(); }
  /// Takes prefix and island; false if the island is not that of the files before.
  bool read_head(const recording::FileHead& head);
  OwnerId island() const { return island_; }

  /// The configuration names the network.
  bool chosen_by_user() const { return chosen_by_user_; }
  /// There are several networks, and none is chosen.
  bool ambiguous() const { return !chosen_by_user_ && networks_.size() > 1; }
  /// Only takes the network's name from the key.
  void note_network(const recording::Record& record);
  const RecordedNetworks& networks() const { return networks_; }

  const base::ByText<std::unique_ptr<RecordedDevice>>& devices() const { return devices_; }

 private:
  /// A key of any block.
  struct alignas(64) Key {
    std::string text;
    Target target;
  };
  /// A key of the present block.
  struct Numbered {
    Target target;
    std::uint32_t hash = 0;  ///< of its text, once it was needed; 0 = not yet
  };
  Numbered& numbered(const recording::Record& record);
  const Key* known(const Numbered& numbered, std::string_view text) const;
  bool is_of_island(const recording::Record& record) const;
  Target add_key(std::string_view key, std::uint32_t hash);
  Target resolve(std::string_view key);
  RecordedDevice* find_or_add_device(std::string_view id);
  RecordedPoint* find_or_add_point(RecordedDevice& device, std::string_view kind, std::string_view id);

  std::string network_;
  const bool chosen_by_user_;
  ForeignTypes& types_;
  WorkBudget& budget_;
  RecordingFaults& faults_;
  std::string prefix_ = "proxy.";
  OwnerId island_ = model::kNoOwner;
  RecordedNetworks networks_;
  base::ByText<std::unique_ptr<RecordedDevice>> devices_;
  std::vector<Key> keys_;
  base::HashIndex by_text_;          ///< places in keys_
  std::size_t text_ = 0;             ///< bytes in keys_
  std::vector<Numbered> by_number_;  ///< of the present block
};

}  // namespace rubicon::networks::log
