#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/component.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;

struct RemoteSets : testing::Test, TwoComponents {
  ReplyCall note() {
    return [this](const Reply& reply) { replies.push_back(reply); };
  }
  const Reply& only() {
    EXPECT_EQ(replies.size(), 1u);
    static const Reply none{{}, 0, Verdict::kNoSuchOwner, ErrorCode::kIo, "no reply"};
    return replies.empty() ? none : replies.back();
  }
  std::vector<Reply> replies;
};

TEST_F(RemoteSets, AnAppliedOneIsStoredWithItsCreator) {
  const auto policy = island->space.add_policy(pattern("a.*"), [](const RemoteSet&) { return SetDecision::applied(); });
  const auto request = robot->space.set_remote(kIsland, "a.b", "5", 1s, note(), {"text/x", WallTime{2s}, 9s});
  EXPECT_TRUE(replies.empty());
  time.run_ready();
  EXPECT_EQ(only().verdict, Verdict::kApplied);
  EXPECT_EQ(only().request, request);
  const auto tuple = *island->space.get(kIsland, "a.b");
  EXPECT_EQ(tuple.value, "5");
  EXPECT_EQ(tuple.creator, kRobot);
  EXPECT_EQ(tuple.media_type, "text/x");
  EXPECT_EQ(tuple.user_time, WallTime{2s});
  EXPECT_EQ(tuple.expire_time, time.wall_now() + 9s);
}

TEST_F(RemoteSets, AConsumedOneIsNotStored) {
  const auto policy = island->space.add_policy(pattern("G"), [](const RemoteSet&) { return SetDecision::consumed(); });
  robot->space.set_remote(kIsland, "G", "5", 1s, note());
  time.run_ready();
  EXPECT_EQ(only().verdict, Verdict::kApplied);
  EXPECT_FALSE(island->space.find("G"));
}

TEST_F(RemoteSets, ARefusalSaysWhy) {
  const auto policy = island->space.add_policy(pattern("**"), [](const RemoteSet&) {
    return SetDecision::refused({ErrorCode::kOutOfRange, "too hot"});
  });
  robot->space.set_remote(kIsland, "a", "5", 1s, note());
  time.run_ready();
  EXPECT_EQ(only().verdict, Verdict::kRefused);
  EXPECT_EQ(only().code, ErrorCode::kOutOfRange);
  EXPECT_EQ(only().text, "too hot");
}

TEST_F(RemoteSets, WithoutAPolicyTuplesAreReadOnly) {
  ASSERT_TRUE(island->space.set("a", "1"));
  robot->space.set_remote(kIsland, "a", "5", 1s, note());
  robot->space.set_remote(kIsland, "b", "5", 1s, note());
  robot->space.set_remote(kIsland, "b..c", "5", 1s, note());
  time.run_ready();
  ASSERT_EQ(replies.size(), 3u);
  EXPECT_EQ(replies[0].code, ErrorCode::kRefused);
  EXPECT_EQ(replies[1].code, ErrorCode::kNotFound);
  EXPECT_EQ(replies[2].code, ErrorCode::kInvalid);
  EXPECT_EQ(island->space.get(kIsland, "a")->value, "1");
}

TEST_F(RemoteSets, TheNarrowestPolicyDecides) {
  const auto say = [](const char* text) {
    return [text](const RemoteSet&) { return SetDecision::refused({ErrorCode::kRefused, text}); };
  };
  std::vector<Handle> policies;
  policies.push_back(island->space.add_policy(pattern("**"), say("anything")));
  policies.push_back(island->space.add_policy(pattern("a.**"), say("rest")));
  policies.push_back(island->space.add_policy(pattern("a.b"), say("exact")));
  policies.push_back(island->space.add_policy(pattern("a.*"), say("part")));
  for (const auto* key : {"a.b", "a.c", "a.c.d", "z"}) robot->space.set_remote(kIsland, key, "", 1s, note());
  time.run_ready();
  std::vector<std::string> texts;
  for (const auto& reply : replies) texts.push_back(reply.text);
  EXPECT_THAT(texts, testing::ElementsAre("exact", "part", "rest", "anything"));
}

TEST_F(RemoteSets, ToOneselfGoThroughTheSamePolicyLater) {
  int decided = 0;
  const auto policy = island->space.add_policy(pattern("a"), [&](const RemoteSet& set) {
    EXPECT_EQ(set.from, kIsland);
    EXPECT_TRUE(set.time_to_live_given);
    ++decided;
    return SetDecision::applied();
  });
  island->space.set_remote(kIsland, "a", "5", 1s, note());
  EXPECT_EQ(decided, 0);
  time.run_ready();
  EXPECT_EQ(decided, 1);
  EXPECT_EQ(only().verdict, Verdict::kApplied);
}

TEST_F(RemoteSets, AnAbsentOwnerIsSaidSo) {
  robot->space.set_remote(OwnerId(5), "a", "5", 1s, note());
  EXPECT_TRUE(replies.empty());
  time.run_for(1h);
  EXPECT_EQ(only().verdict, Verdict::kNoSuchOwner);
}

/// The island took it: "expired" would be wrong.
TEST_F(RemoteSets, ALostAnswerEndsWithTheTimeToLive) {
  const auto policy = island->space.add_policy(pattern("a"), [](const RemoteSet&) { return SetDecision::consumed(); });
  robot->space.set_remote(kIsland, "a", "5", {}, note());
  ecology.cut(kIsland, kRobot);
  time.run_for(5s - 1ns);
  EXPECT_TRUE(replies.empty());
  time.run_for(1ns);
  EXPECT_EQ(only().verdict, Verdict::kTimedOut);
  ecology.mend(kIsland, kRobot);
  time.run_for(1h);
  EXPECT_EQ(replies.size(), 1u);
}

TEST_F(RemoteSets, ManyThatAreLostEndInTheOrderOfTheirTimesAndAtMostTenMillisecondsLate) {
  const auto policy = island->space.add_policy(pattern("a"), [](const RemoteSet&) { return SetDecision::consumed(); });
  const auto begin = time.now();
  std::vector<int> ended;
  for (const int millis : {300, 101, 100, 104, 305, 5000}) {
    robot->space.set_remote(kIsland, "a", "5", std::chrono::milliseconds(millis), [&, millis](const Reply& reply) {
      EXPECT_EQ(reply.verdict, Verdict::kTimedOut);
      const auto late = time.now() - begin - std::chrono::milliseconds(millis);
      EXPECT_TRUE(late >= 0ms && late <= 10ms) << millis;
      ended.push_back(millis);
    });
  }
  ecology.cut(kIsland, kRobot);
  time.run_for(1h);
  EXPECT_THAT(ended, testing::ElementsAre(100, 101, 104, 300, 305, 5000));
}

TEST_F(RemoteSets, BeyondTheBoundAreRefusedBusy) {
  const auto policy = island->space.add_policy(pattern("a"), [](const RemoteSet&) { return SetDecision::consumed(); });
  std::size_t applied = 0, busy = 0;
  for (int i = 0; i < 100'010; ++i) {
    robot->space.set_remote(kIsland, "a", "5", 1s, [&](const Reply& reply) {
      ++(reply.verdict == Verdict::kApplied ? applied : busy);
      EXPECT_TRUE(reply.verdict == Verdict::kApplied || reply.code == ErrorCode::kBusy);
    });
  }
  time.run_for(1h);
  EXPECT_EQ(applied, 100'000u);
  EXPECT_EQ(busy, 10u);
}

TEST_F(RemoteSets, APolicyMayEndItselfAndEraseTheTuple) {
  Handle policy;
  ASSERT_TRUE(island->space.set("a", "1"));
  policy = island->space.add_policy(pattern("a"), [&](const RemoteSet&) {
    policy.reset();
    EXPECT_TRUE(island->space.erase("a"));
    return SetDecision::applied();
  });
  robot->space.set_remote(kIsland, "a", "5", 1s, note());
  time.run_ready();
  EXPECT_EQ(only().verdict, Verdict::kApplied);
  EXPECT_EQ(island->space.get(kIsland, "a")->sequence, 1u);
}

}  // namespace
}  // namespace rubicon::tuples
