#pragma once

#include <cstdint>
#include <list>
#include <unordered_map>
#include <vector>

#include "rubicon/address.hpp"

namespace rubicon::gateway {

/// Remembers which messages were accepted, so that duplicates that arrive on several ways are ignored. A number counts
/// for one destination only: an island that may relay to some places must not use up the numbers of an origin for all
/// others. Bounded: the last 4096 numbers of the 1024 latest origins.
class SeenMessages {
 public:
  static constexpr std::size_t kNumbers = 4096;
  static constexpr std::size_t kOrigins = 1024;

  SeenMessages();

  bool seen(const Address& to, IslandId origin, std::uint64_t number) const;
  void note(const Address& to, IslandId origin, std::uint64_t number);

 private:
  struct Seen {
    std::uint64_t number = 0, place = 0;
    friend bool operator==(const Seen&, const Seen&) = default;
  };
  struct Window {
    std::uint64_t highest = 0;
    std::vector<Seen> numbers;  ///< a ring once it is full
    std::size_t next = 0;
    std::list<IslandId>::iterator age;
  };
  Window& window(IslandId origin);
  std::uint64_t place_of(const Address& to) const;

  std::uint64_t secret_;  ///< a stranger who does not know it cannot choose two destinations with the same place_of()
  std::unordered_map<IslandId, Window> windows_;
  std::list<IslandId> by_age_;  ///< latest first
};

}  // namespace rubicon::gateway
