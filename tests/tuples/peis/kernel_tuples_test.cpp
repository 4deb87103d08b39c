#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/peis/link_to_a_kernel.h"

namespace rubicon::tuples::peis {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST_F(LinkToAKernel, OursSubscribeOnceForEachDepthAndGetTheEndOfTheSnapshot) {
  int ends = 0;
  const auto one = space->subscribe(*Pattern::parse("101:a.**"), {}, note(), [&](OwnerId) { ++ends; });
  world.run(50ms);
  push("a.b", "1", 4);
  world.run(500ms);
  EXPECT_THAT(subscribed(), ElementsAre("a", "a.*", "a.*.*", "a.*.*.*", "a.*.*.*.*", "a.*.*.*.*.*", "a.*.*.*.*.*.*"));
  EXPECT_THAT(take(), ElementsAre("a.b=1"));
  EXPECT_EQ(ends, 1);
  EXPECT_EQ(space->get(kKernel, "a.b")->sequence, 5u);
  const auto two = space->subscribe(*Pattern::parse("101:a.*"), {}, note(), [&](OwnerId) { ++ends; });
  world.run(500ms);
  EXPECT_THAT(subscribed(), SizeIs(7)) << "a kernel would push twice";
  EXPECT_THAT(take(), ElementsAre("a.b=1"));
  EXPECT_EQ(ends, 2);
}

TEST_F(LinkToAKernel, EveryKeyIsTheEmptyOne) {
  const auto all = space->subscribe(*Pattern::parse("**"), {}, note());
  world.run(50ms);
  EXPECT_THAT(subscribed(), ElementsAre(""));
  push("kernel.name", "dumpk", 0);
  push("x", "1", 0);
  world.run(50ms);
  EXPECT_THAT(take(), ElementsAre("kernel.name=dumpk", "x=1"));
}

TEST_F(LinkToAKernel, OldNumbersAndTuplesOfOthersAreDropped) {
  const auto all = space->subscribe(*Pattern::parse("**"), {}, note());
  world.run(50ms);
  push("x", "5", 5);
  push("x", "4", 4);
  const auto data = c_string("forged");
  kernel.send(200, Port::kPush, text_of(write_push(tuple(OwnerId{999}, "x", data))));
  world.run(50ms);
  EXPECT_THAT(take(), ElementsAre("x=5"));
  EXPECT_EQ(counters().foreign_tuples, 1u);
}

TEST_F(LinkToAKernel, ADeleteOfAKernelRemovesTheCopyAndASmallerNumberCountsAgain) {
  const auto all = space->subscribe(*Pattern::parse("x"), {}, note());
  world.run(50ms);
  push("x", "5", 5);
  auto gone = tuple(kKernel, "x", std::string_view("\0", 1));
  gone.expire_time = kDeleteTime;
  gone.sequence = 6;
  kernel.send(200, Port::kPush, text_of(write_push(gone)));
  push("x", "again", 0);
  world.run(50ms);
  EXPECT_THAT(take(), ElementsAre("x=5", "x deleted", "x=again"));
}

TEST_F(LinkToAKernel, AnAppendOfAKernelExtendsTheCopy) {
  const auto all = space->subscribe(*Pattern::parse("log"), {}, note());
  world.run(50ms);
  push("log", "21.5", 1);
  PushAppended appended;
  appended.tuple = tuple(kKernel, "log", {});
  appended.tuple.media_type = {};
  appended.tuple.data.reset();
  appended.tuple.sequence = 1;
  appended.media_type_length = 10;
  appended.data_length = 5;
  const auto difference = c_string(";22.5");
  appended.difference = difference;
  kernel.send(200, Port::kPushAppended, text_of(write(appended)));
  world.run(50ms);
  EXPECT_THAT(take(), ElementsAre("log=21.5", "log=21.5;22.5"));
  push("log", "new", 2);
  world.run(50ms);
  EXPECT_THAT(take(), ElementsAre("log=new"));
}

TEST_F(LinkToAKernel, AnAppendByPrototypeReachesAllThatMatch) {
  const auto policy = space->add_policy(
      *Pattern::parse("**"), [](const RemoteSet&) { return SetDecision::applied(); }, PolicyScope::kSetsAndAppends);
  ASSERT_TRUE(space->set("ap.x", "1"));
  ASSERT_TRUE(space->set("ap.y", "2"));
  subscribe("none");
  world.run(1s);
  SetAppend out;
  out.prototype.owner = kSelf;
  out.prototype.key = "AP.*";
  const auto difference = c_string(";3");
  out.difference = difference;
  kernel.send(200, Port::kSetAppend, text_of(write(out)));
  world.run(100ms);
  EXPECT_EQ(space->get(kSelf, "ap.x")->value, "1;3");
  EXPECT_EQ(space->get(kSelf, "ap.y")->value, "2;3");
}

TEST_F(LinkToAKernel, ARemoteSetToAKernelSaysThatItArrivedOnly) {
  std::vector<Reply> replies;
  space->set_remote(kKernel, "act.switch.command", "1", 5s, [&](const Reply& reply) { replies.push_back(reply); });
  world.run(1s);
  ASSERT_THAT(replies, SizeIs(1));
  EXPECT_EQ(replies[0].verdict, Verdict::kApplied);
  EXPECT_THAT(replies[0].text, HasSubstr("does not say whether it was accepted"));
  const auto sent = kernel.of(Port::kSetRemote);
  ASSERT_THAT(sent, SizeIs(1));
  const auto set = *read_set_remote(base::as_bytes(sent[0].body));
  EXPECT_EQ(set.owner, kKernel);
  EXPECT_EQ(set.creator, kSelf);
  EXPECT_EQ(*set.data, c_string("1"));
  EXPECT_EQ(set.sequence, 0u) << "kernels take over any other";
  EXPECT_EQ(set.annex, Annex{});
}

TEST_F(LinkToAKernel, TheNewValueOfTheOwnerIsAReply) {
  kernel.acknowledges = false;
  const auto all = space->subscribe(*Pattern::parse("act"), {}, note());
  std::vector<Reply> replies;
  space->set_remote(kKernel, "act", "1", 5s, [&](const Reply& reply) { replies.push_back(reply); });
  world.run(100ms);
  const auto data = c_string("1");
  auto news = tuple(kKernel, "act", data);
  news.creator = kSelf;
  news.sequence = 7;
  kernel.send(200, Port::kPush, text_of(write_push(news)));
  world.run(50ms);
  ASSERT_THAT(replies, SizeIs(1));
  EXPECT_EQ(replies[0].verdict, Verdict::kApplied);
  EXPECT_EQ(replies[0].sequence, 8u);
}

TEST_F(LinkToAKernel, WithoutAcknowledgementTheOutcomeIsUnknown) {
  kernel.acknowledges = false;
  std::vector<Reply> replies;
  space->set_remote(kKernel, "act", "1", 60s, [&](const Reply& reply) { replies.push_back(reply); });
  world.run(20s);
  ASSERT_THAT(replies, SizeIs(1));
  EXPECT_EQ(replies[0].verdict, Verdict::kTimedOut);
  EXPECT_THAT(replies[0].text, HasSubstr("may have arrived"));
}

TEST_F(LinkToAKernel, AnExpectedSequenceIsUnsupported) {
  std::vector<Reply> replies;
  space->set_remote(kKernel, "act", "1", 5s, [&](const Reply& reply) { replies.push_back(reply); },
                    {.expected_sequence = 3});
  world.run(100ms);
  ASSERT_THAT(replies, SizeIs(1));
  EXPECT_EQ(replies[0].code, ErrorCode::kUnsupported);
  EXPECT_THAT(kernel.of(Port::kSetRemote), IsEmpty());
}

TEST_F(LinkToAKernel, AMetaTupleIsReadAsItIs) {
  const auto all = space->subscribe(*Pattern::parse("mi-x"), {}, note());
  world.run(50ms);
  const auto data = c_string("(META 101 a.b)");
  auto meta = tuple(kKernel, "mi-x", data);
  meta.media_type = "x-peis/metatuple";
  kernel.send(200, Port::kPush, text_of(write_push(meta)));
  world.run(50ms);
  EXPECT_EQ(space->get(kKernel, "mi-x")->media_type, "x-peis/metatuple");
  EXPECT_THAT(take(), ElementsAre("mi-x=(META 101 a.b)"));
}

TEST_F(LinkToAKernel, AKernelThatForgotUsGetsTheSubscriptionsAgain) {
  int ends = 0;
  const auto all = space->subscribe(*Pattern::parse("x"), {}, note(), [&](OwnerId) { ++ends; });
  world.run(50ms);
  push("x", "9", 9);
  world.run(500ms);
  take();
  kernel.send(200, Port::kDeadHost, text_of(write(DeadHost{kSelf, DeathReason::kReborn})));
  world.run(50ms);
  EXPECT_THAT(subscribed(), ElementsAre("x", "x"));
  push("x", "0", 0);
  world.run(500ms);
  EXPECT_THAT(take(), ElementsAre("x=0")) << "whatever its number";
  EXPECT_EQ(ends, 2);
}

TEST_F(LinkToAKernel, TheSubscriptionsOfALostKernelEnd) {
  std::vector<std::string> demands;
  const auto watch = space->watch_demand(
      *Pattern::parse("a"), [&](const Demand& demand) { demands.push_back(demand.wanted ? "on" : "off"); });
  ASSERT_TRUE(space->set("a", "1"));
  subscribe("a");
  world.run(100ms);
  kernel.leave();
  world.run(100ms);
  EXPECT_THAT(demands, ElementsAre("on", "off"));
  EXPECT_THAT(space->peers(), IsEmpty());
}

}  // namespace
}  // namespace rubicon::tuples::peis
