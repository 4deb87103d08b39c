#pragma once

#include <map>
#include <string>

#include "networks/knx/wire/telegram.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::knx {

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
