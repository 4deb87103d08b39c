#pragma once

#include <cstdint>
#include <list>
#include <unordered_map>
#include <vector>

#include "rubicon/address.hpp"

namespace rubicon::gateway {

/// Remembers which messages were accepted, so that duplicates that arrive on several ways are ignored. Bounded: the
/// last 4096 numbers of the 1024 latest origins.
class SeenMessages {
 public:
  static constexpr std::size_t kNumbers = 4096;
  static constexpr std::size_t kOrigins = 1024;

  bool seen(IslandId origin, std::uint64_t number) const;
  void note(IslandId origin, std::uint64_t number);

 private:
  struct Window {
    std::uint64_t highest = 0;
    std::vector<std::uint64_t> numbers;  ///< a ring once it is full
    std::size_t next = 0;
    std::list<IslandId>::iterator age;
  };
  Window& window(IslandId origin);

  std::unordered_map<IslandId, Window> windows_;
  std::list<IslandId> by_age_;  ///< latest first
};

}  // namespace rubicon::gateway
