#include "trust/guard/watcher.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include "trust/guard/guard.h"

namespace rubicon::trust::guard {
namespace {

void count(void* context, const std::uint8_t*, const char*, int, const char*) {
  ++*static_cast<int*>(context);
}

TEST(Watcher, IsEndedByItsOwnContextOnly) {
  int older = 0, newer = 0;
  watch(count, &older);
  watch(count, &newer);
  report({}, "it lies");
  watch(nullptr, &older);
  report({}, "it lies");
  EXPECT_EQ(older, 0);
  EXPECT_EQ(newer, 2);
  watch(nullptr, &newer);
  report({}, "it lies");
  EXPECT_EQ(newer, 2);
}

TEST(Guard, SaysItsVersion) {
  void* library = ::dlopen(RUBICON_GUARD, RTLD_NOW);
  ASSERT_NE(library, nullptr) << ::dlerror();
  const auto version = reinterpret_cast<decltype(&rubicon_guard_version)>(::dlsym(library, "rubicon_guard_version"));
  ASSERT_NE(version, nullptr);
  EXPECT_EQ(version(), RUBICON_GUARD_VERSION);
}

}  // namespace
}  // namespace rubicon::trust::guard
