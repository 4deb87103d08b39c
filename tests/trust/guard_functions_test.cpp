#include "trust/guard_functions.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace rubicon::trust {
namespace {

/// The guard that this test speaks for refuses a peer.
void refuse(const char* name, bool is_verified, const char* reason) {
  void* library = ::dlopen(RUBICON_FAKE_GUARD, RTLD_NOW);
  ASSERT_NE(library, nullptr) << ::dlerror();
  const auto tell = reinterpret_cast<void (*)(const char*, int, const char*)>(::dlsym(library, "fake_guard_refuse"));
  ASSERT_NE(tell, nullptr);
  tell(name, is_verified ? 1 : 0, reason);
}

TEST(GuardFunctions, SayWhoWasRefusedAndWhoOnlyClaimsAName) {
  GuardFunctions guard;
  ASSERT_TRUE(guard.load(RUBICON_FAKE_GUARD));
  std::vector<std::string> refused;
  guard.watch([&](const tuples::dds::DdsTrust::Refusal& refusal) {
    EXPECT_EQ(refusal.peer, tuples::dds::GuidPrefix{1});
    refused.push_back(std::string(refusal.name) + (refusal.is_verified ? ": " : "? ") + std::string(refusal.reason));
  });
  refuse("desk", true, "it lies");
  refuse("roof", false, "it is a stranger");
  guard.watch({});
  refuse("roof", false, "it comes too late");
  EXPECT_EQ(refused, (std::vector<std::string>{"desk: it lies", "roof? it is a stranger"}));
}

}  // namespace
}  // namespace rubicon::trust
