#include "tuples/tuple_pool.h"

#include <algorithm>
#include <cstring>

#include "base/assert.h"

namespace rubicon::tuples {

static_assert(model::kMaxKeyLength <= 255, "Tuple::key_size is one byte");

std::uint16_t MediaTypes::intern(std::string_view name) {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found != names_.end()) return static_cast<std::uint16_t>(found - names_.begin());
  if (names_.size() >= kMaxTypes || name.size() > kMaxLength) return 0;
  names_.emplace_back(name);
  return static_cast<std::uint16_t>(names_.size() - 1);
}

std::uint32_t TuplePool::take(OwnerId owner, std::string_view key) {
  const auto index = free_.empty() ? tuples_.add() : free_.back();
  if (!free_.empty()) free_.pop_back();
  auto& tuple = (*this)[index];
  tuple.key_text = std::make_unique_for_overwrite<char[]>(key.size());
  std::memcpy(tuple.key_text.get(), key.data(), key.size());
  tuple.key_size = static_cast<std::uint8_t>(key.size());
  tuple.owner = owner;
  tuple.generation = ++generation_;
  tuple.present = true;
  return index;
}

void TuplePool::end(std::uint32_t index, EventKind how) {
  auto& tuple = (*this)[index];
  tuple.present = false;
  tuple.end = how;
  if (tuple.pins == 0) release(index);
}

void TuplePool::unpin(std::uint32_t index) {
  auto& tuple = (*this)[index];
  RUBICON_DEBUG_ASSERT(tuple.pins > 0);
  if (--tuple.pins == 0 && !tuple.present) release(index);
}

void TuplePool::release(std::uint32_t index) {
  auto& tuple = (*this)[index];
  const auto generation = tuple.generation;
  tuple = Tuple{};
  tuple.generation = generation;
  free_.push_back(index);
}

}  // namespace rubicon::tuples
