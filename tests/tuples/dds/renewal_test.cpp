#include <gtest/gtest.h>

#include "tuples/component.h"
#include "tuples/dds/dds_test_ecology.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;

/// An island (1) and a robot (70000), each with a tuple that the other one has a copy of.
struct EnteringAgain : testing::Test, TwoComponentsOf<dds::DdsTestEcology> {
  template <class Done>
  bool until(Done done) {
    for (int i = 0; i < 1000 && !done(); ++i) time.run_for(10ms);
    return done();
  }
  bool has(const TupleSpace& space, OwnerId owner, std::string_view key, std::string_view value) {
    return until([&] {
      const auto found = space.get(owner, key);
      return found && found->owner_present && found->value == value;
    });
  }
};

TEST_F(EnteringAgain, SubscriptionsAreLiveOnBothSidesAndNoCommandIsExecutedTwice) {
  std::vector<std::string> decided;
  const auto policy = island->space.add_policy(pattern("cmd"), [&](const RemoteSet& set) {
    decided.push_back(set.value);
    return SetDecision::applied();
  });
  const auto of_island = robot->space.subscribe(pattern("1:lamp"), {}, [](const Event&) {});
  const auto of_robot = island->space.subscribe(pattern("70000:goal"), {}, [](const Event&) {});
  ASSERT_TRUE(island->space.set("lamp", "off"));
  ASSERT_TRUE(robot->space.set("goal", "a"));
  ASSERT_TRUE(has(robot->space, kIsland, "lamp", "off"));
  ASSERT_TRUE(has(island->space, kRobot, "goal", "a"));
  for (int i = 1; i <= 5; ++i) {
    const auto text = std::to_string(i);
    int answers = 0;
    robot->space.set_remote(kIsland, "cmd", "before " + text, 60s, [&](const Reply&) { ++answers; });
    ASSERT_TRUE(until([&] { return answers == 1; }));
    ecology.enter_again();
    time.run_for(10ms);
    ASSERT_TRUE(island->space.set("lamp", text));
    ASSERT_TRUE(robot->space.set("goal", text));
    EXPECT_TRUE(has(robot->space, kIsland, "lamp", text)) << text;
    EXPECT_TRUE(has(island->space, kRobot, "goal", text)) << text;
  }
  EXPECT_EQ(decided.size(), 5U);
}

}  // namespace
}  // namespace rubicon::tuples
