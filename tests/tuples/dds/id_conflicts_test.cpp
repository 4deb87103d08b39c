#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tuples/component.h"
#include "tuples/dds/dds_test_ecology.h"
#include "tuples/dds/id_conflicts.h"
#include "tuples/dds/rogue.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Several with the id of the island (1). The lease is 2 s.
struct IdConflicts : testing::Test {
  /// Each step waits a little for DDS.
  void pass(Duration time_to_pass) {
    for (auto left = time_to_pass; left > 0ms; left -= 100ms) time.run_for(100ms);
  }
  static std::uint64_t micros(WallTime when) { return static_cast<std::uint64_t>(when.time_since_epoch().count()); }
  std::size_t warnings(std::string_view part) const {
    const auto& lines = ecology.log().lines;
    return static_cast<std::size_t>(
        std::count_if(lines.begin(), lines.end(), [&](const auto& line) { return line.find(part) != line.npos; }));
  }

  VirtualScheduler time;
  dds::DdsTestEcology ecology{time};
  const std::uint64_t start = micros(time.wall_now());
  std::unique_ptr<Component> island = std::make_unique<Component>(ecology, time, 1);
};

TEST_F(IdConflicts, OnePresenceSampleEndsNobody) {
  dds::Rogue rogue(66666);
  rogue.show(1, 1);
  rogue.show(1, start - 1'000'000);
  pass(10s);
  EXPECT_THAT(ecology.displaced, IsEmpty());
  EXPECT_EQ(warnings("component 1 says that it started on 1970-01-01 00:00 UTC, before the clock of its host was set"),
            1U);
  EXPECT_EQ(warnings("another presence of component 1, started at 2025-12-31T23:59:59Z, does not answer"), 1U);
  Component robot(ecology, time, 70000);
  pass(1s);
  EXPECT_THAT(robot.space.peers(), Contains(OwnerId(1))) << "who looks later sees it too";
}

TEST_F(IdConflicts, OfTwoThatLiveTheLaterOneGoes) {
  pass(1s);
  const Component later(ecology, time, 1);
  pass(1s);
  EXPECT_THAT(ecology.displaced, IsEmpty()) << "the other may be about to go";
  pass(3s);
  EXPECT_THAT(ecology.displaced, ElementsAre(OwnerId(1))) << "once";
}

/// What a subscriber on each side has after another process used the id of the island for a while.
TEST_F(IdConflicts, SubscribersHaveTheValuesOfWhoStays) {
  const auto value = [](const TupleSpace& space, std::uint32_t owner, std::string_view key) {
    const auto found = space.get(OwnerId(owner), key);
    return found ? std::string(found->value) : "none";
  };
  ASSERT_TRUE(island->space.set("lamp", "off"));
  ASSERT_TRUE(island->space.set("line", "up"));
  Component robot(ecology, time, 70000);
  ASSERT_TRUE(robot.space.set("goal", "a"));
  const auto of_robot = robot.space.subscribe(pattern("1:**"), {}, [](const Event&) {});
  const auto of_island = island->space.subscribe(pattern("70000:**"), {}, [](const Event&) {});
  pass(1s);
  ASSERT_EQ(value(robot.space, 1, "lamp"), "off");
  for (const std::string round : {"first", "second"}) {
    auto twin = std::make_unique<Component>(ecology, time, 1);
    ASSERT_TRUE(twin->space.set("lamp", "on"));
    auto of_twin = twin->space.subscribe(pattern("70000:**"), {}, [](const Event&) {});
    pass(1s);
    EXPECT_EQ(value(robot.space, 1, "lamp"), "on");
    of_twin = {};
    twin.reset();
    pass(1s);
    EXPECT_EQ(value(robot.space, 1, "lamp"), "off") << "without a change at the island";
    EXPECT_NE(value(robot.space, 1, "line"), "none");
    ASSERT_TRUE(island->space.set("line", round));
    ASSERT_TRUE(robot.space.set("goal", round));
    pass(1s);
    EXPECT_EQ(value(robot.space, 1, "line"), round);
    EXPECT_EQ(value(island->space, 70000, "goal"), round);
  }
}

TEST_F(IdConflicts, WhoInventsStartsHidesNoRealOne) {
  dds::Rogue rogue(66666);
  for (std::uint64_t i = 1; i <= 20; ++i) rogue.show(1, start + i);
  pass(1s);
  const Component later(ecology, time, 1);
  pass(5s);
  EXPECT_THAT(ecology.displaced, ElementsAre(OwnerId(1)));
}

TEST_F(IdConflicts, AreAllAskedWhoeverCameBefore) {
  support::CollectingLog lines;
  std::vector<std::uint64_t> asked;
  dds::IdConflicts conflicts(OwnerId(1), time, 2s, {lines, "dds"},
                             {[&](std::uint64_t incarnation) -> Result<std::unique_ptr<dds::Channel>> {
                                asked.push_back(incarnation);
                                return fail(ErrorCode::kIo, "no channel");
                              },
                              [] {}});
  conflicts.begin(start);
  for (std::uint8_t i = 1; i <= 40; ++i) conflicts.seen(start - i, dds::Participant{i});
  EXPECT_THAT(asked, Contains(start - 40));
}

TEST_F(IdConflicts, WhoGoesWithinALeaseDisplacesNobody) {
  pass(1s);
  const Component later(ecology, time, 1);
  pass(1s);
  island.reset();
  pass(10s);
  EXPECT_THAT(ecology.displaced, IsEmpty());
}

}  // namespace
}  // namespace rubicon::tuples
