#pragma once

#include <map>
#include <string>

#include "base/time.h"
#include "networks/knx/wire/telegram.h"

namespace rubicon::networks::knx {

/// What is heard on group addresses that nobody configured: bounded, never a device by itself (knx.md, section 8).
class Unassigned {
 public:
  static constexpr std::size_t kMost = 256;

  void heard(const Telegram& telegram, WallTime now);
  /// A newly configured address is unassigned no more.
  void forget(GroupAddress address) { entries_.erase(address); }
  std::size_t size() const { return entries_.size(); }
  std::uint64_t dropped() const { return dropped_; }
  /// `{"1/2/7": {"count": 3, "last": "0c33", "source": "1.1.5", "time": 1795276800.5}}`
  std::string json() const;

 private:
  struct Entry {
    std::uint64_t count = 0;
    Payload last;
    IndividualAddress source{};
    WallTime time{};
  };
  std::map<GroupAddress, Entry> entries_;
  std::uint64_t dropped_ = 0;  ///< telegrams of addresses for which there was no room
};

}  // namespace rubicon::networks::knx
