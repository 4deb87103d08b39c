#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/component.h"
#include "tuples/dds/dds_test_ecology.h"
#include "tuples/dds/rogue.h"
#include "tuples/distant/frame_codec.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using distant::FrameTimes;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::uint32_t kCommander = 70007;
/// The host of the commander started long ago.
constexpr Duration kAhead = 24h;

/// An island (1), a robot (70000) and a commander whose frames are written by the test.
struct LateCommands : testing::Test, TwoComponentsOf<dds::DdsTestEcology> {
  void SetUp() override {
    policy = island->space.add_policy(pattern("cmd"), [this](const RemoteSet& set) {
      decided.push_back(set.value);
      return SetDecision::applied();
    });
    ASSERT_TRUE(until([&] { return island->space.peers().size() == 2 && robot->space.peers().size() == 2; }));
  }
  template <class Done>
  bool until(Done done) {
    for (int i = 0; i < 1000 && !done(); ++i) time.run_for(1ms);
    return done();
  }
  void let_pass() {
    for (int i = 0; i < 50; ++i) time.run_for(1ms);
  }
  Duration now() const { return time.now().time_since_epoch(); }
  /// A frame that left the commander so long ago; with the time at the island that it saw then.
  FrameTimes sent(Duration ago, bool with_echo) const {
    FrameTimes times{now() - ago + kAhead, {}, {}, false};
    if (with_echo) times.echo = now() - ago;
    return times;
  }
  void tell(const std::optional<FrameTimes>& times, const std::vector<std::string>& commands, Duration lives = 1s) {
    distant::FrameWriter frame;
    if (times) frame.add(*times);
    for (const auto& value : commands) {
      RemoteSet set;
      set.request = ++request;
      set.key = "cmd";
      set.value = value;
      set.time_to_live = lives;
      frame.add(set);
    }
    commander.frame(kCommander, commander.incarnation(), 1, island_incarnation, frame.take());
  }
  Verdict verdict_of_robot(Duration lives) {
    std::optional<Verdict> verdict;
    robot->space.set_remote(kIsland, "cmd", "robot", lives, [&](const Reply& reply) { verdict = reply.verdict; });
    until([&] { return verdict.has_value(); });
    return verdict.value_or(Verdict::kRefused);
  }

  std::vector<std::string> decided;
  std::uint64_t request = 0;
  Handle policy;
  dds::Rogue commander{kCommander};
  const std::uint64_t island_incarnation = commander.incarnation_of(1);
};

TEST_F(LateCommands, AreNotCarriedOutWhereverTheyWaited) {
  tell(sent(0s, true), {"in time"});
  ASSERT_TRUE(until([&] { return !decided.empty(); }));
  tell(sent(1500ms, false), {"late"});
  tell(sent(500ms, false), {"in time again"});
  EXPECT_TRUE(until([&] { return decided.size() == 2; }));
  EXPECT_THAT(decided, ElementsAre("in time", "in time again"));
}

TEST_F(LateCommands, WaitForTheFirstEchoInOrder) {
  tell(sent(0s, false), {"a", "b"});
  tell(sent(0s, false), {"c"});
  let_pass();
  EXPECT_THAT(decided, IsEmpty()) << "the time of receipt is no start";
  EXPECT_EQ(verdict_of_robot(1s), Verdict::kApplied) << "others are not held up";
  tell(sent(0s, true), {"d"});
  EXPECT_TRUE(until([&] { return decided.size() == 5; }));
  EXPECT_THAT(decided, ElementsAre("robot", "a", "b", "c", "d"));
}

TEST_F(LateCommands, OfSomebodyWhoSaysNoTimesAreNotCarriedOut) {
  tell({}, {"a"});
  tell(sent(0s, false), {"b"}, 100ms);
  for (int i = 0; i < 30; ++i) time.run_for(100ms);
  tell(sent(0s, true), {"c"});
  EXPECT_TRUE(until([&] { return !decided.empty(); }));
  EXPECT_THAT(decided, ElementsAre("c"));
}

/// A robot that was asked once is not asked again: one frame each way.
TEST_F(LateCommands, RealComponentsTellEachOtherTheirTimes) {
  for (int i = 0; i < 3; ++i) EXPECT_EQ(verdict_of_robot(1s), Verdict::kApplied);
  for (int i = 0; i < 20; ++i) time.run_for(10s);
  EXPECT_EQ(verdict_of_robot(1s), Verdict::kApplied) << "the clocks may have drifted: it is asked again";
  EXPECT_THAT(decided, ElementsAre("robot", "robot", "robot", "robot"));
}

}  // namespace
}  // namespace rubicon::tuples
