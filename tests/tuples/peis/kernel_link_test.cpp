#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tuples/peis/kernel_session.h"
#include "tuples/peis/link_to_a_kernel.h"

namespace rubicon::tuples::peis {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::UnorderedElementsAre;

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

TEST_F(LinkToAKernel, AKernelThatForgotUsGetsItsTuplesAgain) {
  ASSERT_TRUE(space->set("a", "1"));
  subscribe("a");
  world.run(100ms);
  own_pushed();
  kernel.send(200, Port::kDeadHost, text_of(write(DeadHost{kSelf, DeathReason::kReborn})));
  world.run(100ms);
  EXPECT_THAT(own_pushed(), ElementsAre(c_string("a=1")));
  subscribe("a", false);
  world.run(100ms);
  unsubscribe("a");
  world.run(100ms);
  own_pushed();
  ASSERT_TRUE(space->set("a", "2"));
  world.run(100ms);
  EXPECT_THAT(own_pushed(), IsEmpty()) << "one handle, and that ended";
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
  ASSERT_TRUE(space->set("a.b.c.d.e.f.g.h", "8 parts: not published"));
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
  const auto names = "(" + std::string(KernelTuples::kNames);
  EXPECT_EQ(tuples["kernel.all-keys"], c_string(names + " a b)"));
  for (const auto& [key, value] : tuples)
    EXPECT_THAT(names + " ", AnyOf(HasSubstr("(" + key + " "), HasSubstr(" " + key + " ")));
  EXPECT_EQ(tuples["kernel.subscribers"], c_string("(\n  ( 101 200.kernel.* )\n)\n"));
  ASSERT_TRUE(space->erase("b"));
  world.run(1100ms);
  std::vector<std::string> lists;
  for (const auto& push : pushed()) {
    if (push.key == "kernel.all-keys") lists.push_back(push.data);
  }
  EXPECT_THAT(lists, ElementsAre(c_string(names + " a)")));
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

/// Kernels get no reply: the log is all that says it.
TEST_F(LinkToAKernel, EachTupleThatAKernelMayNotChangeHasALineOrIsCountedInTheNext) {
  const auto lines_with = [this](const std::string& part) {
    return std::count_if(log.lines.begin(), log.lines.end(),
                         [&](const auto& line) { return line.find(part) != line.npos; });
  };
  const auto append = [this](std::string_view key) {
    SetAppend out;
    out.prototype.owner = kSelf;
    out.prototype.key = key;
    out.difference = "x";
    kernel.send(200, Port::kSetAppend, text_of(write(out)));
  };
  ASSERT_TRUE(space->set("text", "a"));
  world.run(100ms);
  for (int round = 0; round < 3; ++round) {
    for (const auto* key : {"one", "two"}) set_remote(key, c_string("1"));
    append("text");
    append("absent");
    world.run(100ms);
  }
  EXPECT_EQ(lines_with("component 101 asks to set 'one': refused: "), 1);
  EXPECT_EQ(lines_with("component 101 asks to set 'two': refused: "), 1);
  EXPECT_EQ(lines_with("component 101 asks to append to 'text': refused: "), 1);
  EXPECT_EQ(lines_with("component 101 asks to append to 'absent': refused: there is no such tuple"), 1);
  EXPECT_EQ(counters().refused_sets, 12U);
  for (int i = 0; i < 15; ++i) set_remote("more." + std::to_string(i), c_string("1"));
  world.run(10s);
  EXPECT_EQ(lines_with("asks to set 'more."), 12) << "16 lines a minute";
  EXPECT_EQ(lines_with("more tuples"), 0);
  world.run(1min);
  EXPECT_EQ(lines_with("requests of component 101 for 3 more tuples are refused"), 1);
  set_remote("one", c_string("1"));
  world.run(2min);
  EXPECT_EQ(lines_with("component 101 asks to set 'one': refused: "), 2) << "again after a minute";
  EXPECT_EQ(lines_with("more tuples"), 1);
}

TEST_F(LinkToAKernel, AnAppendToATextOfAKernelEndsWithANulAndOneToBytesDoesNot) {
  const auto all = space->subscribe(*Pattern::parse("101:**"), {}, note());
  world.run(1s);
  push("text", "a", 1);
  auto bytes = tuple(kKernel, "bytes", "\x01");
  bytes.encoding = Encoding::kBinary;
  bytes.media_type = "application/octet-stream";
  bytes.sequence = 1;
  kernel.send(200, Port::kPush, text_of(write_push(bytes)));
  world.run(1s);
  for (const auto* key : {"text", "bytes"}) space->append_remote(kKernel, key, "xy", 5s, nullptr);
  world.run(1s);
  std::vector<std::string> appended;
  for (const auto& message : kernel.messages) {
    if (message.header.port != Port::kSetAppend) continue;
    appended.emplace_back(read_set_append(base::as_bytes(message.body))->difference);
  }
  EXPECT_THAT(appended, ElementsAre(c_string("xy"), "xy"));
}

TEST_F(LinkToAKernel, KernelsSeeTheNameThatTheComponentGivesItself) {
  Summary summary;
  summary.name = "Anna's home@cellar";
  ASSERT_TRUE(space->describe(to_json(summary)));
  subscribe("kernel.name");
  kernel.close();
  kernel.connect(8000);
  world.run(3s);
  std::string name;
  for (const auto& push : pushed()) name = push.data;
  EXPECT_EQ(name, c_string("Anna's_home_cellar"));
  std::string full_name;
  for (const auto& package : kernel.of(Port::kHostInfo)) {
    const auto record = read_host_info(base::as_bytes(package.body))->host;
    if (record.id == kSelf) full_name = record.full_name;
  }
  EXPECT_EQ(full_name, "Anna's_home_cellar@hostx!4711");
}

TEST_F(LinkToAKernel, AKernelOfThisHostThatCameByWayOfAnotherMaySetOnceItsConnectionShowsThat) {
  std::vector<std::string> decided;
  const auto policy = space->add_policy(*Pattern::parse("lamp"), [&](const RemoteSet& set) {
    decided.push_back(set.value);
    return SetDecision::applied();
  });
  KernelPeer young(world, 301, 9003);
  const auto pass = [&](PackageHeader header, ByteView body) {
    header.source = OwnerId{301};
    header.hops = 2;
    kernel.send_raw(header, body);
  };
  young.listen();
  pass(kernel.header(Routing::kBroadcast, Port::kHostInfo), write(HostRecordMessage{young.record(), false}));
  auto header = kernel.header(Routing::kDirect, Port::kSetRemote, 200);
  header.flags = kFlagWantsAck;
  header.ack_id = 101;
  const auto data = c_string("on");
  pass(header, write_set_remote(tuple(kSelf, "lamp", data)));
  world.run(3s);
  EXPECT_THAT(decided, ElementsAre("on"));
}

}  // namespace
}  // namespace rubicon::tuples::peis
