#include "trust/guard_functions.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace rubicon::trust {
namespace {

/// A function of the guard that this test speaks for.
template <class Function>
Function* of_guard(const char* name) {
  void* library = ::dlopen(RUBICON_FAKE_GUARD, RTLD_NOW);
  return library == nullptr ? nullptr : reinterpret_cast<Function*>(::dlsym(library, name));
}

/// It refuses a peer.
void refuse(const char* name, bool is_verified, const char* reason) {
  auto* tell = of_guard<void(const char*, int, const char*)>("fake_guard_refuse");
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

TEST(GuardFunctions, EndOnlyTheirOwnWatch) {
  GuardFunctions newer;
  std::vector<std::string> refused;
  {
    GuardFunctions older;
    ASSERT_TRUE(older.load(RUBICON_FAKE_GUARD) && newer.load(RUBICON_FAKE_GUARD));
    older.watch([](const auto&) { ADD_FAILURE() << "it was replaced"; });
    newer.watch([&](const auto& refusal) { refused.emplace_back(refusal.name); });
    refuse("desk", true, "it lies");
  }
  refuse("roof", true, "it lies");
  EXPECT_EQ(refused, (std::vector<std::string>{"desk", "roof"}));
}

TEST(GuardFunctions, AreNotUsedOfAnotherVersion) {
  auto* set_version = of_guard<void(int)>("fake_guard_set_version");
  ASSERT_NE(set_version, nullptr);
  for (const int version : {0, RUBICON_GUARD_VERSION + 1}) {
    set_version(version);
    GuardFunctions guard;
    const auto loaded = guard.load(RUBICON_FAKE_GUARD);
    set_version(RUBICON_GUARD_VERSION);
    ASSERT_FALSE(loaded);
    EXPECT_EQ(loaded.error().code, ErrorCode::kUnsupported);
    EXPECT_EQ(loaded.error().text,
              fmt::format("{}: is of another version of Rubicon (guard {}, expected {}): install packages of the same "
                          "version",
                          RUBICON_FAKE_GUARD, version, RUBICON_GUARD_VERSION));
    EXPECT_FALSE(guard.loaded());
    EXPECT_TRUE(guard.load(RUBICON_FAKE_GUARD));
  }
}

TEST(GuardFunctions, AreNotUsedOfAGuardBeforeThereWereVersions) {
  GuardFunctions guard;
  const auto loaded = guard.load(RUBICON_FIRST_GUARD);
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(loaded.error().text,
            fmt::format("{}: is of another version of Rubicon (guard 0, expected {}): install packages of the same "
                        "version",
                        RUBICON_FIRST_GUARD, RUBICON_GUARD_VERSION));
}

}  // namespace
}  // namespace rubicon::trust
