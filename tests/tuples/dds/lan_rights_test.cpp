#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/rights.h"
#include "tuples/component.h"
#include "tuples/dds/dds_test_ecology.h"
#include "tuples/dds/rogue.h"
#include "tuples/distant/frame_codec.h"

namespace rubicon::tuples {
namespace {

using support::Right;
using support::rule;
using testing::ElementsAre;

/// An island (1) with rights, and somebody whom it meets by DDS: who says to be island 2 of role admin.
struct RightsOnALan : testing::Test {
  static dds::DdsOptions options() {
    const std::initializer_list<Right> all{Right::kRead, Right::kDemand, Right::kSet};
    dds::DdsOptions options;
    options.judge = std::make_shared<rights::RightsJudge>(
        rights::Rights({rule("lan", all, {"seen"}), rule("everybody", all, {"of.all"}),
                        rule("island:2", all, {"of.island"}), rule("admin", all, {"of.admin"})}));
    return options;
  }
  template <class Done>
  bool until(Done done) {
    for (int i = 0; i < 500 && !done(); ++i) time.run_for(std::chrono::milliseconds(10));
    return done();
  }
  void ask_for(std::string_view key) {
    RemoteSet set;
    set.request = ++request;
    set.key = key;
    set.value = "1";
    distant::FrameWriter frame;
    frame.add(set);
    stranger.frame(2, stranger.incarnation(), 1, island_incarnation, frame.take());
  }

  VirtualScheduler time;
  dds::DdsTestEcology ecology{time, options()};
  Component island{ecology, time, 1};
  std::uint64_t island_incarnation =
      static_cast<std::uint64_t>(VirtualScheduler().wall_now().time_since_epoch().count());
  dds::Rogue stranger{2};
  std::uint64_t request = 0;
};

TEST_F(RightsOnALan, WhoIsMetByDdsIsLanWithoutRoleAndWithoutAnIsland) {
  const auto keys = {"hidden", "of.all", "of.island", "of.admin", "seen"};
  for (const auto* key : keys) ASSERT_TRUE(island.space.set(key, "0")) << key;
  std::vector<std::string> wanted, decided;
  const auto watch = island.space.watch_demand(pattern("**"), [&](const Demand& demand) {
    if (demand.wanted) wanted.emplace_back(demand.key);
  });
  const auto policy = island.space.add_policy(pattern("**"), [&](const RemoteSet& set) {
    decided.emplace_back(set.key);
    return SetDecision::applied();
  });
  ASSERT_TRUE(until([&] { return !island.space.peers().empty(); }));
  distant::FrameWriter content;
  content.add(SubscriptionSpec{1, pattern("**"), {}});
  stranger.interest(1, content.take());
  for (const auto* key : keys) ask_for(key);
  EXPECT_TRUE(until([&] { return !decided.empty() && !wanted.empty(); }));
  EXPECT_THAT(decided, ElementsAre("seen"));
  EXPECT_THAT(wanted, ElementsAre("seen"));
}

/// Such as the page and the history of an island.
TEST_F(RightsOnALan, ComponentsOfTheOwnProcessMayDoEverything) {
  const auto policy = island.space.add_policy(pattern("**"), [](const RemoteSet&) { return SetDecision::applied(); });
  Component page(ecology, time, 70000);
  ASSERT_TRUE(until([&] { return page.space.peers().size() == 2; }));
  std::optional<Verdict> verdict;
  page.space.set_remote(OwnerId(1), "hidden", "1", std::chrono::seconds(60),
                        [&](const Reply& reply) { verdict = reply.verdict; });
  EXPECT_TRUE(until([&] { return verdict.has_value(); }));
  EXPECT_EQ(verdict, Verdict::kApplied);
}

}  // namespace
}  // namespace rubicon::tuples
