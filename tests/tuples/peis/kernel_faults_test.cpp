#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "tuples/peis/link_to_a_kernel.h"
#include "tuples/peis/own_messages.h"

namespace rubicon::tuples::peis {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Le;
using ::testing::Not;
using ::testing::SizeIs;

TEST_F(LinkToAKernel, AKernelThatAcknowledgesNothingMakesNoQueueOfOldLists) {
  for (int i = 0; i < 2000; ++i) ASSERT_TRUE(space->set(std::string(90, 'k') + std::to_string(i), "1"));
  world.run(2s);
  kernel.acknowledges = false;
  for (int i = 0; i < 300; ++i) {
    subscribe("kernel.all-keys");
    world.run(10ms);
  }
  kernel.acknowledges = true;
  world.run(1min);
  const auto parts = std::count_if(kernel.messages.begin(), kernel.messages.end(),
                                   [](const auto& message) { return message.header.port == Port::kPush; });
  EXPECT_GT(parts, 190) << "one list has about 190 parts";
  EXPECT_LT(parts, 800);
}

TEST_F(LinkToAKernel, AKernelThatForgetsUsAgainAndAgainGetsEachSubscriptionAFewTimes) {
  std::vector<decltype(space->subscribe({}, {}, nullptr))> subscriptions;
  for (int i = 0; i < 2000; ++i)
    subscriptions.push_back(space->subscribe(*Pattern::parse("101:k" + std::to_string(i)), {}, note()));
  world.run(10s);
  kernel.acknowledges = false;
  const auto before = subscribed().size();
  for (int i = 0; i < 30; ++i) {
    kernel.send(200, Port::kDeadHost, text_of(write(DeadHost{kSelf, DeathReason::kReborn})));
    world.run(100ms);
  }
  kernel.acknowledges = true;
  world.run(1min);
  EXPECT_THAT(subscribed().size() - before, AllOf(Ge(2000u), Le(6000u)));
}

TEST_F(LinkToAKernel, APatternThatKernelsDoNotHaveIsRefusedExceptToAComponentOfOursWhoseHelloIsLate) {
  Subscribe out;
  out.prototype.owner = kSelf;
  out.prototype.key = "**";
  out.prototype.annex = to_annex(SubscribeAnnex{7, {}});
  kernel.send(200, Port::kSubscribe, text_of(write(out)));
  world.run(1s);
  EXPECT_THAT(log.lines, Not(Contains(HasSubstr("not one of a kernel"))));
  EXPECT_EQ(counters().refused_patterns, 0U);
  subscribe("**");
  world.run(1s);
  EXPECT_THAT(log.lines, Contains(HasSubstr("subscription of component 101 to '**': key '**': not one of a kernel")));
  EXPECT_EQ(counters().refused_patterns, 1U);
}

TEST_F(LinkToAKernel, APushThatWasGivenUpIsMadeAgain) {
  ASSERT_TRUE(space->set("a", "1"));
  ASSERT_TRUE(space->set("gone", "1"));
  ASSERT_TRUE(space->set("made.again", "1"));
  subscribe("");
  world.run(5s);
  own_pushed();
  kernel.loss = 1;
  ASSERT_TRUE(space->set("a", "2"));
  ASSERT_TRUE(space->erase("gone"));
  ASSERT_TRUE(space->erase("made.again"));
  world.run(5s);
  ASSERT_TRUE(space->set("made.again", "2"));
  world.run(15s);
  kernel.loss = 0;
  world.run(15s);
  EXPECT_GT(counters().lost_pushes, 0u);
  EXPECT_THAT(log.lines, Contains(AllOf(HasSubstr("component 101"), HasSubstr("did not acknowledge"))));
  EXPECT_THAT(space->peers(), ElementsAre(kKernel)) << "it was here all the time";
  std::map<std::string, Pushed> newest;
  for (const auto& push : pushed()) {
    if (!newest.contains(push.key) || newest[push.key].number <= push.number) newest[push.key] = push;
  }
  EXPECT_EQ(newest["a"].data, c_string("2"));
  EXPECT_TRUE(newest["gone"].is_delete);
  EXPECT_EQ(newest["made.again"].data, c_string("2"));
}

TEST_F(LinkToAKernel, AKernelThatIsBackGetsAtOnceWhatWasGivenUp) {
  ASSERT_TRUE(space->set("a", "1"));
  subscribe("a");
  world.run(5s);
  own_pushed();
  kernel.stop_listening();
  kernel.close();
  ASSERT_TRUE(space->set("a", "2"));
  world.run(14s);
  EXPECT_THAT(space->peers(), ElementsAre(kKernel)) << "its route may come back";
  kernel.connect(8000);
  world.run(1s);
  EXPECT_THAT(own_pushed(), Contains(c_string("a=2")));
}

TEST_F(LinkToAKernel, ALateSubscriptionGetsNoCopyThatHasExpired) {
  const auto all = space->subscribe(*Pattern::parse("101:*"), {}, note());
  world.run(1s);
  const auto data = c_string("1");
  auto brief = tuple(kKernel, "brief", data);
  brief.expire_time = *brief.write_time + 2s;
  kernel.send(200, Port::kPush, text_of(write_push(brief)));
  world.run(5s);
  EXPECT_THAT(take(), ElementsAre("brief=1", "brief expired"));
  const auto late = space->subscribe(*Pattern::parse("101:*"), {}, note());
  world.run(1s);
  EXPECT_THAT(take(), IsEmpty());
}

/// Ends the link in the call that a test names; counts the calls after that.
struct Ender final : LinkListener {
  void on_changes(OwnerId, std::span<const Change> changes) override { called("changes", changes.size()); }
  void on_subscribe(OwnerId subscriber, const SubscriptionSpec&) override {
    called(subscriber == kLinkItself ? "observe" : "subscribe");
  }
  void on_unsubscribe(OwnerId, std::uint32_t) override { called("unsubscribe"); }
  void on_remote_set(const RemoteSet&) override { called("set"); }
  bool on_reply(OwnerId, const Reply& reply) override {
    replies.push_back(reply);
    called("reply");
    return true;
  }
  void on_peer(const PeerIdentity&, PeerEvent) override { called("peer"); }
  void on_summary(OwnerId, std::string_view) override { called("summary"); }

  void called(std::string_view call, std::size_t times = 1) {
    if (!link) late_calls += times;
    if (call == ends_in) link.reset();
  }

  std::unique_ptr<Link> link;
  std::string ends_in;
  std::size_t late_calls = 0;
  std::vector<Reply> replies;
};

class LinkThatEnds : public ::testing::Test {
 protected:
  LinkThatEnds() {
    kernel.listen();
    PeisOptions options;
    options.multicast = false;
    options.connect = {"127.0.0.1:9000"};
    const PeisMachine machine{world.interfaces, "hostx", "host-of-hostx", "4711", "anna"};
    ender.link = std::make_unique<PeisLink>(kSelf, PeisLink::Settings{options, world.interfaces, machine}, world.time,
                                            world.machine, log, nullptr);
  }
  void push(std::string_view key) {
    const auto data = c_string("1");
    NetworkTuple out;
    out.owner = out.creator = kKernel;
    out.key = key;
    out.write_time = out.user_time = out.expire_time = WallTime{};
    out.encoding = Encoding::kAscii;
    out.media_type = "text/plain";
    out.data = data;
    out.sequence = 0;
    kernel.send(200, Port::kPush, text_of(write_push(out)));
  }

  PeisWorld world;
  support::CollectingLog log;
  KernelPeer kernel{world, 101, 9000};
  Ender ender;
};

TEST_F(LinkThatEnds, WhileItAsksForTheOwnTuples) {
  ender.ends_in = "observe";
  ender.link->attach(ender, 1);
  world.run(2s);
  EXPECT_EQ(ender.link, nullptr);
  EXPECT_EQ(ender.late_calls, 0u);
}

TEST_F(LinkThatEnds, WhileALateSubscriptionGetsTheCopies) {
  ender.link->attach(ender, 1);
  ender.link->subscribe({1, {kKernel, "*"}, {}});
  world.run(2s);
  for (const auto* key : {"a", "b", "c"}) push(key);
  world.run(1s);
  ender.ends_in = "changes";
  ender.link->subscribe({2, {kKernel, "*"}, {}});
  world.run(1s);
  EXPECT_EQ(ender.link, nullptr);
  EXPECT_EQ(ender.late_calls, 0u);
  EXPECT_EQ(kernel.links(), 0u) << "it said goodbye";
}

TEST_F(LinkThatEnds, ASetWhoseTimeEndsBeforeThereIsRoomIsReportedAsNotSent) {
  ender.link->attach(ender, 1);
  world.run(2s);
  kernel.acknowledges = false;
  RemoteSet set;
  set.from = kSelf;
  set.owner = kKernel;
  set.key = "act";
  set.value = std::string(60'000, 'x');
  set.time_to_live = 1s;
  for (set.request = 1; set.request <= 20; ++set.request) ASSERT_TRUE(ender.link->remote_set(set));
  world.run(3s);
  kernel.acknowledges = true;
  world.run(20s);
  ASSERT_THAT(ender.replies, SizeIs(20));
  const auto not_sent = std::count_if(ender.replies.begin(), ender.replies.end(), [](const Reply& reply) {
    return reply.verdict == Verdict::kExpired && reply.text.find("it was not sent") != std::string::npos;
  });
  EXPECT_THAT(not_sent, AllOf(Ge(10), Le(19)));
}

}  // namespace
}  // namespace rubicon::tuples::peis
