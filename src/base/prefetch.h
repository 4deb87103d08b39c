#pragma once

namespace rubicon::base {

/// Brings what lies at `place` into the cache while the processor goes on.
inline void prefetch(const void* place) {
  __builtin_prefetch(place);
  asm volatile("");  // GCC leaves out calls of a function that does nothing but this
}

}  // namespace rubicon::base
