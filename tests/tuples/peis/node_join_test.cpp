#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/peis/kernel_peer.h"

namespace rubicon::tuples::peis {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::IsEmpty;
using ::testing::Le;
using ::testing::SizeIs;

class NodeJoin : public ::testing::Test {
 protected:
  NodeJoin() { kernel.listen(); }
  void open(bool multicast = false) {
    own.options.multicast = multicast;
    ASSERT_TRUE(own.open());
  }
  void connect_kernel() {
    kernel.connect(own.node->local().port);
    world.run(600ms);
    ASSERT_TRUE(own.sees(101));
  }

  PeisWorld world;
  OwnNode own{world, 200};
  KernelPeer kernel{world, 101, 9000};
};

TEST_F(NodeJoin, AKernelThatConnectsGetsWhatKernelsSendAndIsUp) {
  open();
  connect_kernel();
  ASSERT_THAT(kernel.received, SizeIs(Ge(3)));
  EXPECT_EQ(kernel.received[0].header.port, Port::kHostInfo);
  EXPECT_EQ(kernel.received[0].header.routing, Routing::kLink);
  EXPECT_EQ(kernel.received[1].header.port, Port::kRouting);
  EXPECT_EQ(kernel.received[2].header.port, Port::kHostInfo);
  EXPECT_EQ(kernel.received[2].header.routing, Routing::kBroadcast);
  const auto record = read_host_info(base::as_bytes(kernel.received[0].body))->host;
  EXPECT_EQ(record.magic, own.options.magic);
  EXPECT_EQ(record.full_name, "ours@hostx!200");
  ASSERT_THAT(record.addresses, SizeIs(1));
  EXPECT_EQ(record.addresses[0].port, own.node->local().port);
  EXPECT_TRUE(kernel.routable(200));
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp));
  EXPECT_EQ(own.events[0].host.magic, kernel.magic);
  EXPECT_EQ(own.events[0].host.full_name, "kernel@hostx!1");
  EXPECT_FALSE(own.events[0].host.hello);
}

TEST_F(NodeJoin, HelloIsTheFirstDirectPackageAndNothingElseWithoutNeed) {
  open();
  connect_kernel();
  world.run(5s);
  std::vector<Port> direct;
  for (const auto& package : kernel.received) {
    if (package.header.routing == Routing::kDirect) direct.push_back(package.header.port);
  }
  EXPECT_THAT(direct, ElementsAre(Port::kHello));
}

TEST_F(NodeJoin, AnAnnouncedKernelIsConnectedToByForceOfItsCluster) {
  kernel.connects = false;
  kernel.announce();
  open(true);
  const auto took = world.until([&] { return own.sees(101); }, 10s);
  EXPECT_LE(took, 4s);
  ASSERT_THAT(kernel.greetings, SizeIs(1));
  EXPECT_EQ(kernel.greetings[0], (ConnectMessage{OwnerId{200}, kForcedByCluster, "default"}));
}

TEST_F(NodeJoin, AComponentWhoseHelloComesLateIsAskedToSendAllAgain) {
  kernel.announce();
  open(true);
  world.until([&] { return own.sees(101); }, 10s);
  world.run(5s);
  ASSERT_THAT(kernel.of(Port::kDeadHost), testing::IsEmpty());
  kernel.send(200, Port::kHello, std::string(base::as_text(encode(Hello{1, 2s, 1234, "host"}))));
  world.run(1s);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kHello));
  EXPECT_THAT(std::count_if(kernel.received.begin(), kernel.received.end(),
                            [](const auto& package) {
                              return package.header.port == Port::kDeadHost &&
                                     package.header.routing == Routing::kDirect;
                            }),
              1);
}

TEST_F(NodeJoin, AKernelHearsOurAnnouncementAtOnceAndConnects) {
  kernel.announce();
  open(true);
  EXPECT_LE(world.until([&] { return own.sees(101); }, 10s), 3s) << "its own turn is each 2 s";
  EXPECT_TRUE(kernel.routable(200));
}

TEST_F(NodeJoin, OnlyTheLowestIdOfAHostAnnounces) {
  open(true);
  OwnNode lower(world, 50);
  ASSERT_TRUE(lower.open());
  world.run(5s);
  const auto before = world.net.sent().size();
  world.run(10s);
  std::set<std::uint32_t> senders;
  for (auto i = before; i < world.net.sent().size(); ++i)
    senders.insert(number(read_announcement(world.net.sent()[i].bytes)->host.id));
  EXPECT_THAT(senders, ElementsAre(50));
  EXPECT_THAT(world.net.sent().size() - before, AllOf(Ge(9), Le(11)));
  lower.node.reset();
  world.run(5s);
  EXPECT_EQ(number(read_announcement(world.net.sent().back().bytes)->host.id), 200u) << "takes over after 3 s";
}

TEST_F(NodeJoin, AnIdThatKernelsWarnOfLeavesAnnouncingToTheOthersOfItsHost) {
  open(true);
  OwnNode lower(world, 50), tool(world, 70000);
  ASSERT_TRUE(lower.open());
  ASSERT_TRUE(tool.open());
  world.run(5s);
  lower.node.reset();
  const auto before = world.net.sent().size();
  world.run(20s);
  std::set<std::uint32_t> senders;
  for (auto i = before; i < world.net.sent().size(); ++i)
    senders.insert(number(read_announcement(world.net.sent()[i].bytes)->host.id));
  EXPECT_THAT(senders, ElementsAre(200));
}

TEST_F(NodeJoin, ANewComponentIsConnectedToSoonThoughAKernelAnnouncesForItsHost) {
  kernel.announce();
  open(true);
  world.run(8s);
  ASSERT_TRUE(own.sees(101));
  OwnNode tool(world, 70000);
  ASSERT_TRUE(tool.open());
  EXPECT_LE(world.until([&] { return tool.sees(200) && own.sees(70000); }, 20s), 1600ms);
  EXPECT_THAT(tool.events_of(200), ElementsAre(HostEvent::kUp)) << "with its hello, not as a kernel before";
}

TEST_F(NodeJoin, AConfiguredKernelIsConnectedToAndAgainAfterABreak) {
  own.options.connect = {"127.0.0.1:9000"};
  open();
  world.run(1s);
  ASSERT_TRUE(own.sees(101));
  ASSERT_THAT(kernel.greetings, SizeIs(1));
  EXPECT_EQ(kernel.greetings[0].flags, kForceBroadcasts | kForcedByCluster);
  kernel.close();
  world.run(1s);
  EXPECT_THAT(kernel.greetings, SizeIs(2));
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kBack));
}

TEST_F(NodeJoin, AConfiguredKernelThatIsNotThereIsTriedAgainWithPauses) {
  own.options.connect = {"127.0.0.1:9001"};
  open();
  world.run(60s);
  KernelPeer late(world, 102, 9001);
  late.listen();
  EXPECT_LE(world.until([&] { return own.sees(102); }, 60s), 11s);
}

TEST_F(NodeJoin, RoutingGoesOutEachTenSecondsAndListsWhatIsKnown) {
  open();
  connect_kernel();
  world.run(60s);
  const auto pages = kernel.of(Port::kRouting);
  EXPECT_THAT(pages, SizeIs(AllOf(Ge(7), Le(9))));
  const auto last = *read_routing_page(base::as_bytes(pages.back().body));
  const auto before = *read_routing_page(base::as_bytes(pages[pages.size() - 2].body));
  EXPECT_EQ(pages.back().at - pages[pages.size() - 2].at, 10s);
  EXPECT_EQ(last.sequence, before.sequence + 1);
  EXPECT_EQ(last.entries[0], (RouteEntry{OwnerId{200}, last.sequence, own.options.magic, 0, 1}));
  EXPECT_EQ(last.entries[1].id, OwnerId{101});
  EXPECT_EQ(last.entries[1].hops, 1) << "same host name";
}

TEST_F(NodeJoin, AKernelOfAnotherHostNameCostsTwoAndItsLoopbackIsNotUsed) {
  kernel.host_name = "elsewhere";
  kernel.connects = false;
  kernel.announce();
  open(true);
  world.run(10s);
  EXPECT_THAT(kernel.greetings, IsEmpty()) << "loopback addresses of other hosts lead nowhere";
  connect_kernel();
  ASSERT_THAT(own.node->routes(), SizeIs(1));
  EXPECT_EQ(own.node->routes()[0].metric, 2);
}

TEST_F(NodeJoin, MessagesGoBothWaysAndAreAcknowledgedWithinAFifthOfASecond) {
  open();
  connect_kernel();
  ASSERT_TRUE(own.send(101, "21.5"));
  kernel.send(200, Port::kSubscribe, "pattern");
  world.run(250ms);
  EXPECT_THAT(kernel.texts(), ElementsAre("21.5"));
  EXPECT_THAT(own.texts(), ElementsAre("pattern"));
  EXPECT_EQ(own.messages[0].port, Port::kSubscribe);
  EXPECT_THAT(own.outcomes, ElementsAre(Outcome::kDelivered));
  EXPECT_THAT(kernel.of(Port::kAcks), SizeIs(1));
  EXPECT_EQ(own.node->counters().resends, 0u);
}

TEST_F(NodeJoin, ASubscribeBeforeTheTimeForHelloIsOverIsNotLost) {
  open();
  kernel.connect(own.node->local().port);
  world.run(5ms);
  kernel.send(200, Port::kSubscribe, "early");
  world.run(5ms);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp));
  EXPECT_THAT(own.texts(), ElementsAre("early"));
}

TEST_F(NodeJoin, AQueryIsAnsweredWithTheRecordAndATraceWithThePath) {
  open();
  connect_kernel();
  kernel.send_raw(kernel.header(Routing::kDirect, Port::kQueryHost, 200), write(QueryHost{OwnerId{101}, kAnyId}));
  kernel.send_raw(kernel.header(Routing::kDirect, Port::kTrace, 200), write(Trace{{OwnerId{101}}}));
  world.run(100ms);
  EXPECT_EQ(read_host_info(base::as_bytes(kernel.of(Port::kHostInfo).back().body))->host.id, OwnerId{200});
  ASSERT_THAT(kernel.of(Port::kTraceReply), SizeIs(1));
  EXPECT_THAT(read_trace(base::as_bytes(kernel.of(Port::kTraceReply)[0].body))->path,
              ElementsAre(OwnerId{101}, OwnerId{200}));
}

TEST_F(NodeJoin, AnEndIsDeclaredSoThatKernelsForgetAtOnce) {
  open();
  connect_kernel();
  own.node.reset();
  world.run(10ms);
  ASSERT_THAT(kernel.of(Port::kDeadHost), SizeIs(1));
  EXPECT_EQ(*read_dead_host(base::as_bytes(kernel.of(Port::kDeadHost)[0].body)),
            (DeadHost{OwnerId{200}, DeathReason::kLost}));
  EXPECT_EQ(kernel.links(), 0u);
}

TEST_F(NodeJoin, AKernelThatDeclaresItselfDeadHasLeftAndIsNotTakenBackWhileItStillTalks) {
  open();
  connect_kernel();
  kernel.leave();
  world.run(10ms);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kLeft));
  EXPECT_FALSE(own.send(101, "x"));
  kernel.connect(own.node->local().port);  // kernels talk on for 2 s
  world.run(2s);
  EXPECT_THAT(own.events_of(101), SizeIs(2));
}

TEST_F(NodeJoin, AKernelThatLeftAndCameBackMayForgetUsAtOnce) {
  const auto forgets = [this] {
    kernel.send_raw(kernel.header(Routing::kDirect, Port::kDeadHost, 200),
                    write(DeadHost{OwnerId{200}, DeathReason::kReborn}));
    world.run(100ms);
  };
  open();
  connect_kernel();
  forgets();
  kernel.leave();
  world.run(4s);
  connect_kernel();
  forgets();
  EXPECT_THAT(own.events_of(101),
              ElementsAre(HostEvent::kUp, HostEvent::kForgot, HostEvent::kLeft, HostEvent::kUp, HostEvent::kForgot));
  EXPECT_EQ(own.node->counters().held_deaths, 0u) << "what was kept of it went with it";
}

TEST_F(NodeJoin, ATakenPortIsPassedOver) {
  KernelPeer first(world, 1, 8000), second(world, 2, 8001);
  first.listen();
  second.listen();
  open();
  EXPECT_EQ(own.node->local().port, 8002);
  OwnNode any(world, 201);
  any.options.first_port = 0;
  any.options.multicast = false;
  ASSERT_TRUE(any.open());
  EXPECT_GT(any.node->local().port, 8002);
}

TEST_F(NodeJoin, OptionsOutOfRangeAreRefused) {
  const auto refuses = [&](auto change) {
    OwnNode node(world, 200);
    change(node.options);
    const auto opened = node.open();
    return !opened && opened.error().code == ErrorCode::kInvalid;
  };
  EXPECT_TRUE(refuses([](NodeOptions& o) { o.id = OwnerId{0}; })) << "kernels do not acknowledge to 0";
  EXPECT_TRUE(refuses([](NodeOptions& o) { o.id = OwnerId{0x80000000}; }));
  EXPECT_TRUE(refuses([](NodeOptions& o) { o.magic = 0; }));
  EXPECT_TRUE(refuses([](NodeOptions& o) { o.network.assign(64, 'n'); }));
  EXPECT_TRUE(refuses([](NodeOptions& o) { o.host_name.clear(); }));
  EXPECT_TRUE(refuses([](NodeOptions& o) { o.interfaces.clear(); }));
  EXPECT_TRUE(refuses([](NodeOptions& o) { o.connect = {"127.0.0.1:0"}; }));
}

}  // namespace
}  // namespace rubicon::tuples::peis
