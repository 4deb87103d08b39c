#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tuples/component.h"
#include "tuples/dds/dds_test_ecology.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::Not;

/// An island (1) whose host had no time when it began. The robots have one.
struct UnsetClock : testing::Test {
  UnsetClock() {
    time.set_wall(WallTime(21h));
    island = std::make_unique<Component>(ecology, time, 1);
  }
  void pass(Duration time_to_pass) {
    for (auto left = time_to_pass; left > 0ms; left -= 100ms) time.run_for(100ms);
  }
  /// DDS takes its own time.
  template <class Condition>
  bool in_the_end(Condition condition) {
    for (int i = 0; i < 300 && !condition(); ++i) time.run_for(100ms);
    return condition();
  }
  bool sees_island(const Component& robot) {
    return in_the_end([&] {
      const auto peers = robot.space.peers();
      return std::find(peers.begin(), peers.end(), OwnerId(1)) != peers.end();
    });
  }
  void set_clock() { time.set_wall(kNow); }
  static std::string value(const TupleSpace& space, std::uint32_t owner, std::string_view key) {
    const auto found = space.get(OwnerId(owner), key);
    return found ? std::string(found->value) : "none";
  }

  static constexpr WallTime kNow{1'790'000'000s};
  VirtualScheduler time;
  dds::DdsTestEcology ecology{time};
  std::unique_ptr<Component> island;
};

TEST_F(UnsetClock, TheIslandTakesPartWhenItIsSet) {
  ASSERT_TRUE(island->space.set("lamp", "off"));
  const auto of_robot = island->space.subscribe(pattern("70000:**"), {}, [](const Event&) {});
  set_clock();
  Component robot(ecology, time, 70000);
  ASSERT_TRUE(robot.space.set("goal", "a"));
  const auto of_island = robot.space.subscribe(pattern("1:**"), {}, [](const Event&) {});
  pass(2s);
  ASSERT_THAT(robot.space.peers(), Not(Contains(OwnerId(1)))) << "its start is in 1970";
  ASSERT_TRUE(sees_island(robot));
  EXPECT_TRUE(in_the_end([&] { return value(robot.space, 1, "lamp") == "off"; }));
  EXPECT_TRUE(in_the_end([&] { return value(island->space, 70000, "goal") == "a"; })) << "what it subscribed before";
  ASSERT_TRUE(island->space.set("lamp", "on"));
  EXPECT_TRUE(in_the_end([&] { return value(robot.space, 1, "lamp") == "on"; }));
  EXPECT_TRUE(ecology.log().contains("the clock of this host was set"));
}

TEST_F(UnsetClock, TheIslandStaysOutsideUntilItIsSet) {
  pass(30s);
  const auto now = time.wall_now();
  set_clock();
  const Component robot(ecology, time, 70000);
  time.set_wall(now);
  pass(10s);
  EXPECT_THAT(robot.space.peers(), Not(Contains(OwnerId(1))));
  EXPECT_FALSE(ecology.log().contains("the clock of this host was set"));
  set_clock();
  EXPECT_TRUE(sees_island(robot));
}

TEST_F(UnsetClock, AStartWithATimeIsKept) {
  set_clock();
  const Component robot(ecology, time, 70000);
  const auto start_of = [&](std::uint32_t id) {
    std::uint64_t latest = 0;
    for (const auto& one : ecology.component_starts()) {
      if (one.id == OwnerId(id)) latest = std::max(latest, one.incarnation);
    }
    return latest;
  };
  pass(2s);
  const auto before = start_of(70000);
  EXPECT_TRUE(sees_island(robot));
  EXPECT_EQ(start_of(70000), before);
  EXPECT_GT(start_of(1), before) << "from when the clock was set";
}

}  // namespace
}  // namespace rubicon::tuples
