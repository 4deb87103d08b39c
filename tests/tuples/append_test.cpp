#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/component.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::size_t kMiB = 1024 * 1024;

struct Appends : testing::Test, TwoComponents {
  Handle accept(std::string_view keys) {
    return island->space.add_policy(
        pattern(keys),
        [this](const RemoteSet& set) {
          decided.push_back(set);
          return SetDecision::applied();
        },
        PolicyScope::kSetsAndAppends);
  }
  /// The answer to what the robot asks.
  Reply append(std::string_view key, std::string_view bytes, const SetOptions& options = {}) {
    return answer(
        [&](ReplyCall call) { robot->space.append_remote(kIsland, key, bytes, 1s, std::move(call), options); });
  }
  Reply set(std::string_view key, std::string_view value, const SetOptions& options = {}) {
    return answer([&](ReplyCall call) { robot->space.set_remote(kIsland, key, value, 1s, std::move(call), options); });
  }
  template <class Ask>
  Reply answer(Ask ask) {
    std::vector<Reply> replies;
    ask([&](const Reply& reply) { replies.push_back(reply); });
    time.run_ready();
    EXPECT_EQ(replies.size(), 1u);
    return replies.empty() ? Reply{} : replies.back();
  }
  TupleView own(std::string_view key) { return island->space.get(kIsland, key).value_or(TupleView{}); }

  std::vector<RemoteSet> decided;
};

TEST_F(Appends, AddToAnOwnTupleAsOneSetEach) {
  Listener near;
  ASSERT_TRUE(island->space.set("log", "a"));
  const auto subscription = island->space.subscribe(pattern("log"), {}, near.call());
  EXPECT_TRUE(island->space.append("log", "b"));
  EXPECT_TRUE(island->space.append(*island->space.find("log"), "c"));
  time.run_ready();
  EXPECT_THAT(near.take(), ElementsAre("log=a", "log=ab", "log=abc"));
  EXPECT_EQ(own("log").sequence, 3u);
}

TEST_F(Appends, TakeBytesWithNulsAndTheTuplesOwnValue) {
  const SetOptions bytes{.media_type = "application/octet-stream"};
  ASSERT_TRUE(island->space.set("b", std::string_view("\0\xff", 2), bytes));
  EXPECT_TRUE(island->space.append("b", std::string_view("\0", 1), bytes));
  EXPECT_TRUE(island->space.append("b", own("b").value, bytes));
  EXPECT_EQ(own("b").value, std::string_view("\0\xff\0\0\xff\0", 6));
  EXPECT_EQ(own("b").media_type, "application/octet-stream");
}

TEST_F(Appends, NeedATupleOfTheSameMediaType) {
  EXPECT_EQ(island->space.append("none", "x").error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(island->space.find("none"));
  ASSERT_TRUE(island->space.set("j", "{}", {.media_type = "application/json"}));
  const auto refused = island->space.append("j", "x");
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalid);
  EXPECT_THAT(refused.error().text, HasSubstr("application/json"));
  EXPECT_EQ(own("j").value, "{}");
  EXPECT_EQ(own("j").sequence, 1u);
  EXPECT_TRUE(island->space.append("j", "\n{}", {.media_type = {}})) << "none named: whatever it is";
  EXPECT_EQ(own("j").media_type, "application/json");
}

TEST_F(Appends, EndAtTheSizeOfAValueAndLeaveTheTupleAsItWas) {
  ASSERT_TRUE(island->space.set("big", std::string(kMiB - 1, 'x')));
  EXPECT_TRUE(island->space.append("big", "y"));
  const auto refused = island->space.append("big", "z");
  EXPECT_EQ(refused.error().code, ErrorCode::kOutOfRange);
  EXPECT_EQ(own("big").value.size(), kMiB);
  EXPECT_EQ(own("big").sequence, 2u);
  EXPECT_TRUE(island->space.append("big", ""));
  EXPECT_EQ(island->space.append("big", std::string(2 * kMiB, 'z')).error().code, ErrorCode::kOutOfRange);
}

TEST_F(Appends, HappenOnlyAtTheExpectedSequence) {
  ASSERT_TRUE(island->space.set("log", "a"));
  EXPECT_TRUE(island->space.append("log", "b", {.expected_sequence = 1}));
  const auto late = island->space.append("log", "c", {.expected_sequence = 1});
  EXPECT_EQ(late.error().code, ErrorCode::kRefused);
  EXPECT_EQ(late.error().text, "writing 'log': expected sequence 1, found sequence 2");
  EXPECT_EQ(own("log").value, "ab");
  EXPECT_EQ(island->space.append("none", "c", {.expected_sequence = 7}).error().text,
            "writing 'none': expected sequence 7, found no such tuple");
}

TEST_F(Appends, AShortNameThatIsOverIsNotFound) {
  const auto tuple = *island->space.set("log", "a");
  ASSERT_TRUE(island->space.erase("log"));
  ASSERT_TRUE(island->space.set("log", "new"));
  EXPECT_EQ(island->space.append(tuple, "b").error().code, ErrorCode::kNotFound);
  island->space.erase(pattern("*"));
  EXPECT_EQ(island->space.append("log", "b").error().code, ErrorCode::kNotFound);
}

TEST_F(Appends, KeepTheTimeTheTupleExpiresUnlessTheyNameAnother) {
  ASSERT_TRUE(island->space.set("short", "a", {.lifetime = 10s}));
  ASSERT_TRUE(island->space.set("long", "a", {.lifetime = 10s}));
  Listener far;
  const auto subscription = robot->space.subscribe(pattern("1:*"), {}, far.call());
  time.run_for(6s);
  ASSERT_TRUE(island->space.append("short", "b"));
  ASSERT_TRUE(island->space.append("long", "b", {.lifetime = 10s}));
  time.run_for(5s);
  EXPECT_FALSE(island->space.find("short"));
  EXPECT_THAT(far.take(), testing::UnorderedElementsAre("short=a", "long=a", "short=ab", "long=ab", "short expired"));
  time.run_for(5s);
  EXPECT_FALSE(island->space.find("long"));
}

TEST_F(Appends, ADistantSubscriberAlwaysSeesTheWholeValue) {
  ASSERT_TRUE(island->space.set("log", ""));
  Listener far, slow;
  const auto all = robot->space.subscribe(pattern("1:log"), {}, far.call());
  Component observer{ecology, time, 80000};
  const auto paced = observer.space.subscribe(pattern("1:log"), {.minimum = 10s}, slow.call());
  time.run_ready();
  for (const auto* piece : {"a", "b", "c"}) ASSERT_TRUE(island->space.append("log", piece));
  time.run_for(1s);
  ASSERT_TRUE(island->space.append("log", "d"));
  time.run_for(10s);
  EXPECT_THAT(far.take(), ElementsAre("log=", "log=abc", "log=abcd"));
  EXPECT_THAT(slow.take(), ElementsAre("log=", "log=abcd"));
  EXPECT_EQ(robot->space.get(kIsland, "log")->sequence, 5u);
}

TEST_F(Appends, FromOtherComponentsAreDecidedAsAppendsAndStoredWithTheirCreator) {
  const auto policy = accept("log");
  ASSERT_TRUE(island->space.set("log", "a"));
  const auto reply = append("log", "b", {.user_time = WallTime{7s}});
  EXPECT_EQ(reply.verdict, Verdict::kApplied);
  EXPECT_EQ(reply.sequence, 2u);
  ASSERT_EQ(decided.size(), 1u);
  EXPECT_TRUE(decided[0].append);
  EXPECT_EQ(decided[0].value, "b") << "the piece, not the whole";
  EXPECT_EQ(own("log").value, "ab");
  EXPECT_EQ(own("log").creator, kRobot);
  EXPECT_EQ(own("log").user_time, WallTime{7s});
}

TEST_F(Appends, OnlyReachPoliciesThatAcceptThem) {
  const auto policy = island->space.add_policy(pattern("switch"), [](const RemoteSet& set) {
    return set.value == "on" ? SetDecision::applied() : SetDecision::refused({ErrorCode::kInvalid, "on or off"});
  });
  ASSERT_TRUE(island->space.set("switch", "on"));
  ASSERT_TRUE(island->space.set("published", "1"));
  const auto reply = append("switch", "on");
  EXPECT_EQ(reply.verdict, Verdict::kRefused);
  EXPECT_EQ(reply.code, ErrorCode::kRefused);
  EXPECT_THAT(reply.text, HasSubstr("whole values"));
  EXPECT_EQ(own("switch").value, "on");
  EXPECT_THAT(append("published", "2").text, HasSubstr("read-only"));
  EXPECT_EQ(append("none", "2").code, ErrorCode::kNotFound);
}

TEST_F(Appends, ThatCannotBeDoneDoNotReachThePolicy) {
  const auto policy = accept("**");
  ASSERT_TRUE(island->space.set("log", std::string(kMiB, 'x')));
  EXPECT_EQ(append("log", "y").code, ErrorCode::kOutOfRange);
  EXPECT_EQ(append("log", "y", {.media_type = "application/json"}).code, ErrorCode::kInvalid);
  EXPECT_EQ(append("none", "y").code, ErrorCode::kNotFound);
  EXPECT_EQ(append("a..b", "y").code, ErrorCode::kInvalid);
  const auto late = append("log", "", {.expected_sequence = 4});
  EXPECT_EQ(late.code, ErrorCode::kRefused);
  EXPECT_EQ(late.sequence, 1u) << "the present one, to try again with";
  EXPECT_TRUE(decided.empty());
  EXPECT_EQ(own("log").sequence, 1u);
}

TEST_F(Appends, APolicyMayConsumeOrRefuseThem) {
  SetDecision verdict = SetDecision::consumed();
  const auto policy = island->space.add_policy(
      pattern("log"), [&](const RemoteSet&) { return verdict; }, PolicyScope::kSetsAndAppends);
  ASSERT_TRUE(island->space.set("log", "a"));
  EXPECT_EQ(append("log", "b").verdict, Verdict::kApplied);
  verdict = SetDecision::refused({ErrorCode::kBusy, "not now"});
  EXPECT_EQ(append("log", "b").code, ErrorCode::kBusy);
  EXPECT_EQ(own("log").value, "a");
}

TEST_F(Appends, OfTwoWritersWithOneSequenceOneIsRefusedAndCanGoOn) {
  const auto policy = accept("log");
  ASSERT_TRUE(island->space.set("log", ""));
  Component second{ecology, time, 80000};
  std::vector<Reply> replies;
  const auto note = [&](const Reply& reply) { replies.push_back(reply); };
  robot->space.append_remote(kIsland, "log", "r", 1s, note, {.expected_sequence = 1});
  second.space.append_remote(kIsland, "log", "s", 1s, note, {.expected_sequence = 1});
  time.run_ready();
  ASSERT_EQ(replies.size(), 2u);
  EXPECT_EQ(replies[0].verdict, Verdict::kApplied);
  EXPECT_EQ(replies[1].verdict, Verdict::kRefused);
  second.space.append_remote(kIsland, "log", "s", 1s, note, {.expected_sequence = replies[1].sequence});
  time.run_ready();
  EXPECT_EQ(replies.back().verdict, Verdict::kApplied);
  EXPECT_EQ(own("log").value, "rs");
}

TEST_F(Appends, ToOneselfGoThroughThePolicyToo) {
  const auto policy = accept("log");
  ASSERT_TRUE(island->space.set("log", "a"));
  const auto reply =
      answer([&](ReplyCall call) { island->space.append_remote(kIsland, "log", "b", 1s, std::move(call)); });
  EXPECT_EQ(reply.verdict, Verdict::kApplied);
  EXPECT_EQ(decided.size(), 1u);
  EXPECT_EQ(own("log").value, "ab");
}

TEST_F(Appends, ALostAnswerIsRepeatedSafelyWithTheSequence) {
  const auto policy = accept("log");
  ASSERT_TRUE(island->space.set("log", "a"));
  Reply lost;
  robot->space.append_remote(kIsland, "log", "b", 1s, [&](const Reply& reply) { lost = reply; },
                             {.expected_sequence = 1});
  while (own("log").sequence == 1) time.run_for(0s);
  ecology.cut(kIsland, kRobot);
  ecology.mend(kIsland, kRobot);
  time.run_for(2s);
  const auto again = append("log", "b", {.expected_sequence = 1});
  EXPECT_EQ(again.verdict, Verdict::kRefused);
  EXPECT_EQ(again.sequence, 2u);
  EXPECT_EQ(own("log").value, "ab");
}

TEST_F(Appends, SetsCompareSequencesToo) {
  const auto policy = accept("**");
  EXPECT_TRUE(island->space.set("own", "1", {.expected_sequence = 0}));
  EXPECT_EQ(island->space.set("own", "2", {.expected_sequence = 0}).error().text,
            "writing 'own': expected no such tuple, found sequence 1");
  const auto tuple = *island->space.find("own");
  EXPECT_EQ(island->space.set(tuple, "2", {.expected_sequence = 5}).error().code, ErrorCode::kRefused);
  EXPECT_TRUE(island->space.set(tuple, "2", {.expected_sequence = 1}));
  EXPECT_EQ(own("own").value, "2");

  EXPECT_EQ(set("far", "1", {.expected_sequence = 0}).sequence, 1u);
  const auto twice = set("far", "2", {.expected_sequence = 0});
  EXPECT_EQ(twice.verdict, Verdict::kRefused);
  EXPECT_EQ(twice.sequence, 1u);
  EXPECT_EQ(set("far", "2", {.expected_sequence = 1}).sequence, 2u);
  EXPECT_EQ(decided.size(), 2u) << "the refused one was not decided";
}

}  // namespace
}  // namespace rubicon::tuples
