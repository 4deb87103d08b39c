#pragma once

#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <utility>

#include "base/scheduler.h"
#include "rubicon/tuple_space.hpp"

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

/// Gives memory back from time to time, and soon after many components left: DDS frees what it kept of them in places
/// all over the heap. Only for who owns the heap, a program.
class SpareMemory {
 public:
  static constexpr int kMany = 50;
  static constexpr base::Duration kPause = std::chrono::seconds(10);
  static constexpr base::Duration kPeriod = std::chrono::minutes(1);

  SpareMemory(base::Scheduler& scheduler, tuples::TupleSpace& space, std::function<void()> give = give_back_memory)
      : scheduler_(scheduler), give_(std::move(give)) {
    watch_ = space.watch_peers([this](OwnerId, tuples::PeerEvent event) {
      if (event != tuples::PeerEvent::kUp && ++left_ == kMany) give_at(std::max(scheduler_.now(), not_before_));
    });
    give_at(scheduler_.now() + kPeriod);
  }

 private:
  /// In a turn of its own, and not often: it holds the loop up for some milliseconds.
  void give_at(base::SteadyTime time) {
    timer_ = scheduler_.at(time, [this] {
      left_ = 0;
      not_before_ = scheduler_.now() + kPause;
      give_();
      give_at(scheduler_.now() + kPeriod);
    });
  }

  base::Scheduler& scheduler_;
  std::function<void()> give_;
  int left_ = 0;
  base::SteadyTime not_before_{};
  base::Timer timer_;
  tuples::Handle watch_;
};

}  // namespace rubicon::island
