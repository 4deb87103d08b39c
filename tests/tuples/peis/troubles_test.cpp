#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "rubicon/summary.hpp"
#include "tuples/peis/link_to_a_kernel.h"
#include "tuples/peis/session.h"
#include "tuples/peis/troubles.h"

namespace rubicon::tuples::peis {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

TEST(Troubles, AreCountedByKindIdAndNameAndBounded) {
  Troubles troubles;
  troubles.note(TroubleKind::kForeignNetwork, OwnerId{7}, "a@x!1", "lab");
  troubles.note(TroubleKind::kForeignNetwork, OwnerId{7}, "a@x!1", "office");
  ASSERT_THAT(troubles.all(), SizeIs(1));
  EXPECT_EQ(troubles.all()[0], (Trouble{TroubleKind::kForeignNetwork, OwnerId{7}, "a@x!1", "office", 2}));
  for (std::uint32_t id = 1; id <= 2 * Troubles::kMax; ++id)
    troubles.note(TroubleKind::kUnreachable, OwnerId{id}, std::string(1000, 'x'), std::string(1000, 'y'));
  ASSERT_THAT(troubles.all(), SizeIs(Troubles::kMax));
  EXPECT_EQ(troubles.all().back().id, OwnerId{2 * Troubles::kMax}) << "the last ones stay";
  EXPECT_LT(troubles.all().back().detail.size(), 300U);
}

TEST(Troubles, WhatIsReachedIsNoLongerUnreachable) {
  Troubles troubles;
  troubles.note(TroubleKind::kUnreachable, OwnerId{7}, "a@x!1", "refused");
  troubles.note(TroubleKind::kUnreachable, OwnerId{}, "desk:8000", "refused");
  troubles.note(TroubleKind::kSharedId, OwnerId{7}, "a@x!1", "twice");
  troubles.reached(OwnerId{8}, "desk:8000");
  ASSERT_THAT(troubles.all(), SizeIs(2));
  troubles.reached(OwnerId{7}, "");
  ASSERT_THAT(troubles.all(), SizeIs(1));
  EXPECT_EQ(troubles.all()[0].kind, TroubleKind::kSharedId);
}

/// All members of both are counters of 64 bits.
TEST(Metrics, NameEachCounterOnce) {
  std::set<std::string> names;
  const auto keep = [&names](std::string_view name, std::uint64_t) { names.emplace(name); };
  each_counter(NodeCounters(), keep);
  each_counter(SessionCounters(), keep);
  EXPECT_THAT(names, SizeIs((sizeof(NodeCounters) + sizeof(SessionCounters)) / sizeof(std::uint64_t)));
  EXPECT_TRUE(names.contains("refused-keys"));
}

TEST_F(LinkToAKernel, TheNameAndHostThatItAnnouncesAreItsSummary) {
  const auto summary = model::summary_from_json(space->summary(kKernel)).value_or(Summary{});
  EXPECT_EQ(summary.name, "kernel");
  EXPECT_EQ(summary.host, "hostx");
  EXPECT_EQ(summary.program, "peis-kernel 500");
  EXPECT_FALSE(model::is_island(kKernel, summary)) << "its id is one of islands";
}

TEST_F(LinkToAKernel, ItsCountersHaveTheNameOfTheEngine) {
  set_remote("kernel.do-quit", c_string("yes"));
  world.run(1s);
  std::vector<std::string> counted;
  link->each_counter([&](std::string_view name, std::uint64_t value) {
    if (name == "peis-ignored-quits") counted.push_back(std::to_string(value));
  });
  EXPECT_THAT(counted, ElementsAre("1"));
}

TEST_F(LinkToAKernel, AConfiguredComponentThatRefusesIsATroubleUntilItIsReached) {
  kernel.stop_listening();
  kernel.close();
  world.run(5s);
  const auto& troubles = link->presence()->node()->troubles();
  ASSERT_FALSE(troubles.empty());
  EXPECT_EQ(troubles.back().kind, TroubleKind::kUnreachable);
  kernel.listen();
  world.run(30s);
  EXPECT_THAT(link->presence()->node()->troubles(), SizeIs(0));
}

}  // namespace
}  // namespace rubicon::tuples::peis
