#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <set>

#include "tuples/peis/kernel_peer.h"

namespace rubicon::tuples::peis {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// Two kernels that know only our node.
class NodeForward : public ::testing::Test {
 protected:
  NodeForward() {
    own.options.multicast = false;
    EXPECT_TRUE(own.open());
    one.connect(own.node->local().port);
    other.connect(own.node->local().port);
    world.run(1s);
  }
  const NodeCounters& counters() const { return own.node->counters(); }

  PeisWorld world;
  OwnNode own{world, 102};
  KernelPeer one{world, 101, 9001}, other{world, 103, 9003};
};

TEST_F(NodeForward, EachLearnsOfTheOtherAtOnceByTriggeredRoutingAndItsRecord) {
  EXPECT_TRUE(one.routable(103)) << "and its record by broadcast";
  EXPECT_TRUE(other.routable(101)) << "kernels among themselves need 10 s";
  std::vector<OwnerId> records;
  for (const auto& package : one.of(Port::kHostInfo))
    records.push_back(read_host_info(base::as_bytes(package.body))->host.id);
  EXPECT_THAT(records, Contains(OwnerId{103}));
}

TEST_F(NodeForward, MessagesPassWithOneMoreHopAndTheirAcks) {
  one.send(103, Port::kSetRemote, "go");
  world.run(300ms);
  ASSERT_THAT(other.texts(), ElementsAre("go"));
  EXPECT_EQ(other.messages.back().header.hops, 2);
  EXPECT_EQ(other.messages.back().header.source, OwnerId{101});
  ASSERT_THAT(one.of(Port::kAcks), SizeIs(1));
  EXPECT_EQ(one.of(Port::kAcks).back().header.hops, 2);
  world.run(15s);
  EXPECT_THAT(one.given_up, IsEmpty());
  EXPECT_THAT(own.messages, IsEmpty()) << "it was not for us";
}

TEST_F(NodeForward, AKernelBehindUsThatComesBackIsMadeToForgetAlsoIfAPackageGetsLost) {
  OwnNode far(world, 200);
  far.options.multicast = false;
  far.options.connect = {transport::to_string(own.node->local())};
  ASSERT_TRUE(far.open());
  world.run(3s);
  ASSERT_TRUE(far.sees(101));
  own.node.reset();
  world.run(30s);
  ASSERT_FALSE(far.sees(101));
  one.lost_deaths = 1;
  ++own.options.magic;
  ASSERT_TRUE(own.open());
  one.connect(own.node->local().port);
  one.received.clear();
  world.run(20s);
  EXPECT_TRUE(far.sees(101));
  std::set<std::uint32_t> deaths;  // acknowledged only when the kernel has a route again
  for (const auto& package : one.of(Port::kDeadHost)) {
    deaths.insert(package.header.ack_id);
    EXPECT_EQ(*read_dead_host(base::as_bytes(package.body)), (DeadHost{OwnerId{200}, DeathReason::kLost}));
  }
  EXPECT_THAT(deaths, SizeIs(1));
}

TEST_F(NodeForward, WithLossInEachLinkAllArrives) {
  one.loss = other.loss = 0.05;
  for (int i = 0; i < 100; ++i) one.send(103, Port::kPush, std::to_string(i));
  world.run(20s);
  EXPECT_THAT(other.texts(), SizeIs(100));
  EXPECT_THAT(one.given_up, IsEmpty());
}

TEST_F(NodeForward, BroadcastsPassOnceAndDuplicatesEnd) {
  auto header = one.header(Routing::kBroadcast, Port::kUnsubscribe);
  for (int i = 0; i < 5; ++i) one.send_raw(header, base::as_bytes("all"));
  world.run(100ms);
  EXPECT_THAT(other.texts(), ElementsAre("all"));
  EXPECT_THAT(own.texts(), ElementsAre("all"));
  EXPECT_EQ(counters().duplicates, 4u);
  EXPECT_EQ(other.messages.back().header.hops, 2);
  ASSERT_TRUE(own.node->broadcast(Port::kUnsubscribe, base::as_bytes("ours")));
  world.run(100ms);
  EXPECT_THAT(one.texts(), ElementsAre("ours"));
}

TEST_F(NodeForward, PackagesAtTheHopLimitAndLoopsEnd) {
  auto header = one.header(Routing::kDirect, Port::kPush, 103);
  header.hops = kMaxHops;
  one.send_raw(header, base::as_bytes("too far"));
  auto broadcast = one.header(Routing::kBroadcast, Port::kPush);
  broadcast.hops = kMaxHops;
  one.send_raw(broadcast, base::as_bytes("too far too"));
  auto back = one.header(Routing::kDirect, Port::kPush, 101);
  back.source = OwnerId{103};
  one.send_raw(back, base::as_bytes("to itself"));
  auto unknown = one.header(Routing::kDirect, Port::kPush, 999);
  one.send_raw(unknown, base::as_bytes("to none"));
  world.run(1s);
  EXPECT_THAT(other.texts(), IsEmpty());
  EXPECT_THAT(one.texts(), IsEmpty());
  EXPECT_EQ(counters().hop_limit, 2u);
  EXPECT_EQ(counters().loops, 1u);
  EXPECT_EQ(counters().no_route, 1u);
}

TEST_F(NodeForward, PortsThatKillKernelsAndIdsOfNoneAreNotPassedOn) {
  for (const auto port : std::to_array<std::uint16_t>({50, 51, 100, 32767})) {
    one.send_raw(one.header(Routing::kDirect, Port{port}, 103), base::as_bytes("death"));
    one.send_raw(one.header(Routing::kBroadcast, Port{port}), base::as_bytes("death"));
  }
  auto no_source = one.header(Routing::kBroadcast, Port::kPush);
  no_source.source = OwnerId{0};
  one.send_raw(no_source, base::as_bytes("0"));
  one.send_raw(one.header(Routing::kDirect, Port::kPush, 0), base::as_bytes("0"));
  world.run(1s);
  EXPECT_THAT(other.texts(), IsEmpty());
  EXPECT_EQ(counters().high_ports, 8u);
  EXPECT_EQ(counters().bad_ids, 2u);
  EXPECT_EQ(own.node->broadcast(Port{50}, {}).error().code, ErrorCode::kOutOfRange);
  EXPECT_EQ(own.send(101, "x", Port{50}).error().code, ErrorCode::kOutOfRange);
  one.send_raw(one.header(Routing::kDirect, Port{49}, 103), base::as_bytes("ours"));
  world.run(1s);
  EXPECT_THAT(other.texts(), ElementsAre("ours")) << "up to 49 all pass";
}

TEST_F(NodeForward, AHostThatEndsIsWithdrawnFromTheOthersAtOnce) {
  one.leave();
  world.run(500ms);
  EXPECT_FALSE(other.routable(101));
  EXPECT_THAT(other.of(Port::kDeadHost), SizeIs(1)) << "its own goodbye, passed on";
}

TEST_F(NodeForward, ARouteThatAKernelStillAdvertisesDoesNotLeadInCircles) {
  one.close();
  world.run(500ms);
  RoutingPage page;
  page.entries = {{OwnerId{103}, 5, other.magic, 0, 1}, {OwnerId{101}, 0, one.magic, 2, 1}};
  other.send_raw(other.header(Routing::kLink, Port::kRouting), write(page));
  world.run(500ms);
  for (const auto& route : own.node->routes()) EXPECT_NE(route.to, OwnerId{101}) << "an old sequence";
  page.entries[1].sequence = 50;
  other.send_raw(other.header(Routing::kLink, Port::kRouting), write(page));
  world.run(500ms);
  EXPECT_THAT(own.node->routes(), SizeIs(2)) << "a newer one counts";
}

TEST_F(NodeForward, AHostFarAwayIsAskedForItsRecordAndGreeted) {
  KernelPeer far(world, 110, 9010);
  far.listen();
  RoutingPage page;
  page.entries = {{OwnerId{103}, 5, other.magic, 0, 1}, {OwnerId{110}, 3, far.magic, 1, 1}};
  other.send_raw(other.header(Routing::kLink, Port::kRouting), write(page));
  world.run(100ms);
  ASSERT_THAT(other.of(Port::kQueryHost), SizeIs(1));
  const auto query = other.of(Port::kQueryHost)[0];
  EXPECT_EQ(query.header.destination, OwnerId{110});
  EXPECT_EQ(read_query_host(base::as_bytes(query.body))->magic, kAnyId) << "the only one that is answered";
  EXPECT_FALSE(own.sees(110));
  auto answer = other.header(Routing::kDirect, Port::kHostInfo, 102);
  answer.source = OwnerId{110};
  answer.hops = 2;
  other.send_raw(answer, write(HostRecordMessage{far.record(), false}));
  world.run(1s);
  ASSERT_TRUE(own.sees(110));
  ASSERT_TRUE(own.send(110, "hi"));
  world.run(1s);
  EXPECT_THAT(far.greetings, SizeIs(1)) << "and messages make a connection";
  EXPECT_THAT(far.texts(), ElementsAre("hi"));
}

}  // namespace
}  // namespace rubicon::tuples::peis
