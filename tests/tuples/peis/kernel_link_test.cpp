#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rubicon/tuple_space.hpp"
#include "support/collecting_log.h"
#include "tuples/peis/kernel_peer.h"
#include "tuples/peis/peis_link.h"
#include "tuples/peis/tuple_wire.h"

namespace rubicon::tuples::peis {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

constexpr OwnerId kSelf{200}, kKernel{101};

std::string text_of(const Bytes& bytes) {
  return std::string(base::as_text(bytes));
}

std::string c_string(std::string_view text) {
  return std::string(text) + '\0';
}

/// A component of ours with a simulated kernel.
class LinkToAKernel : public ::testing::Test {
 protected:
  LinkToAKernel() {
    kernel.listen();
    PeisOptions options;
    options.multicast = false;
    options.connect = {"127.0.0.1:9000"};
    const PeisMachine machine{world.interfaces, "hostx", "host-of-hostx", "4711", "anna"};
    link = std::make_unique<PeisLink>(kSelf, PeisLink::Settings{options, world.interfaces, machine}, world.time,
                                      world.machine, log, nullptr);
    space = std::make_unique<TupleSpace>(kSelf, world.time, *link);
    world.run(1s);
  }

  void subscribe(std::string_view key, bool force = true) {
    Subscribe out;
    out.force_resend = force;
    out.prototype.owner = kSelf;
    out.prototype.key = key;
    kernel.send(200, Port::kSubscribe, text_of(write(out)));
  }
  void unsubscribe(std::string_view key) {
    Unsubscribe out;
    out.owner = kSelf;
    out.key = key;
    kernel.send(200, Port::kUnsubscribe, text_of(write(out)));
  }
  NetworkTuple tuple(OwnerId owner, std::string_view key, std::string_view data) {
    NetworkTuple out;
    out.owner = owner;
    out.creator = kKernel;
    out.key = key;
    out.write_time = world.time.wall_now();
    out.user_time = out.expire_time = WallTime{};
    out.encoding = Encoding::kAscii;
    out.media_type = "text/plain";
    out.data = data;
    out.sequence = 0;
    return out;
  }
  void push(std::string_view key, const std::string& value, std::uint32_t number) {
    const auto data = c_string(value);
    auto out = tuple(kKernel, key, data);
    out.sequence = number;
    kernel.send(200, Port::kPush, text_of(write_push(out)));
  }
  void set_remote(std::string_view key, const std::string& data) {
    kernel.send(200, Port::kSetRemote, text_of(write_set_remote(tuple(kSelf, key, data))));
  }

  /// Pushes that the kernel received since the last call: `key=data`, `key=` and the data of a delete.
  struct Pushed {
    std::string key, data;
    std::uint32_t number = 0;
    bool is_delete = false;
  };
  std::vector<Pushed> pushed() {
    std::vector<Pushed> found;
    for (; taken < kernel.messages.size(); ++taken) {
      const auto& message = kernel.messages[taken];
      if (message.header.port != Port::kPush) continue;
      const auto read = read_push(base::as_bytes(message.body));
      EXPECT_TRUE(read) << message.body;
      EXPECT_EQ(read->owner, kSelf);
      EXPECT_EQ(read->annex, Annex{}) << "nothing of ours goes to kernels";
      found.push_back(
          {std::string(read->key), std::string(*read->data), *read->sequence, *read->expire_time == kDeleteTime});
    }
    return found;
  }
  /// Those of the own tuples, without kernel.*.
  std::vector<std::string> own_pushed() {
    std::vector<std::string> found;
    for (const auto& push : pushed()) {
      if (!push.key.starts_with("kernel.")) found.push_back(push.key + (push.is_delete ? " deleted" : "=" + push.data));
    }
    return found;
  }
  std::vector<std::string> subscribed() const {
    std::vector<std::string> keys;
    for (const auto& message : kernel.messages) {
      if (message.header.port == Port::kSubscribe)
        keys.push_back(std::string(read_subscribe(base::as_bytes(message.body))->prototype.key));
    }
    return keys;
  }
  EventCall note() {
    return [this](const Event& event) {
      const std::string key(event.tuple.key);
      seen.push_back(event.kind == EventKind::kSet ? key + "=" + std::string(event.tuple.value)
                                                   : key + " " + std::string(to_string(event.kind)));
    };
  }
  std::vector<std::string> take() { return std::exchange(seen, {}); }
  const SessionCounters& counters() const { return link->presence()->counters(); }

  PeisWorld world;
  support::CollectingLog log;
  KernelPeer kernel{world, 101, 9000};
  std::unique_ptr<PeisLink> link;
  std::unique_ptr<TupleSpace> space;
  std::size_t taken = 0;
  std::vector<std::string> seen;
};

TEST_F(LinkToAKernel, ASubscriptionGetsWhatThereIsAndEachChange) {
  ASSERT_TRUE(space->set("demo.temp.value", "21.5"));
  subscribe("demo.*.value");
  world.run(100ms);
  EXPECT_THAT(own_pushed(), ElementsAre(c_string("demo.temp.value=21.5")));
  ASSERT_TRUE(space->set("demo.temp.value", "22"));
  world.run(100ms);
  EXPECT_THAT(own_pushed(), ElementsAre(c_string("demo.temp.value=22")));
  EXPECT_TRUE(space->set("demo.temp.value.deep", "1"));
  world.run(100ms);
  EXPECT_THAT(own_pushed(), IsEmpty()) << "* is one part";
}

TEST_F(LinkToAKernel, AnEmptyValueIsOneNulAndBinaryStaysAsItIs) {
  subscribe("");
  ASSERT_TRUE(space->set("empty", ""));
  ASSERT_TRUE(space->set("binary", std::string("\xff\0", 2), {"application/x"}));
  world.run(100ms);
  EXPECT_THAT(own_pushed(), UnorderedElementsAre(std::string("empty=\0", 7), std::string("binary=\xff\0", 9)));
}

TEST_F(LinkToAKernel, NumbersRiseFromZeroAlsoWhenATupleIsDeletedAndMadeAgain) {
  subscribe("a");
  std::vector<std::uint32_t> numbers;
  const auto next = [&] {
    world.run(100ms);
    for (const auto& push : pushed()) numbers.push_back(push.number);
  };
  ASSERT_TRUE(space->set("a", "1"));
  next();
  ASSERT_TRUE(space->set("a", "2"));
  next();
  ASSERT_TRUE(space->erase("a"));
  next();
  ASSERT_TRUE(space->set("a", "3"));
  next();
  EXPECT_THAT(numbers, ElementsAre(0, 1, 2, 3));
}

TEST_F(LinkToAKernel, ADeleteIsASetThatExpiredIn1970) {
  subscribe("a");
  ASSERT_TRUE(space->set("a", "1"));
  world.run(100ms);
  own_pushed();
  ASSERT_TRUE(space->erase("a"));
  world.run(100ms);
  EXPECT_THAT(own_pushed(), ElementsAre("a deleted"));
}

TEST_F(LinkToAKernel, CopiesOfOneSubscriptionAreOneAndEndWithAsManyUnsubscribes) {
  ASSERT_TRUE(space->set("a", "1"));
  subscribe("a");
  subscribe("A");
  world.run(100ms);
  unsubscribe("a");
  world.run(100ms);
  own_pushed();
  ASSERT_TRUE(space->set("a", "2"));
  world.run(100ms);
  EXPECT_THAT(own_pushed(), ElementsAre(c_string("a=2"))) << "one handle is left, and one push is made";
  unsubscribe("a");
  world.run(100ms);
  ASSERT_TRUE(space->set("a", "3"));
  world.run(100ms);
  EXPECT_THAT(own_pushed(), IsEmpty());
}

TEST_F(LinkToAKernel, ARoundWithoutForceCountsTheHandlesAnew) {
  ASSERT_TRUE(space->set("a", "1"));
  subscribe("a", false);
  subscribe("a", false);
  world.run(5s);
  subscribe("a", false);  // a failed acknowledgement: the whole set again, now with one handle
  world.run(100ms);
  unsubscribe("a");
  world.run(100ms);
  own_pushed();
  ASSERT_TRUE(space->set("a", "2"));
  world.run(100ms);
  EXPECT_THAT(own_pushed(), IsEmpty());
}

TEST_F(LinkToAKernel, OwnersLearnOfTheFirstAndTheLastSubscriber) {
  std::vector<std::string> demands;
  const auto watch = space->watch_demand(*Pattern::parse("*.value"), [&](const Demand& demand) {
    demands.push_back(std::string(demand.key) + (demand.wanted ? " on" : " off"));
  });
  ASSERT_TRUE(space->set("temp.value", "1"));
  subscribe("TEMP.value");
  world.run(2s);
  EXPECT_THAT(demands, ElementsAre("temp.value on"));
  unsubscribe("temp.VALUE");
  world.run(100ms);
  EXPECT_THAT(demands, ElementsAre("temp.value on", "temp.value off"));
}

TEST_F(LinkToAKernel, KeysAreComparedWithoutCase) {
  ASSERT_TRUE(space->set("Mix.Case", "1"));
  subscribe("mix.*");
  subscribe("MIX.later");
  world.run(100ms);
  EXPECT_THAT(own_pushed(), ElementsAre(c_string("Mix.Case=1"))) << "in the first spelling";
  ASSERT_TRUE(space->set("Mix.Later", "2"));
  world.run(100ms);
  EXPECT_THAT(own_pushed(), Contains(c_string("Mix.Later=2")));
  ASSERT_TRUE(space->set("mix.case", "other"));
  world.run(100ms);
  EXPECT_THAT(own_pushed(), IsEmpty()) << "one tuple to kernels, and this is not it";
  EXPECT_EQ(counters().refused_keys, 1u);
  EXPECT_THAT(log.lines, Contains(HasSubstr("differs only in case")));
}

TEST_F(LinkToAKernel, KeysBeyondTheLimitsOfKernelsAreRefusedAndCounted) {
  subscribe("");
  world.run(100ms);
  own_pushed();
  ASSERT_TRUE(space->set("a.b.c.d.e.f.g.h", "8 parts"));
  ASSERT_TRUE(space->set(std::string(128, 'k'), "long"));
  ASSERT_TRUE(space->set("a.b.c.d.e.f.g", "7 parts"));
  world.run(100ms);
  EXPECT_THAT(own_pushed(), ElementsAre(c_string("a.b.c.d.e.f.g=7 parts")));
  EXPECT_EQ(counters().refused_keys, 2u);
  EXPECT_THAT(log.lines, IsSupersetOf({AllOf(HasSubstr("a.b.c.d.e.f.g.h"), HasSubstr("8 parts")),
                                       AllOf(HasSubstr("128 characters"), HasSubstr("not published"))}));
}

TEST_F(LinkToAKernel, ASubscriptionWithAMediaTypeGetsThatOnly) {
  Subscribe out;
  out.prototype.key = "*";
  out.prototype.media_type = "application/json";
  kernel.send(200, Port::kSubscribe, text_of(write(out)));
  ASSERT_TRUE(space->set("a", "1"));
  ASSERT_TRUE(space->set("b", "{}", {"application/json"}));
  world.run(100ms);
  EXPECT_THAT(own_pushed(), ElementsAre(c_string("b={}")));
}

TEST_F(LinkToAKernel, TheTuplesOfAKernelArePublishedAndKeptCurrent) {
  ASSERT_TRUE(space->set("b", "1"));
  ASSERT_TRUE(space->set("a", "1"));
  subscribe("kernel.*");
  world.run(3s);
  std::map<std::string, std::string> tuples;
  for (const auto& push : pushed()) tuples[push.key] = push.data;
  EXPECT_EQ(tuples["kernel.id"], c_string("200"));
  EXPECT_EQ(tuples["kernel.name"], c_string("rubicon"));
  EXPECT_EQ(tuples["kernel.hostname"], c_string("hostx"));
  EXPECT_EQ(tuples["kernel.user"], c_string("anna"));
  EXPECT_THAT(tuples["kernel.version"], HasSubstr("(proto 500)"));
  EXPECT_EQ(tuples["kernel.do-quit"], c_string(""));
  EXPECT_EQ(tuples["kernel.all-keys"], c_string("(a b)"));
  EXPECT_EQ(tuples["kernel.subscribers"], c_string("(\n  ( 101 200.kernel.* )\n)\n"));
  ASSERT_TRUE(space->erase("b"));
  world.run(1100ms);
  std::vector<std::string> lists;
  for (const auto& push : pushed()) {
    if (push.key == "kernel.all-keys") lists.push_back(push.data);
  }
  EXPECT_THAT(lists, ElementsAre(c_string("(a)")));
  world.run(20s);
  for (const auto& push : pushed()) tuples[push.key] = push.data;
  EXPECT_THAT(tuples["kernel.connections"], AllOf(HasSubstr("((101 "), HasSubstr(" tcp 0))")));
  EXPECT_EQ(tuples["kernel.routingTable"], c_string("(\n (101 1 101)\n)\n"));
}

TEST_F(LinkToAKernel, DoQuitOfOthersIsIgnoredAndLogged) {
  set_remote("kernel.Do-Quit", c_string("yes"));
  world.run(100ms);
  EXPECT_EQ(counters().ignored_quits, 1u);
  EXPECT_THAT(log.lines, Contains(AllOf(HasSubstr("kernel.do-quit"), HasSubstr("ignored"))));
  EXPECT_THAT(space->peers(), ElementsAre(kKernel));
}

TEST_F(LinkToAKernel, ARemoteSetOfAKernelIsDecidedByThePolicyOfTheTuple) {
  std::vector<std::string> sets;
  const auto policy = space->add_policy(*Pattern::parse("Act.*"), [&](const RemoteSet& set) {
    sets.push_back(set.key + "=" + set.value);
    return SetDecision::applied();
  });
  ASSERT_TRUE(space->set("Act.lamp", "off"));
  subscribe("act.*");
  world.run(100ms);
  own_pushed();
  set_remote("act.LAMP", c_string("on"));
  set_remote("other", c_string("x"));
  world.run(100ms);
  EXPECT_THAT(sets, ElementsAre("Act.lamp=on")) << "the trailing NUL is not part of the value";
  EXPECT_THAT(own_pushed(), ElementsAre(c_string("Act.lamp=on")));
  EXPECT_EQ(space->get(kSelf, "Act.lamp")->creator, kKernel);
  EXPECT_EQ(counters().refused_sets, 1u);
}

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
  EXPECT_EQ(replies[0].verdict, Verdict::kExpired);
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
