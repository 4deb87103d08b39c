#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/references.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(References, AreReadInOurSpelling) {
  const auto name = read_reference(kReferenceMediaType, "6541:proxy.dummy-1.1.sensor.light-1.value");
  ASSERT_TRUE(name);
  EXPECT_EQ(*name, (TupleName{OwnerId(6541), "proxy.dummy-1.1.sensor.light-1.value"}));
  EXPECT_EQ(read_reference(kReferenceMediaType, to_string(*name)), *name);
}

TEST(References, AreReadInTheSpellingOfPeis) {
  const TupleName expected{OwnerId(101), "demo.temp.value"};
  EXPECT_EQ(read_reference(kPeisReferenceMediaType, "(META 101 demo.temp.value)"), expected);
  EXPECT_EQ(read_reference(kPeisReferenceMediaType, std::string_view("(META 101 demo.temp.value)\0", 27)), expected);
  EXPECT_EQ(read_reference(kPeisReferenceMediaType, "(META -1 NULL)").error().code, ErrorCode::kNotFound);
}

TEST(References, ThatAreNoneAreRefused) {
  for (const auto* text : {"a.b", "0:a", "*:a", "1:*", "1:a.**", "1:", ":a", "1:a b", " 1:a", "1:a\n", "-1:a", "+1:a",
                           "4294967296:a", "1:2:a", "1:a..b", "(META 1 a)"}) {
    EXPECT_EQ(read_reference(kReferenceMediaType, text).error().code, ErrorCode::kInvalid) << text;
  }
  for (const auto* text : {"", "(", ")", "(META", "(META )", "(META 1)", "(META 1 )", "(META  1 a)", "(META 1  a)",
                           "(META 1 a", "(META -1 a)", "(META 0 a)", "(META 1 *)", "(meta 1 a)", "1:a"}) {
    EXPECT_EQ(read_reference(kPeisReferenceMediaType, text).error().code, ErrorCode::kInvalid) << text;
  }
  EXPECT_EQ(read_reference(kReferenceMediaType, "").error().code, ErrorCode::kNotFound);
  const auto plain = read_reference("text/plain", "1:a");
  EXPECT_EQ(plain.error().code, ErrorCode::kInvalid);
  EXPECT_THAT(plain.error().text, HasSubstr("not a meta tuple"));
}

TEST_F(MetaTuples, LeadToTheirTarget) {
  ASSERT_TRUE(island->space.set("light", "5"));
  const auto seen = see("1:**");
  time.run_ready();
  link("best", here("light"));
  EXPECT_EQ(robot->space.get(kRobot, "best")->value, "1:light");
  EXPECT_EQ(robot->space.get(kRobot, "best")->media_type, kReferenceMediaType);
  EXPECT_EQ(resolve(robot->space, there("best")), here("light"));
  EXPECT_EQ(get_through(robot->space, there("best"))->value, "5");
  link("better", there("best"));
  EXPECT_EQ(resolve(robot->space, there("better")), here("light")) << "a chain";
}

TEST_F(MetaTuples, SayWhyTheyLeadNowhere) {
  EXPECT_EQ(resolve(robot->space, there("none")).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(robot->space.set("plain", "1:light"));
  EXPECT_EQ(resolve(robot->space, there("plain")).error().code, ErrorCode::kInvalid);
  ASSERT_TRUE(robot->space.set("empty", "", {.media_type = kReferenceMediaType}));
  EXPECT_EQ(resolve(robot->space, there("empty")).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(robot->space.set("broken", "light", {.media_type = kReferenceMediaType}));
  link("outer", there("broken"));
  const auto broken = resolve(robot->space, there("outer"));
  EXPECT_EQ(broken.error().code, ErrorCode::kInvalid);
  EXPECT_THAT(broken.error().text, HasSubstr("70000:outer at 70000:broken"));
  link("dangling", there("nothing"));
  EXPECT_EQ(resolve(robot->space, there("dangling")), there("nothing"));
  EXPECT_EQ(get_through(robot->space, there("dangling")).error().code, ErrorCode::kNotFound);
}

TEST_F(MetaTuples, RefuseCyclesByName) {
  link("a", there("b"));
  link("b", there("c"));
  const auto refused = set_reference(robot->space, "c", there("a"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kRefused);
  EXPECT_THAT(refused.error().text, HasSubstr("cycle 70000:c -> 70000:a -> 70000:b -> 70000:c"));
  EXPECT_FALSE(robot->space.find("c"));
  EXPECT_THAT(set_reference(robot->space, "self", there("self")).error().text,
              HasSubstr("cycle 70000:self -> 70000:self"));

  point(robot->space, "c", there("b"));
  const auto found = resolve(robot->space, there("a"));
  EXPECT_EQ(found.error().code, ErrorCode::kRefused);
  EXPECT_THAT(found.error().text, HasSubstr("meta tuple 70000:a: cycle 70000:b -> 70000:c -> 70000:b"));
}

TEST_F(MetaTuples, FollowEightReferencesAndNoMore) {
  ASSERT_TRUE(robot->space.set("m8", "end"));
  for (int i = 7; i >= 0; --i) link("m" + std::to_string(i), there("m" + std::to_string(i + 1)));
  EXPECT_EQ(resolve(robot->space, there("m0")), there("m8"));
  const auto refused = set_reference(robot->space, "ninth", there("m0"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kOutOfRange);
  point(robot->space, "ninth", there("m0"));
  EXPECT_EQ(resolve(robot->space, there("ninth")).error().code, ErrorCode::kOutOfRange);
}

TEST_F(MetaTuples, RefuseImpossibleNames) {
  EXPECT_EQ(set_reference(robot->space, "a..b", here("x")).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(set_reference(robot->space, "a", here("x.*")).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(set_reference(robot->space, "a", {OwnerId(0), "x"}).error().code, ErrorCode::kInvalid);
  EXPECT_FALSE(set_reference(robot->space, here("*"), here("x"), 1s, {}));
  EXPECT_FALSE(robot->space.find("a"));
  EXPECT_FALSE(subscribe_through(robot->space, there("*"), {}, [](const Event&) {}));
}

TEST_F(MetaTuples, OfOthersAreSetThroughTheirPolicy) {
  const auto seen = see("1:**");
  const auto policy = island->space.add_policy(pattern("best"), [](const RemoteSet& set) {
    return is_reference(set.media_type) ? SetDecision::applied() : SetDecision::refused({ErrorCode::kInvalid, "no"});
  });
  std::vector<Verdict> verdicts;
  ASSERT_TRUE(set_reference(robot->space, here("best"), here("light"), 1s,
                            [&](const Reply& reply) { verdicts.push_back(reply.verdict); }));
  time.run_ready();
  EXPECT_THAT(verdicts, ElementsAre(Verdict::kApplied));
  EXPECT_EQ(resolve(robot->space, here("best")), here("light"));
  EXPECT_EQ(set_reference(robot->space, here("best"), here("best"), 1s, {}).error().code, ErrorCode::kRefused);
}

TEST_F(MetaTuples, SetAndAppendThroughAskTheOwnerOfTheTarget) {
  const auto seen = see("1:**");
  ASSERT_TRUE(island->space.set("lamp", "off"));
  const auto policy = island->space.add_policy(
      pattern("lamp"), [](const RemoteSet&) { return SetDecision::applied(); }, PolicyScope::kSetsAndAppends);
  link("best", here("lamp"));
  time.run_ready();
  Seen verdicts;
  const auto note = [&](const Reply& reply) { verdicts.push_back(std::string(to_string(reply.verdict))); };
  ASSERT_TRUE(set_through(robot->space, there("best"), "on", 1s, note));
  time.run_ready();
  EXPECT_EQ(island->space.get(kIsland, "lamp")->value, "on");
  EXPECT_EQ(island->space.get(kIsland, "lamp")->creator, kRobot);
  ASSERT_TRUE(append_through(robot->space, there("best"), "!", 1s, note, {.expected_sequence = 2}));
  ASSERT_TRUE(append_through(robot->space, there("best"), "?", 1s, note, {.expected_sequence = 2}));
  time.run_ready();
  EXPECT_EQ(island->space.get(kIsland, "lamp")->value, "on!");
  EXPECT_THAT(verdicts, ElementsAre("applied", "applied", "refused"));
  EXPECT_EQ(robot->space.get(kRobot, "best")->value, "1:lamp");
}

TEST_F(MetaTuples, AnOwnTargetIsDecidedLikeAnyOther) {
  ASSERT_TRUE(robot->space.set("mode", "idle"));
  link("best", there("mode"));
  std::vector<ErrorCode> codes;
  const auto note = [&](const Reply& reply) { codes.push_back(reply.code); };
  ASSERT_TRUE(set_through(robot->space, there("best"), "busy", 1s, note));
  time.run_ready();
  EXPECT_THAT(codes, ElementsAre(ErrorCode::kRefused)) << "it has no policy";
  const auto policy = robot->space.add_policy(pattern("mode"), [](const RemoteSet&) { return SetDecision::applied(); });
  ASSERT_TRUE(set_through(robot->space, there("best"), "busy", 1s, note));
  time.run_ready();
  EXPECT_EQ(get_through(robot->space, there("best"))->value, "busy");
}

TEST_F(MetaTuples, NothingIsSetThroughToATargetThatIsNotSeen) {
  ASSERT_TRUE(island->space.set("inner", "1:lamp", {.media_type = kReferenceMediaType}));
  const auto policy = island->space.add_policy(pattern("**"), [](const RemoteSet&) { return SetDecision::applied(); });
  link("outer", here("inner"));
  const auto blind = set_through(robot->space, there("outer"), "on", 1s, {});
  ASSERT_FALSE(blind) << "would overwrite the reference";
  EXPECT_EQ(blind.error().code, ErrorCode::kNotFound);
  const auto seen = see("1:**");
  time.run_ready();
  ASSERT_TRUE(island->space.set("lamp", "off"));
  time.run_ready();
  ASSERT_TRUE(set_through(robot->space, there("outer"), "on", 1s, {}));
  time.run_ready();
  EXPECT_EQ(island->space.get(kIsland, "lamp")->value, "on");
  EXPECT_EQ(island->space.get(kIsland, "inner")->value, "1:lamp");
}

}  // namespace
}  // namespace rubicon::tuples
