#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tuples/component.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;

using Values = std::map<std::string, std::string>;

/// The contract of every engine: where an owner is met again, or another start of its id is followed, subscribers send
/// their subscriptions again and the new snapshot decides. An island, a robot and an observer subscribe to everything.
struct MetAgain : testing::Test, TwoComponents {
  /// Each step waits a little for engines with sockets.
  void pass(Duration time_to_pass) {
    for (auto left = time_to_pass; left > 0ms; left -= 100ms) time.run_for(100ms);
  }
  /// Without the tuples of the engine's own.
  static Values of(const TupleSpace& space, OwnerId owner) {
    Values found;
    space.list({owner, "**"}, [&](const TupleView& tuple) {
      if (!tuple.key.starts_with("kernel.")) found.emplace(tuple.key, tuple.value);
    });
    return found;
  }
  [[nodiscard]] static Handle of_all(Component& component) {
    return component.space.subscribe(pattern("**"), {}, [](const Event&) {});
  }
  /// The copies that others have and that are not what their owner has: `70000 of 1`.
  std::vector<std::string> wrong_copies() const {
    std::vector<std::string> wrong;
    const std::vector<const Component*> all{island.get(), robot.get(), observer.get()};
    for (const auto* owner : all) {
      const auto id = owner->space.self();
      for (const auto* other : all) {
        if (of(other->space, id) != of(owner->space, id))
          wrong.push_back(std::to_string(number(other->space.self())) + " of " + std::to_string(number(id)));
      }
    }
    return wrong;
  }
  /// Engines notice after a while that one of two components with an id is gone.
  void settle() {
    for (int i = 0; i < 300 && !wrong_copies().empty(); ++i) pass(100ms);
  }
  void set(Component& owner, const Values& values) {
    for (const auto& [key, value] : values) ASSERT_TRUE(owner.space.set(key, value));
  }

  std::unique_ptr<Component> observer = std::make_unique<Component>(ecology, time, 70001);
  Handle of_island = of_all(*island), of_robot = of_all(*robot), of_observer = of_all(*observer);
};

TEST_F(MetAgain, AnOwnerOutOfReachIsFollowedWithAllThatChangedMeanwhile) {
  for (auto* owner : {island.get(), robot.get()}) {
    set(*owner, {{"same", "1"}, {"changed", "1"}, {"deleted", "1"}, {"made-again", "1"}});
    ASSERT_TRUE(owner->space.set("expired", "1", {.lifetime = 5s}));
    ASSERT_TRUE(owner->space.set("expired-with-its-owner", "1", {.lifetime = 1h}));
  }
  pass(1s);
  EXPECT_THAT(wrong_copies(), IsEmpty()) << "before the cut";
  for (const std::string round : {"first", "second"}) {
    ecology.cut(kIsland, kRobot);
    pass(1s);
    for (auto* owner : {island.get(), robot.get()}) {
      set(*owner, {{"changed", round}, {"new-" + round, "1"}});
      std::ignore = owner->space.erase("deleted");
      ASSERT_TRUE(owner->space.erase("made-again"));
      ASSERT_TRUE(owner->space.set("made-again", round));
      std::ignore = owner->space.erase("expired-with-its-owner");
    }
    pass(10s);
    ecology.mend(kIsland, kRobot);
    pass(2s);
    EXPECT_THAT(wrong_copies(), IsEmpty()) << "after the " + round + " cut";
    EXPECT_FALSE(robot->space.get(kIsland, "expired"));
    set(*island, {{"later", round}});
    set(*robot, {{"later", round}});
    pass(1s);
    EXPECT_THAT(wrong_copies(), IsEmpty()) << "changes after the " + round + " cut";
    EXPECT_TRUE(island->space.has_subscriber(*island->space.find("later")));
  }
}

TEST_F(MetAgain, AnotherStartIsFollowedByEverySubscriberAndHasTheirSubscriptions) {
  set(*island, {{"lamp", "off"}, {"of-the-first", "1"}});
  ASSERT_TRUE(island->space.set("expires", "1", {.lifetime = 20s}));
  set(*robot, {{"goal", "a"}});
  pass(1s);
  for (const std::string round : {"second", "third"}) {
    of_island = {};
    island.reset();
    pass(1s);
    island = std::make_unique<Component>(ecology, time, 1);
    of_island = of_all(*island);
    set(*island, {{"lamp", "on"}, {"of-the-" + round, "1"}});
    pass(2s);
    EXPECT_THAT(wrong_copies(), IsEmpty()) << "the " + round + " start";
    EXPECT_EQ(of(robot->space, kIsland), (Values{{"lamp", "on"}, {"of-the-" + round, "1"}}));
    set(*island, {{"lamp", round}});
    set(*robot, {{"goal", round}});
    pass(1s);
    EXPECT_THAT(wrong_copies(), IsEmpty()) << "changes after the " + round + " start";
  }
}

/// Engines that know all components of an ecology let an id in once, which a test of theirs checks: there the second
/// start does not exist. On the others both live for a while, until one of them ends.
TEST_F(MetAgain, OfTwoStartsOfOneIdWhoStaysDecidesAtEveryParty) {
  if (!kOneIdMayStartTwice) {
    EXPECT_EQ(ecology.join(kIsland).error().code, ErrorCode::kDuplicate);
    return;
  }
  set(*island, {{"lamp", "off"}, {"line", "up"}});
  set(*robot, {{"goal", "a"}});
  pass(1s);
  for (const std::string round : {"first", "second"}) {
    auto twin = std::make_unique<Component>(ecology, time, 1);
    auto of_twin = of_all(*twin);
    set(*twin, {{"lamp", "on"}, {"of-the-twin", round}});
    ASSERT_TRUE(twin->space.set("expires", "1", {.lifetime = 2s}));
    pass(1s);
    of_twin = {};
    twin.reset();
    pass(3s);
    settle();
    EXPECT_THAT(wrong_copies(), IsEmpty()) << "after the " + round + " twin";
    set(*island, {{"line", round}});
    set(*robot, {{"goal", round}});
    pass(1s);
    EXPECT_THAT(wrong_copies(), IsEmpty()) << "changes after the " + round + " twin";
  }
}

}  // namespace
}  // namespace rubicon::tuples
