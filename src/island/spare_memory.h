#pragma once

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <limits>
#include <utility>

#include "base/scheduler.h"

namespace rubicon::island {

/// A vector that grew and went gives its memory back at once. Left to itself, malloc keeps blocks as large as the
/// largest that was ever freed: those of a start with 60,000 points stay for good. Threads of brokers and
/// DDS share two heaps with the loop, which frees what they allocate: one heap for each thread would fragment.
inline void keep_heap_small() {
#ifdef __GLIBC__
  ::mallopt(M_MMAP_THRESHOLD, 1 << 20);
  ::mallopt(M_ARENA_MAX, 2);
#endif
}

/// What was freed lies between what stays; the system gets it back only when asked.
inline void give_back_memory() {
#ifdef __GLIBC__
  ::malloc_trim(0);
#endif
}

/// Bytes of this process that are in memory and come from no file (proc(5), statm); 0 = not known.
inline std::size_t resident_memory() {
  std::size_t size = 0, resident = 0, shared = 0;
  std::ifstream("/proc/self/statm") >> size >> resident >> shared;
  return (resident - std::min(shared, resident)) * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

/// Gives memory back after it grew: a tool that reads everything, components that came and left, a broker that was
/// away. What was still in use then goes once a minute. Looks now and then only, because giving back holds the loop up
/// for some milliseconds. Only for who owns the heap, a program.
class SpareMemory {
 public:
  static constexpr base::Duration kPeriod = std::chrono::seconds(10);
  /// Growth that counts: so many bytes, and that part of what was there.
  static constexpr std::size_t kWorthIt = 2 << 20, kPart = 16;
  static constexpr int kLooks = 6;  ///< until it is given back although it did not grow

  explicit SpareMemory(base::Scheduler& scheduler, std::function<void()> give = give_back_memory,
                       std::function<std::size_t()> resident = resident_memory)
      : scheduler_(scheduler), give_(std::move(give)), resident_(std::move(resident)) {
    look_later();
  }

 private:
  void look_later() {
    timer_ = scheduler_.after(kPeriod, [this] {
      look();
      look_later();
    });
  }

  void look() {
    const auto now = resident_();
    least_ = std::min(least_, now);
    const bool grew = now - least_ > std::max(kWorthIt, least_ / kPart);
    if (!grew && ++looks_ < kLooks) return;
    give_();
    looks_ = 0;
    least_ = resident_();
  }

  base::Scheduler& scheduler_;
  std::function<void()> give_;
  std::function<std::size_t()> resident_;
  std::size_t least_ = std::numeric_limits<std::size_t>::max();  ///< since it was given back
  int looks_ = 0;
  base::Timer timer_;
};

}  // namespace rubicon::island
