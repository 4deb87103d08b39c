#include "tuples/key_table.h"

#include <functional>

namespace rubicon::tuples {

namespace {

std::uint32_t hash_of_key(OwnerId owner, std::string_view key) {
  const auto mixed = std::uint64_t{std::hash<std::string_view>()(key)} + number(owner) * 0x9e3779b97f4a7c15u;
  return static_cast<std::uint32_t>(mixed >> 32);
}

}  // namespace

std::uint32_t KeyTable::find(OwnerId owner, std::string_view key) const {
  const auto mask = slots_.size() - 1;
  const auto hash = hash_of_key(owner, key);
  for (auto at = hash & mask;; at = (at + 1) & mask) {
    const auto& slot = slots_[at];
    if (slot.index == kNone) return kNone;
    if (slot.hash != hash) continue;
    const auto& tuple = pool_[slot.index];
    if (tuple.owner == owner && tuple.key() == key) return slot.index;
  }
}

void KeyTable::add(std::uint32_t index) {
  if ((used_ + 1) * 2 > slots_.size()) grow();  // looks for what is not there end soon
  const auto& tuple = pool_[index];
  place({hash_of_key(tuple.owner, tuple.key()), index});
  ++used_;
}

void KeyTable::place(const Slot& slot) {
  const auto mask = slots_.size() - 1;
  auto at = slot.hash & mask;
  while (slots_[at].index != kNone) at = (at + 1) & mask;
  slots_[at] = slot;
}

void KeyTable::remove(std::uint32_t index) {
  const auto mask = slots_.size() - 1;
  const auto& tuple = pool_[index];
  auto hole = hash_of_key(tuple.owner, tuple.key()) & mask;
  while (slots_[hole].index != index) hole = (hole + 1) & mask;
  // Later slots of the same run move up, unless that would put them before their home.
  for (auto at = (hole + 1) & mask; slots_[at].index != kNone; at = (at + 1) & mask) {
    const auto from_home = (at - slots_[at].hash) & mask;
    if (from_home < ((at - hole) & mask)) continue;
    slots_[hole] = slots_[at];
    hole = at;
  }
  slots_[hole] = {};
  --used_;
}

void KeyTable::grow() {
  const auto old = std::exchange(slots_, std::vector<Slot>(slots_.size() * 2));
  for (const auto& slot : old) {
    if (slot.index != kNone) place(slot);
  }
}

}  // namespace rubicon::tuples
