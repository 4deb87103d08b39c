#pragma once

namespace rubicon::base {

/// Prints the condition and its place, then aborts: errors of this program itself end here, in every build.
[[noreturn]] void assertion_failed(const char* condition, const char* file, int line);

}  // namespace rubicon::base

#define RUBICON_ASSERT(condition) \
  ((condition) ? static_cast<void>(0) : ::rubicon::base::assertion_failed(#condition, __FILE__, __LINE__))

#ifdef NDEBUG
#define RUBICON_DEBUG_ASSERT(condition) static_cast<void>(0)
#else
#define RUBICON_DEBUG_ASSERT(condition) RUBICON_ASSERT(condition)
#endif
