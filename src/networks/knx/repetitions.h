#pragma once

#include <cstdint>
#include <deque>
#include <utility>

#include "networks/knx/wire/telegram.h"
#include "rubicon/time.hpp"

namespace rubicon::networks::knx {

/// Finds telegrams that the bus repeated: a frame that is marked as repeated and equals another one of the last 200 ms
/// is the same telegram (knx.md, section 8).
class Repetitions {
 public:
  /// Whether this telegram was taken before. If not, it is remembered.
  bool contain(const wire::Telegram& telegram, SteadyTime now);
  std::uint64_t count() const { return count_; }

 private:
  std::deque<std::pair<SteadyTime, wire::Telegram>> recent_;
  std::uint64_t count_ = 0;
};

}  // namespace rubicon::networks::knx
