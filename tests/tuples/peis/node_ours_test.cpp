#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/peis/kernel_peer.h"
#include "tuples/peis/node.h"

namespace rubicon::tuples::peis {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::IsEmpty;
using ::testing::Le;
using ::testing::SizeIs;

/// Components of ours on one machine.
class NodesOfOurs : public ::testing::Test {
 protected:
  OwnNode& add(std::uint32_t id) {
    nodes.push_back(std::make_unique<OwnNode>(world, id));
    return *nodes.back();
  }
  bool all_see_all() const {
    for (const auto& node : nodes) {
      if (node->node->hosts().size() != nodes.size() - 1) return false;
    }
    return true;
  }
  bool all_know_hello() const {
    for (const auto& node : nodes) {
      for (const auto& host : node->node->hosts()) {
        if (!host.hello) return false;
      }
    }
    return true;
  }

  PeisWorld world;
  std::vector<std::unique_ptr<OwnNode>> nodes;
};

TEST_F(NodesOfOurs, TwoMeetInAMomentAndSayHelloFirst) {
  auto& one = add(1);
  auto& two = add(2);
  ASSERT_TRUE(one.open());
  ASSERT_TRUE(two.open());
  EXPECT_LE(world.until([&] { return all_see_all(); }, 10s), 500ms);
  world.run(5s);
  EXPECT_THAT(one.events_of(2), ElementsAre(HostEvent::kUp));
  EXPECT_THAT(two.events_of(1), ElementsAre(HostEvent::kUp));
  EXPECT_EQ(one.events[0].host.hello, two.options.hello);
  EXPECT_THAT(one.node->links(), SizeIs(1));
  EXPECT_TRUE(one.node->links()[0].ours);
}

/// Each side closes a connection that is silent for the lease of the other one: both must know.
TEST_F(NodesOfOurs, AHelloThatTookAnotherWayCountsForTheDirectConnection) {
  auto& one = add(1);
  ASSERT_TRUE(one.open());
  KernelPeer direct(world, 102, 9000), way(world, 103, 9001);
  way.connect(one.node->local().port);
  world.run(100ms);
  RoutingPage page;
  page.entries = {{OwnerId{103}, 2, way.magic, 0, 1}, {OwnerId{102}, 1, direct.magic, 1, 1}};
  way.send_raw(way.header(Routing::kLink, Port::kRouting), write(page));
  const auto by_way = [&](Port port, const Bytes& body) {
    auto header = way.header(Routing::kDirect, port, 1);
    header.source = OwnerId{102};
    way.send_raw(header, body);
  };
  by_way(Port::kHostInfo, write(HostRecordMessage{direct.record(), false}));
  by_way(Port::kHello, encode(one.options.hello));
  world.run(100ms);
  direct.connect(one.node->local().port);
  world.run(100ms);
  for (const auto& link : one.node->links()) EXPECT_EQ(link.ours, link.peer == OwnerId{102}) << number(link.peer);
  const auto before = direct.of(Port::kHello).size();
  world.run(1900ms);
  EXPECT_GT(direct.of(Port::kHello).size(), before) << "a sign of life before the lease of 2 s is over";
}

TEST_F(NodesOfOurs, ThirtyStartedTogetherSeeEachOtherWithinEightSeconds) {
  for (std::uint32_t id = 1; id <= 30; ++id) ASSERT_TRUE(add(id).open());
  const auto took = world.until([&] { return all_see_all(); }, 20s);
  EXPECT_LE(took, 8s);
  EXPECT_LE(took, 2s) << "what it takes today";
  world.run(10s);
  EXPECT_TRUE(all_see_all());
  EXPECT_TRUE(all_know_hello());
  for (const auto& node : nodes) {
    for (std::uint32_t id = 1; id <= 30; ++id) {
      if (node->options.id == OwnerId{id}) continue;
      EXPECT_THAT(node->events_of(id), ElementsAre(HostEvent::kUp)) << id;
    }
    EXPECT_EQ(node->node->counters().too_many_links, 0u);
  }
}

TEST_F(NodesOfOurs, OneThatJoinsTwentyNineSeesAllWithinTwoSeconds) {
  for (std::uint32_t id = 1; id <= 29; ++id) ASSERT_TRUE(add(id).open());
  world.run(30s);
  ASSERT_TRUE(all_see_all());
  ASSERT_TRUE(add(30).open());
  EXPECT_LE(world.until([&] { return all_see_all(); }, 20s), 2s);
  world.run(5s);
  EXPECT_TRUE(all_know_hello());
}

TEST_F(NodesOfOurs, OneWithTheLowestIdJoinsAsFast) {
  for (std::uint32_t id = 2; id <= 30; ++id) ASSERT_TRUE(add(id).open());
  world.run(30s);
  ASSERT_TRUE(add(1).open());
  EXPECT_LE(world.until([&] { return all_see_all(); }, 20s), 2s);
}

TEST_F(NodesOfOurs, MessagesBetweenTwoOfManyMakeADirectConnection) {
  for (std::uint32_t id = 1; id <= 5; ++id) ASSERT_TRUE(add(id).open());
  world.run(10s);
  auto& four = *nodes[3];
  auto& five = *nodes[4];
  for (int i = 0; i < 200; ++i) ASSERT_TRUE(four.send(5, std::to_string(i)));
  world.run(2s);
  ASSERT_THAT(five.texts(), SizeIs(200));
  std::vector<std::string> sorted;
  for (int i = 0; i < 200; ++i) sorted.push_back(std::to_string(i));
  EXPECT_EQ(five.texts(), sorted) << "in order";
  const auto routes = four.node->routes();
  const auto to_five = std::find_if(routes.begin(), routes.end(), [](const auto& r) { return r.to == OwnerId{5}; });
  EXPECT_EQ(to_five->metric, 1);
  EXPECT_EQ(to_five->via, OwnerId{5});
}

TEST_F(NodesOfOurs, OneHundredThousandMessagesArriveInOrderThroughTheWideWindow) {
  auto& one = add(1);
  auto& two = add(2);
  ASSERT_TRUE(one.open());
  ASSERT_TRUE(two.open());
  world.run(1s);
  const std::string body(250, 'x');
  int sent = 0, refused = 0;
  const auto start = world.time.now();
  while (sent < 100'000) {
    if (one.node->send(OwnerId{2}, Port::kPush, base::as_bytes(std::to_string(sent) + " " + body))) {
      ++sent;
    } else {
      ++refused;
      world.run(1ms);
    }
  }
  world.run(1s);
  EXPECT_LE(world.time.now() - start, 60s);
  EXPECT_GT(refused, 0);
  EXPECT_THAT(one.ready, SizeIs(Ge(1)));
  ASSERT_EQ(two.messages.size(), 100'000u);
  for (int i = 0; i < 100'000; i += 777)
    EXPECT_TRUE(two.messages[static_cast<std::size_t>(i)].body.starts_with(std::to_string(i) + " "));
  EXPECT_EQ(one.node->counters().resends, 0u);
  EXPECT_EQ(one.node->unacknowledged(OwnerId{2}), 0u);
}

TEST_F(NodesOfOurs, ABrokenConnectionLosesNothingAndKeepsTheOrder) {
  auto& one = add(1);
  auto& two = add(2);
  ASSERT_TRUE(one.open());
  ASSERT_TRUE(two.open());
  world.run(1s);
  std::vector<std::string> sorted;
  for (int i = 0; i < 3000; ++i) {
    sorted.push_back(std::to_string(i));
    ASSERT_TRUE(one.send(2, sorted.back()));
    if (i % 500 == 250) world.net.tcp.cut();
    if (i % 10 == 0) world.run(1ms);
  }
  world.run(5s);
  EXPECT_EQ(two.texts(), sorted);
  EXPECT_THAT(one.events_of(2), AllOf(SizeIs(Ge(2)), ::testing::Not(::testing::Contains(HostEvent::kLost))));
  EXPECT_THAT(one.outcomes, AllOf(SizeIs(3000), Each(Outcome::kDelivered)));
}

TEST_F(NodesOfOurs, OneThatEndsHasLeftAndOneThatIsKilledIsLostWithinItsLease) {
  auto& one = add(1);
  auto& two = add(2);
  auto& three = add(3);
  for (auto* node : {&one, &two, &three}) ASSERT_TRUE(node->open());
  world.run(5s);
  two.node.reset();
  world.run(100ms);
  EXPECT_THAT(one.events_of(2), ElementsAre(HostEvent::kUp, HostEvent::kLeft));
  EXPECT_THAT(three.events_of(2), ElementsAre(HostEvent::kUp, HostEvent::kLeft)) << "also by way of others";

  world.net.tcp.stall(true);  // no byte and no end arrives, as from a host that lost its power
  const auto gone = world.time.now();
  world.run(2500ms);
  EXPECT_THAT(one.events_of(3), ElementsAre(HostEvent::kUp, HostEvent::kLost));
  EXPECT_LE(one.events.back().at - gone, 2500ms);
}

TEST_F(NodesOfOurs, OneThatWasStoppedIsBackAtOnceAndAskedToSubscribeAgain) {
  auto& one = add(1);
  auto& two = add(2);
  ASSERT_TRUE(one.open());
  ASSERT_TRUE(two.open());
  world.run(5s);
  world.net.tcp.stall(true);
  world.run(60s);
  EXPECT_THAT(one.events_of(2), ElementsAre(HostEvent::kUp, HostEvent::kLost));
  world.net.tcp.stall(false);
  EXPECT_LE(world.until([&] { return one.sees(2) && two.sees(1); }, 20s), 1s);
  world.run(2s);
  EXPECT_EQ(one.events_of(2).back(), HostEvent::kForgot);
  EXPECT_EQ(two.events_of(1).back(), HostEvent::kForgot);
}

TEST_F(NodesOfOurs, IdleOnesStayConnectedForAnHourWithFewBytes) {
  auto& one = add(1);
  auto& two = add(2);
  ASSERT_TRUE(one.open());
  ASSERT_TRUE(two.open());
  world.run(1s);
  const auto before = one.node->links()[0].bytes_out;
  world.run(1h);
  EXPECT_THAT(one.events, SizeIs(1));
  EXPECT_THAT(two.events, SizeIs(1));
  EXPECT_LE(one.node->links()[0].bytes_out - before, 3600u * 2 * 40 + 360 * 100) << "a sign of life each half second";
}

TEST_F(NodesOfOurs, AKernelBesideSeesAllAndIsSeenByAll) {
  for (std::uint32_t id = 201; id <= 205; ++id) ASSERT_TRUE(add(id).open());
  KernelPeer kernel(world, 101, 9000);
  kernel.listen();
  kernel.announce();
  const auto so = [&] {
    return std::all_of(nodes.begin(), nodes.end(), [](const auto& node) { return node->sees(101); });
  };
  EXPECT_LE(world.until(so, 30s), 8s);
  world.run(15s);
  for (std::uint32_t id = 201; id <= 205; ++id) {
    EXPECT_TRUE(kernel.routable(id));
    kernel.send(id, Port::kPush, "to " + std::to_string(id));
  }
  world.run(1s);
  for (const auto& node : nodes)
    EXPECT_THAT(node->texts(), ElementsAre("to " + std::to_string(number(node->options.id))));
  EXPECT_THAT(kernel.given_up, IsEmpty());
}

TEST_F(NodesOfOurs, ARestartIsALossAndAnUpWithAnotherIncarnation) {
  auto& one = add(1);
  auto& two = add(2);
  ASSERT_TRUE(one.open());
  ASSERT_TRUE(two.open());
  world.run(1s);
  world.net.tcp.cut();
  two.node.reset();
  two.options.magic += 100;
  two.options.hello.incarnation += 100;
  ASSERT_TRUE(two.open());
  world.run(3s);
  ASSERT_TRUE(one.sees(2));
  EXPECT_EQ(one.node->host(OwnerId{2})->magic, two.options.magic);
  EXPECT_EQ(one.node->host(OwnerId{2})->hello, two.options.hello);
}

TEST_F(NodesOfOurs, LongMessagesPassBothWaysAtOnce) {
  auto& one = add(1);
  auto& two = add(2);
  ASSERT_TRUE(one.open());
  ASSERT_TRUE(two.open());
  world.run(1s);
  const std::string large(6'000'000, 'l');
  ASSERT_TRUE(one.send(2, large));
  ASSERT_TRUE(two.send(1, large));
  EXPECT_EQ(one.send(2, "next").error().code, ErrorCode::kBusy) << "one long message is the whole queue";
  world.run(10s);
  ASSERT_THAT(two.messages, SizeIs(1));
  EXPECT_TRUE(two.messages[0].body == large);
  ASSERT_THAT(one.messages, SizeIs(1));
  EXPECT_THAT(one.outcomes, ElementsAre(Outcome::kDelivered));
  EXPECT_EQ(one.node->send(OwnerId{2}, Port::kPush, Bytes(17 * 1024 * 1024)).error().code, ErrorCode::kOutOfRange);
}

}  // namespace
}  // namespace rubicon::tuples::peis
