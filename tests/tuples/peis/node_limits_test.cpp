#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/peis/kernel_peer.h"

namespace rubicon::tuples::peis {
namespace {

using ::testing::AllOf;
using ::testing::Ge;
using ::testing::Le;
using ::testing::SizeIs;

/// What hostile or broken neighbours can make a node do.
class NodeLimits : public ::testing::Test {
 protected:
  NodeLimits() {
    own.options.multicast = false;
    kernel.listen();
  }
  void announce(std::uint32_t id) {
    auto record = kernel.record();
    record.id = OwnerId{id};
    record.addresses.at(0).port = 7777;
    kernel.send_datagram(write(Announcement{"default", record}));
  }
  const NodeCounters& counters() const { return own.node->counters(); }

  PeisWorld world;
  OwnNode own{world, 200};
  KernelPeer kernel{world, 101, 9000};
};

TEST_F(NodeLimits, AConfiguredHostThatClosesEachConnectionIsTriedWithPauses) {
  kernel.resets_always = true;
  own.options.connect = {"127.0.0.1:9000"};
  ASSERT_TRUE(own.open());
  world.run(60s);
  EXPECT_THAT(kernel.greetings, SizeIs(AllOf(Ge(4), Le(12))));
  kernel.resets_always = false;
  EXPECT_LE(world.until([&] { return kernel.links() == 1; }, 30s), 11s);
  world.run(20s);
  EXPECT_EQ(kernel.links(), 1u);
}

TEST_F(NodeLimits, AHostThatClosesEachConnectionIsConnectedToAgainWithPauses) {
  kernel.resets_always = true;
  ASSERT_TRUE(own.open());
  kernel.connect(own.node->local().port);
  world.run(60s);
  EXPECT_THAT(kernel.greetings, SizeIs(AllOf(Ge(1), Le(12))));
}

TEST_F(NodeLimits, ConfiguredHostsWithoutAnAnswerKeepNoOtherHostOut) {
  world.net.names_answer = false;
  for (int i = 0; i < 8; ++i) own.options.connect.push_back("host" + std::to_string(i));
  own.options.multicast = true;
  kernel.connects = false;
  kernel.announce();
  ASSERT_TRUE(own.open());
  EXPECT_LE(world.until([&] { return own.sees(101); }, 30s), 5s);
}

TEST_F(NodeLimits, AFloodOfAnnouncementsDoesNotKeepABrokenConnectionOut) {
  own.options.multicast = true;
  kernel.announce();
  KernelPeer known(world, 90'000, 9001);
  known.listen();
  ASSERT_TRUE(own.open());
  known.connect(own.node->local().port);
  world.run(10s);
  ASSERT_TRUE(own.sees(90'000));
  world.net.tcp.answers = false;
  for (std::uint32_t i = 0; i < 1100; ++i) announce(1000 + i);
  world.run(2500ms);
  world.net.tcp.answers = true;
  known.close();
  EXPECT_LE(world.until([&] { return known.links() == 1; }, 30s), 500ms);
  for (std::uint32_t i = 0; i < 1100; ++i) announce(10'000 + i);
  world.run(100ms);
  EXPECT_GT(counters().untried_hosts, 0u);
}

TEST_F(NodeLimits, AnotherStartOfAHostIsConnectedToWithoutThePausesOfTheFormerOne) {
  own.options.multicast = true;
  kernel.connects = false;
  kernel.announce();
  ASSERT_TRUE(own.open());
  announce(150);
  world.run(30s);
  KernelPeer again(world, 150, 9002);
  again.listen();
  auto record = again.record();
  record.magic += 1;
  again.magic += 1;
  kernel.send_datagram(write(Announcement{"default", record}));
  EXPECT_LE(world.until([&] { return again.links() == 1; }, 30s), 3200ms);
}

TEST_F(NodeLimits, BroadcastsOfOneConnectionArePassedOnUpToALimit) {
  ASSERT_TRUE(own.open());
  KernelPeer other(world, 102, 9001);
  kernel.connect(own.node->local().port);
  other.connect(own.node->local().port);
  world.run(10500ms);
  other.received.clear();
  const auto body = write(HostRecordMessage{kernel.record(), true});
  for (int i = 0; i < 1500; ++i) {
    kernel.send_raw(kernel.header(Routing::kBroadcast, Port::kHostInfo), body);
    if (i % 100 == 99) world.run(20ms);
  }
  EXPECT_THAT(other.of(Port::kHostInfo), SizeIs(AllOf(Ge(300), Le(1000))));
  EXPECT_GT(counters().held_broadcasts, 300u);
  world.run(2s);
  const auto before = other.of(Port::kHostInfo).size();
  kernel.send_raw(kernel.header(Routing::kBroadcast, Port::kHostInfo), body);
  world.run(100ms);
  EXPECT_THAT(other.of(Port::kHostInfo), SizeIs(before + 1));
}

TEST_F(NodeLimits, ANeighbourWhoseRoutesFlapDoesNotMakeOursGoOutEachTime) {
  ASSERT_TRUE(own.open());
  KernelPeer other(world, 102, 9001);
  kernel.sends_routing = false;
  kernel.connect(own.node->local().port);
  other.connect(own.node->local().port);
  world.run(1s);
  other.received.clear();
  for (std::uint32_t i = 0; i < 300; ++i) {
    RoutingPage page;
    page.pages = 1;
    page.sequence = i;
    page.entries.push_back({OwnerId{101}, i, kernel.magic, 0, 1});
    if (i % 2 == 0) page.entries.push_back({OwnerId{1000}, i, 7, 1, 1});
    kernel.send_raw(kernel.header(Routing::kLink, Port::kRouting), write(page));
    world.run(100ms);
  }
  EXPECT_THAT(other.of(Port::kRouting), SizeIs(AllOf(Ge(50), Le(180))));
}

TEST_F(NodeLimits, WhatIsDroppedIsNamedInTheLog) {
  ASSERT_TRUE(own.open());
  kernel.connect(own.node->local().port);
  world.run(1s);
  auto far = kernel.header(Routing::kDirect, Port::kPush, 777);
  kernel.send_raw(far, {});
  auto high = kernel.header(Routing::kDirect, Port::kPush, 200);
  high.port = Port{50};
  kernel.send_raw(high, {});
  kernel.send_raw(high, {});
  world.run(100ms);
  EXPECT_EQ(counters().no_route, 1u);
  EXPECT_EQ(counters().high_ports, 2u);
  EXPECT_TRUE(world.sink.contains("package of component 101 by way of 101 dropped: no route"));
  EXPECT_TRUE(world.sink.contains("package of component 101 by way of 101 dropped: a port above 49"));
}

}  // namespace
}  // namespace rubicon::tuples::peis
