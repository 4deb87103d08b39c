#pragma once

#include <cstdint>
#include <deque>
#include <unordered_map>
#include <unordered_set>

#include "model/address.h"

namespace rubicon::gateway {

/// Remembers which messages of which island passed, so that each is delivered once however many ways lead here.
/// Bounded: the last 4096 of each of the last 1024 origins.
class SeenMessages {
 public:
  /// True the first time.
  bool first(IslandId origin, std::uint64_t number);

 private:
  struct Window {
    std::unordered_set<std::uint64_t> numbers;
    std::deque<std::uint64_t> order;
  };
  std::unordered_map<IslandId, Window> windows_;
  std::deque<IslandId> origins_;
};

}  // namespace rubicon::gateway
