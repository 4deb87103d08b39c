#pragma once

#include <map>
#include <string>

#include "networks/knx/wire/telegram.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::knx {

/// What is heard on group addresses that nobody configured: bounded, never a device by itself (knx.md, section 8).
class Unassigned {
 public:
  static constexpr std::size_t kMost = 256;    ///< addresses; the one silent for longest makes room
  static constexpr std::size_t kLongest = 32;  ///< bytes shown of a value

  void heard(const wire::Telegram& telegram, WallTime now);
  /// Newly configured addresses are unassigned no more.
  template <class Known>
  void forget(Known known) {
    std::erase_if(entries_, [&](const auto& one) { return known(one.first); });
  }
  std::size_t size() const { return entries_.size(); }
  std::uint64_t dropped() const { return dropped_; }
  /// `{"1/2/7": {"count": 3, "last": "0c33", "source": "1.1.5", "time": 1795276800.5}}`
  std::string json() const;

 private:
  struct Entry {
    std::uint64_t count = 0;
    std::string last;  ///< hex, of the first bytes
    wire::IndividualAddress source{};
    WallTime time{};
  };
  std::map<wire::GroupAddress, Entry> entries_;
  std::uint64_t dropped_ = 0;  ///< addresses that made room
};

}  // namespace rubicon::networks::knx
