#pragma once

#include <ctime>

#include "rubicon/time.hpp"

namespace rubicon::base {

/// Since the start of the kernel, also while it slept: the same for all processes of a host (CLOCK_BOOTTIME,
/// clock_gettime(2)).
inline Duration since_boot() {
  timespec now{};
  ::clock_gettime(CLOCK_BOOTTIME, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

}  // namespace rubicon::base
