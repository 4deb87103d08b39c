#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "tuples/tuple_pool.h"

namespace rubicon::tuples {

/// Owner and key -> index of the tuple: an open-addressing table of 8-byte slots. The keys stay in the pool, which
/// outlives it.
class KeyTable {
 public:
  explicit KeyTable(const TuplePool& pool) : pool_(pool), slots_(16) {}

  /// kNone: no such tuple.
  std::uint32_t find(OwnerId owner, std::string_view key) const;
  /// No tuple of that owner and key may be there yet.
  void add(std::uint32_t index);
  /// To be called while the pool has the tuple.
  void remove(std::uint32_t index);

 private:
  struct Slot {
    std::uint32_t hash = 0;
    std::uint32_t index = kNone;
  };
  void place(const Slot& slot);
  void grow();

  const TuplePool& pool_;
  std::vector<Slot> slots_;  // a power of two
  std::size_t used_ = 0;
};

}  // namespace rubicon::tuples
