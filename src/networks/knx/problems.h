#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "networks/knx/wire/address.h"
#include "networks/knx/wire/cemi.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::knx {

/// Telegrams and values of a group address that were dropped, refused or cannot be used.
struct Problem {
  std::string_view what;  ///< of kProblemKinds
  wire::GroupAddress address{};
  std::string reason;  ///< for the user
};

/// Kinds of problems: values from the bus that do not fit their type, reads without an answer, exposed tuples without a
/// value, and their values that cannot be written.
inline constexpr std::string_view kBadValue = "value", kUnanswered = "read", kNoSource = "source",
                                  kRefusedExposure = "exposure";

/// The problems of a network, each with its last reason: one entry for each kind and address.
class Problems {
 public:
  static constexpr std::size_t kMaxCount =
      256;  ///< beyond it the one that did not happen for the longest time is dropped

  void add(const Problem& problem, WallTime now);
  /// It is over: only for what is a state, not an event.
  void end(std::string_view what, wire::GroupAddress address);
  /// Removes the problems of addresses for which `known(address)` is false.
  template <class Known>
  void keep(Known known) {
    std::erase_if(entries_, [&](const auto& entry) { return !known(entry.first.first); });
  }
  /// `[{"address": "6/0/2", "what": "exposure", "count": 3, "reason": "...", "time": 1795276800.5}]`, by address.
  std::string json(wire::Notation notation = wire::Notation::kThreeLevel) const;

 private:
  struct Entry {
    std::uint64_t count = 0;
    std::string reason;
    WallTime time{};
  };
  std::map<std::pair<wire::GroupAddress, std::string_view>, Entry> entries_;
};

/// Telegrams to group addresses that are not configured; they never become devices (knx.md, section 8).
class UnassignedAddresses {
 public:
  static constexpr std::size_t kMaxAddresses = 256;  ///< beyond it the address that was silent longest is dropped
  static constexpr std::size_t kMaxValueBytes = 32;  ///< shown of a value

  void add(const wire::Telegram& telegram, WallTime now);
  /// Removes the addresses for which `assigned(address)` is true.
  template <class Assigned>
  void remove_if(Assigned assigned) {
    std::erase_if(entries_, [&](const auto& entry) { return assigned(entry.first); });
  }
  std::size_t size() const { return entries_.size(); }
  /// Addresses that were dropped because of kMaxAddresses.
  std::uint64_t dropped() const { return dropped_; }
  /// `{"1/2/7": {"count": 3, "last": "0c33", "source": "1.1.5", "time": 1795276800.5}}`
  std::string json(wire::Notation notation = wire::Notation::kThreeLevel) const;

 private:
  struct Entry {
    std::uint64_t count = 0;
    std::string last;  ///< value in hex, cut to kMaxValueBytes
    wire::IndividualAddress source{};
    WallTime time{};
  };
  std::map<wire::GroupAddress, Entry> entries_;
  std::uint64_t dropped_ = 0;
};

}  // namespace rubicon::networks::knx
