#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

namespace rubicon::tuples::peis {

/// The last ids that came, to drop what comes again. Bounded: the oldest is forgotten first. Ids are below 2^64 - 1.
class SeenIds {
 public:
  explicit SeenIds(std::size_t capacity) : capacity_(capacity) {}

  /// False: it was here.
  bool add(std::uint64_t number) {
    const auto id = number + 1;
    if (2 * (ring_.size() + 1) > slots_.size()) grow();
    auto at = place_of(id);
    if (slots_[at] == id) return false;
    if (ring_.size() < capacity_) {
      ring_.push_back(id);
    } else {
      erase(std::exchange(ring_[oldest_], id));
      oldest_ = (oldest_ + 1) % capacity_;
      at = place_of(id);
    }
    slots_[at] = id;
    return true;
  }
  /// Remembers more from now on, and forgets none.
  void widen(std::size_t capacity) {
    std::rotate(ring_.begin(), ring_.begin() + static_cast<std::ptrdiff_t>(oldest_), ring_.end());
    oldest_ = 0;
    capacity_ = std::max(capacity_, capacity);
  }
  bool contains(std::uint64_t number) const { return !slots_.empty() && slots_[place_of(number + 1)] == number + 1; }
  std::size_t size() const { return ring_.size(); }

 private:
  static constexpr std::size_t kLeast = 64;

  // Below, ids are one more, so that 0 is a free slot.

  std::size_t home_of(std::uint64_t id) const { return (id * 0x9e3779b97f4a7c15U) >> shift_; }
  std::size_t next(std::size_t at) const { return (at + 1) & (slots_.size() - 1); }
  /// Where the id is, or else belongs.
  std::size_t place_of(std::uint64_t id) const {
    auto at = home_of(id);
    while (slots_[at] != 0 && slots_[at] != id) at = next(at);
    return at;
  }
  /// Closes the gap: each id stays reachable from its home.
  void erase(std::uint64_t id) {
    auto gap = place_of(id);
    const auto mask = slots_.size() - 1;
    for (auto at = next(gap); slots_[at] != 0; at = next(at)) {
      if (((at - home_of(slots_[at])) & mask) < ((at - gap) & mask)) continue;
      slots_[gap] = slots_[at];
      gap = at;
    }
    slots_[gap] = 0;
  }
  void grow() {
    slots_.assign(std::max(kLeast, 2 * slots_.size()), 0);
    shift_ = 64 - std::countr_zero(slots_.size());
    for (const auto id : ring_) slots_[place_of(id)] = id;
  }

  std::size_t capacity_;
  std::vector<std::uint64_t> slots_;  ///< a power of two, at most half full; 0 = free
  int shift_ = 0;                     ///< of the hash, to an index of the slots
  std::vector<std::uint64_t> ring_;
  std::size_t oldest_ = 0;
};

}  // namespace rubicon::tuples::peis
