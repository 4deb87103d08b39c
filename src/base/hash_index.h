#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/prefetch.h"

namespace rubicon::base {

/// Finds elements of a table of the caller by the hashes of their keys: open addressing, slots of eight bytes. The keys
/// stay in the table, which the caller asks about: most look-ups touch one cache line here.
class HashIndex {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;

  /// The element for which `same(element)` holds; kNone: there is none. Asks only about elements with this hash.
  template <class Same>
  std::uint32_t find(std::uint32_t hash, Same same) const {
    for (auto at = hash & mask();; at = (at + 1) & mask()) {
      const auto& slot = slots_[at];
      if (slot.element == kNone || (slot.hash == hash && same(slot.element))) return slot.element;
    }
  }

  /// The first element with this hash, whatever its key; kNone: there is none.
  std::uint32_t guess(std::uint32_t hash) const {
    return find(hash, [](std::uint32_t) { return true; });
  }

  /// What find() will touch first comes into the cache meanwhile.
  void fetch(std::uint32_t hash) const { prefetch(&slots_[hash & mask()]); }

  /// The element must not be there yet.
  void add(std::uint32_t hash, std::uint32_t element) {
    if ((used_ + 1) * 3 > slots_.size() * 2) grow();  // looks for what is not there end soon
    place({hash, element});
    ++used_;
  }

  /// The element must be there.
  void remove(std::uint32_t hash, std::uint32_t element) {
    auto hole = hash & mask();
    while (slots_[hole].element != element) hole = (hole + 1) & mask();
    // Later slots of the same run move up, unless that would put them before their home.
    for (auto at = (hole + 1) & mask(); slots_[at].element != kNone; at = (at + 1) & mask()) {
      const auto from_home = (at - slots_[at].hash) & mask();
      if (from_home < ((at - hole) & mask())) continue;
      slots_[hole] = slots_[at];
      hole = at;
    }
    slots_[hole] = {};
    --used_;
  }

  std::size_t size() const { return used_; }

 private:
  struct Slot {
    std::uint32_t hash = 0;
    std::uint32_t element = kNone;
  };

  std::size_t mask() const { return slots_.size() - 1; }

  void place(const Slot& slot) {
    auto at = slot.hash & mask();
    while (slots_[at].element != kNone) at = (at + 1) & mask();
    slots_[at] = slot;
  }

  void grow() {
    const auto old = std::exchange(slots_, std::vector<Slot>(slots_.size() * 2));
    for (const auto& slot : old) {
      if (slot.element != kNone) place(slot);
    }
  }

  std::vector<Slot> slots_ = std::vector<Slot>(16);  // a power of two
  std::size_t used_ = 0;
};

}  // namespace rubicon::base
