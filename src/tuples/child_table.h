#pragma once

#include <cstdint>
#include <vector>

namespace rubicon::tuples {

/// (node, part) -> child node, for all nodes of a trie: one open-addressing table of 12-byte slots.
class ChildTable {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;

  ChildTable() : slots_(16) {}

  std::uint32_t find(std::uint32_t node, std::uint32_t part) const;
  /// The pair must not be there yet.
  void add(std::uint32_t node, std::uint32_t part, std::uint32_t child);
  void remove(std::uint32_t node, std::uint32_t part);

 private:
  struct Slot {
    std::uint32_t node = 0;
    std::uint32_t part = 0;
    std::uint32_t child = kNone;
  };
  std::size_t home(std::uint32_t node, std::uint32_t part) const;
  void place(const Slot& slot);
  void grow();

  std::vector<Slot> slots_;  // a power of two
  std::size_t used_ = 0;
};

}  // namespace rubicon::tuples
