#include "tuples/child_table.h"

namespace rubicon::tuples {

std::size_t ChildTable::home(std::uint32_t node, std::uint32_t part) const {
  std::uint64_t mixed = (std::uint64_t{node} << 32) | part;
  mixed = (mixed ^ (mixed >> 31)) * 0x9e3779b97f4a7c15u;
  mixed ^= mixed >> 32;
  return static_cast<std::size_t>(mixed) & (slots_.size() - 1);
}

std::uint32_t ChildTable::find(std::uint32_t node, std::uint32_t part) const {
  for (auto at = home(node, part);; at = (at + 1) & (slots_.size() - 1)) {
    const auto& slot = slots_[at];
    if (slot.child == kNone || (slot.node == node && slot.part == part)) return slot.child;
  }
}

void ChildTable::add(std::uint32_t node, std::uint32_t part, std::uint32_t child) {
  if ((used_ + 1) * 4 > slots_.size() * 3) grow();
  place({node, part, child});
  ++used_;
}

void ChildTable::place(const Slot& slot) {
  auto at = home(slot.node, slot.part);
  while (slots_[at].child != kNone) at = (at + 1) & (slots_.size() - 1);
  slots_[at] = slot;
}

void ChildTable::remove(std::uint32_t node, std::uint32_t part) {
  const auto mask = slots_.size() - 1;
  auto hole = home(node, part);
  while (slots_[hole].child != kNone && (slots_[hole].node != node || slots_[hole].part != part))
    hole = (hole + 1) & mask;
  if (slots_[hole].child == kNone) return;
  // Later slots of the same run move up, unless that would put them before their home.
  for (auto at = (hole + 1) & mask; slots_[at].child != kNone; at = (at + 1) & mask) {
    const auto from_home = (at - home(slots_[at].node, slots_[at].part)) & mask;
    if (from_home < ((at - hole) & mask)) continue;
    slots_[hole] = slots_[at];
    hole = at;
  }
  slots_[hole] = {};
  --used_;
}

void ChildTable::grow() {
  auto old = std::move(slots_);
  slots_ = std::vector<Slot>(old.size() * 2);
  for (const auto& slot : old) {
    if (slot.child != kNone) place(slot);
  }
}

}  // namespace rubicon::tuples
