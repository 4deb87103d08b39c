#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/collecting_log.h"
#include "tuples/peis/kernel_peer.h"

namespace rubicon::tuples::peis {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A kernel, and a component that speaks in its name.
class NodeForged : public ::testing::Test {
 protected:
  NodeForged() { kernel.listen(); }
  void join(bool multicast = false) {
    own.options.multicast = multicast;
    ASSERT_TRUE(own.open());
    kernel.connect(own.node->local().port);
    forger.connect(own.node->local().port);
    world.run(1s);
    ASSERT_TRUE(own.sees(101));
    ASSERT_TRUE(own.sees(103));
  }
  PackageHeader in_the_name_of(std::uint32_t id, Routing routing, Port port) {
    auto header = forger.header(routing, port, routing == Routing::kDirect ? 200 : kAnyId);
    header.source = OwnerId{id};
    return header;
  }
  /// A record of another start, with addresses that lead to the forger.
  Bytes other_start(const KernelPeer& of, std::uint32_t magic) {
    auto record = of.record();
    record.magic = magic;
    record.addresses[0].port = 9003;
    return write(HostRecordMessage{record, false});
  }
  /// The forger says that a kernel behind the other one is there.
  void show_far(KernelPeer& by, const KernelPeer& far, std::uint32_t magic, std::uint32_t sequence) {
    RoutingPage page;
    page.entries = {{by.record().id, sequence, by.magic, 0, 1}, {far.record().id, sequence, magic, 1, 1}};
    by.send_raw(by.header(Routing::kLink, Port::kRouting), write(page));
    world.run(10ms);
  }
  void meet_far() {
    show_far(kernel, far, far.magic, 3);
    auto answer = kernel.header(Routing::kDirect, Port::kHostInfo, 200);
    answer.source = OwnerId{110};
    kernel.send_raw(answer, write(HostRecordMessage{far.record(), false}));
    world.run(1s);
    ASSERT_TRUE(own.sees(110));
  }
  void announce(const HostRecord& record) { forger.send_datagram(write(Announcement{"default", record})); }
  const NodeCounters& counters() const { return own.node->counters(); }

  PeisWorld world;
  OwnNode own{world, 200};
  KernelPeer kernel{world, 101, 9000}, forger{world, 103, 9003}, far{world, 110, 9010};
};

TEST_F(NodeForged, AHelloInTheNameOfAKernelMakesItNoneOfOurs) {
  join();
  for (int i = 0; i < 100; ++i)
    forger.send_raw(in_the_name_of(101, Routing::kDirect, Port::kHello), encode(own.options.hello));
  world.run(4s);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp));
  EXPECT_FALSE(own.node->host(OwnerId{101})->hello);
  EXPECT_EQ(counters().forged_hellos, 100u);
  for (const auto& link : own.node->links()) EXPECT_FALSE(link.ours);
}

TEST_F(NodeForged, AnotherHelloOfTheSameStartIsRefused) {
  join();
  const auto first = own.options.hello;
  auto second = first;
  second.host_id = "another";
  kernel.send_raw(kernel.header(Routing::kDirect, Port::kHello, 200), encode(first));
  world.run(100ms);
  kernel.send_raw(kernel.header(Routing::kDirect, Port::kHello, 200), encode(second));
  world.run(100ms);
  EXPECT_EQ(own.node->host(OwnerId{101})->hello, first);
  EXPECT_EQ(counters().forged_hellos, 1u);
}

TEST_F(NodeForged, TheHelloOnTheWayOfAHostReplacesOneThatCameAnotherWay) {
  join();
  meet_far();
  auto forged = own.options.hello, real = forged;
  forged.host_id = "forged";
  forger.send_raw(in_the_name_of(110, Routing::kDirect, Port::kHello), encode(forged));
  world.run(100ms);
  auto header = kernel.header(Routing::kDirect, Port::kHello, 200);
  header.source = OwnerId{110};
  kernel.send_raw(header, encode(real));
  world.run(100ms);
  EXPECT_EQ(own.node->host(OwnerId{110})->hello, real);
  forger.send_raw(in_the_name_of(110, Routing::kDirect, Port::kHello), encode(forged));
  world.run(100ms);
  EXPECT_EQ(own.node->host(OwnerId{110})->hello, real);
  EXPECT_EQ(counters().forged_hellos, 1u);
}

TEST_F(NodeForged, ARecordOfAnotherStartOfAFarHostByAnotherWayEndsNothing) {
  join();
  meet_far();
  for (std::uint32_t i = 0; i < 20; ++i) {
    forger.send_raw(in_the_name_of(110, Routing::kBroadcast, Port::kHostInfo), other_start(far, 0x700000 + i));
    show_far(forger, far, 0x700000 + i, 100 + i);
  }
  world.run(1s);
  EXPECT_THAT(own.events_of(110), ElementsAre(HostEvent::kUp));
  EXPECT_EQ(own.node->host(OwnerId{110})->magic, far.magic);
  EXPECT_EQ(counters().other_starts, 20u);
}

TEST_F(NodeForged, ARestartOfAFarHostIsBelievedOnItsWayAndOnAConnection) {
  join();
  meet_far();
  far.magic = 0x777777;
  auto header = kernel.header(Routing::kBroadcast, Port::kHostInfo);
  header.source = OwnerId{110};
  kernel.send_raw(header, write(HostRecordMessage{far.record(), false}));
  world.run(1s);
  EXPECT_THAT(own.events_of(110), ElementsAre(HostEvent::kUp, HostEvent::kLost, HostEvent::kUp));
  world.run(11s);  // a direct connection is tried once in 10 s
  far.listen();
  far.magic = 0x777778;
  forger.send_raw(in_the_name_of(110, Routing::kBroadcast, Port::kHostInfo),
                  write(HostRecordMessage{far.record(), false}));
  world.run(1s);
  EXPECT_THAT(far.greetings, SizeIs(1)) << "it was asked";
  ASSERT_TRUE(own.sees(110));
  EXPECT_EQ(own.node->host(OwnerId{110})->magic, 0x777778u);
}

TEST_F(NodeForged, AnAnnouncedStartDoesNotEndOneWhoseConnectionBreaks) {
  join(true);
  forger.connects = kernel.connects = false;
  forger.announce();
  world.net.tcp.cut();
  auto record = kernel.record();
  for (std::uint32_t i = 0; i < 20; ++i) {
    record.magic = 0x700000 + i;
    announce(record);
  }
  world.run(3s);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kBack));
  EXPECT_GT(counters().other_starts, 0u);
}

TEST_F(NodeForged, AnnouncedAddressesDoNotReplaceThoseOfTheHost) {
  join(true);
  forger.announce();
  auto record = kernel.record();
  record.addresses[0].port = 9999;
  announce(record);
  world.run(100ms);
  world.net.tcp.cut();
  announce(record);
  world.run(1s);
  EXPECT_THAT(kernel.greetings, Contains(::testing::Field(&ConnectMessage::id, OwnerId{200})));
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kBack));
}

TEST_F(NodeForged, AnAnnouncedRestartAtAnotherPortIsConnectedTo) {
  own.options.multicast = true;
  ASSERT_TRUE(own.open());
  kernel.connect(own.node->local().port);
  world.run(1s);
  kernel.stop_listening();
  kernel.close();
  KernelPeer reborn(world, 101, 9001);
  reborn.magic = 0x777777;
  reborn.connects = false;
  reborn.listen();
  reborn.announce();
  world.run(6s);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kLost, HostEvent::kUp));
  EXPECT_EQ(own.events.back().host.magic, 0x777777u);
}

TEST_F(NodeForged, AnAnnouncedStartThatNeverConnectedKeepsNoOtherOut) {
  own.options.multicast = true;
  ASSERT_TRUE(own.open());
  forger.connects = false;
  forger.announce();
  auto record = kernel.record();
  announce(record);
  world.run(1ms);
  record.magic = 0x777777;
  announce(record);
  world.run(1ms);
  kernel.connect(own.node->local().port);
  world.run(1s);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp)) << "its start is not over";
}

TEST_F(NodeForged, OurDeathInTheNameOfAKernelIsIgnored) {
  join();
  const auto dead = write(DeadHost{OwnerId{200}, DeathReason::kReborn});
  forger.send_raw(in_the_name_of(101, Routing::kDirect, Port::kDeadHost), dead);
  forger.send_raw(in_the_name_of(101, Routing::kBroadcast, Port::kDeadHost), dead);
  world.run(1s);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp));
  EXPECT_EQ(counters().forged_deaths, 2u);
}

TEST_F(NodeForged, AHelloThatANeighbourPassesOnFirstIsNotForged) {
  join();
  forger.send_raw(in_the_name_of(101, Routing::kDirect, Port::kHello), encode(own.options.hello));
  world.run(2s);
  kernel.send_raw(kernel.header(Routing::kDirect, Port::kHello, 200), encode(own.options.hello));
  world.run(1500ms);
  EXPECT_TRUE(own.sees(101));
  EXPECT_EQ(counters().forged_hellos, 0u);
}

TEST_F(NodeForged, AGoodbyeThatANeighbourPassesOnFirstIsNotForged) {
  join();
  const auto dead = write(DeadHost{OwnerId{101}, DeathReason::kLost});
  forger.send_raw(in_the_name_of(101, Routing::kBroadcast, Port::kDeadHost), dead);
  world.run(1s);
  EXPECT_TRUE(own.sees(101));
  kernel.send_raw(kernel.header(Routing::kBroadcast, Port::kDeadHost), dead);
  world.run(5s);
  EXPECT_FALSE(own.sees(101));
  forger.send_raw(in_the_name_of(101, Routing::kBroadcast, Port::kDeadHost), dead);
  world.run(5s);
  EXPECT_EQ(counters().forged_deaths, 0u) << "nor is one that comes later";
}

TEST_F(NodeForged, OurDeathIsHeededOnceInTenSeconds) {
  join();
  const auto dead = write(DeadHost{OwnerId{200}, DeathReason::kReborn});
  for (int i = 0; i < 1000; ++i) kernel.send_raw(kernel.header(Routing::kDirect, Port::kDeadHost, 200), dead);
  world.run(1s);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kForgot));
  EXPECT_EQ(counters().held_deaths, 999u);
  for (int i = 0; i < 100; ++i) {
    kernel.send_raw(kernel.header(Routing::kDirect, Port::kDeadHost, 200), dead);
    world.run(80ms);
  }
  EXPECT_THAT(own.events_of(101), SizeIs(2));
  world.run(30s);
  EXPECT_THAT(own.events_of(101), SizeIs(3)) << "those later ones once, at the end of the 10 s";
}

TEST_F(NodeForged, AGoodbyeThatAlsoCameAnotherWayCounts) {
  join();
  const auto dead = write(DeadHost{OwnerId{101}, DeathReason::kLost});
  const auto header = kernel.header(Routing::kBroadcast, Port::kDeadHost);
  forger.send_raw(header, dead);
  world.run(10ms);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp));
  kernel.send_raw(header, dead);
  world.run(10ms);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kLeft));
}

TEST_F(NodeForged, WhoOnlySaysThatItHasOurIdIsAskedAndDoesNotHaveIt) {
  join(true);
  forger.announce();
  auto record = kernel.record();
  record.id = OwnerId{200};
  announce(record);  // another component is there
  record.magic = 0x777777;
  record.addresses[0].port = 9999;
  announce(record);  // none is there
  KernelPeer other(world, 200, 9005);
  other.connect(own.node->local().port);
  world.run(10s);
  EXPECT_THAT(own.taken, IsEmpty());
  EXPECT_EQ(counters().own_id_seen, 4u) << "two announcements, a connection and its record";
  EXPECT_EQ(other.links(), 0u);
  other.listen();
  other.connect(own.node->local().port);
  world.run(10s);
  EXPECT_THAT(own.taken, SizeIs(1));
}

/// Connections that send a connect message and then a byte now and then.
class NodeUnmet : public ::testing::Test {
 protected:
  void connect(transport::MemoryTransports& from, std::uint32_t id) {
    auto stream = std::make_unique<Stream>();
    transport::TcpCallbacks calls;
    calls.connected = [id, one = stream.get()] {
      EXPECT_TRUE(one->tcp->send(write(ConnectMessage{OwnerId{id}, kForcedByCluster, "default"})));
    };
    calls.failed = [one = stream.get()](const Error&) { one->ended = true; };
    stream->tcp = std::move(*from.open_tcp({own.node->local()}, std::move(calls)));
    streams.push_back(std::move(stream));
  }
  struct Stream {
    std::unique_ptr<transport::TcpStream> tcp;
    bool ended = false;
  };

  PeisWorld world;
  OwnNode own{world, 200};
  std::vector<std::unique_ptr<Stream>> streams;
};

TEST_F(NodeUnmet, WhoDoesNotSendItsRecordIsClosedAndKeepsNoOtherOut) {
  own.options.multicast = false;
  ASSERT_TRUE(own.open());
  for (int i = 0; i < 300; ++i) {
    connect(world.machine, 101);
    world.run(1ms);
  }
  EXPECT_EQ(own.node->links().size(), 64u);
  EXPECT_EQ(own.node->counters().too_many_links, 236u);
  for (int i = 0; i < 12; ++i) {
    for (const auto& stream : streams) {
      if (stream->ended) continue;
      EXPECT_TRUE(stream->tcp->send(base::as_bytes("\xff")));
    }
    world.run(500ms);
  }
  EXPECT_THAT(own.node->links(), ::testing::IsEmpty());
  KernelPeer kernel(world, 101, 9000);
  kernel.connect(own.node->local().port);
  world.run(1s);
  EXPECT_TRUE(own.sees(101));
}

TEST_F(NodeUnmet, AHostIsDialedThoughOthersUseItsId) {
  KernelPeer kernel(world, 101, 9000);
  kernel.connects = false;
  kernel.listen();
  ASSERT_TRUE(own.open());
  connect(world.machine, 101);
  kernel.announce();
  EXPECT_LT(world.until(
                [&] {
                  connect(world.machine, 101);
                  return own.sees(101);
                },
                10s),
            5s);
}

TEST_F(NodeUnmet, AnotherHostHasFewOfThem) {
  own.options.multicast = false;
  ASSERT_TRUE(own.open());
  transport::MemoryTransports elsewhere;
  elsewhere.join(world.net, "10.0.0.2");
  for (std::uint32_t i = 0; i < 50; ++i) connect(elsewhere, 1000 + i);
  world.run(100ms);
  EXPECT_EQ(own.node->links().size(), 8u);
}

}  // namespace
}  // namespace rubicon::tuples::peis
