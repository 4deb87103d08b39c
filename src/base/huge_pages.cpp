#include "base/huge_pages.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdlib>
#include <new>

namespace rubicon::base {

namespace {

/// Of x86-64, and of ARM with pages of 4 KiB.
constexpr std::size_t kHugePage = std::size_t{2} << 20;

class HugePages final : public std::pmr::memory_resource {
  void* do_allocate(std::size_t bytes, std::size_t alignment) override {
    const bool huge = bytes >= kHugePage;
    if (huge) alignment = kHugePage;
    auto* block = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
    if (!block) throw std::bad_alloc();
    if (huge) ::madvise(block, bytes, MADV_HUGEPAGE);  // the wish of a system that has none is no error
    return block;
  }
  void do_deallocate(void* block, std::size_t, std::size_t) override { std::free(block); }
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override { return this == &other; }
};

}  // namespace

std::pmr::memory_resource* huge_pages() {
  static HugePages one;
  return &one;
}

}  // namespace rubicon::base
