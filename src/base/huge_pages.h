#pragma once

#include <cstddef>
#include <memory_resource>

namespace rubicon::base {

/// Memory from malloc; blocks of 2 MiB and more may lie in pages of that size (madvise(2), MADV_HUGEPAGE). Things that
/// are visited in any order, by the ten thousand, otherwise wait longer for their addresses than for themselves. For
/// all threads.
std::pmr::memory_resource* huge_pages();

/// Memory for many things of few sizes, close together. What is given back is for later ones of about its size; more
/// than kLargest bytes are not for here. For one thread.
class DenseMemory {
 public:
  static constexpr std::size_t kLargest = std::size_t{256} << 10;

  std::pmr::memory_resource* get() { return &pool_; }

 private:
  /// Is not touched before it is used: a small process does not pay for it.
  static constexpr std::size_t kFirst = std::size_t{1} << 20;

  std::pmr::monotonic_buffer_resource blocks_{kFirst, huge_pages()};
  std::pmr::unsynchronized_pool_resource pool_{{0, kLargest}, &blocks_};
};

}  // namespace rubicon::base
