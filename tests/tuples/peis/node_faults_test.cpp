#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/peis/kernel_peer.h"
#include "tuples/peis/routes.h"

namespace rubicon::tuples::peis {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::IsEmpty;
using ::testing::Le;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAreArray;

class NodeFaults : public ::testing::Test {
 protected:
  NodeFaults() {
    own.options.multicast = false;
    kernel.listen();
  }
  void join() {
    ASSERT_TRUE(own.open());
    kernel.connect(own.node->local().port);
    world.until([&] { return own.sees(101); }, 60s);
    ASSERT_TRUE(own.sees(101));
  }
  const NodeCounters& counters() const { return own.node->counters(); }
  std::vector<Duration> times_of(const std::string& body) const {
    std::vector<Duration> times;
    for (const auto& package : kernel.received) {
      if (package.body == body) times.push_back(package.at - sent_at);
    }
    return times;
  }

  PeisWorld world;
  OwnNode own{world, 200};
  KernelPeer kernel{world, 101, 9000};
  SteadyTime sent_at{};
};

TEST_F(NodeFaults, WithEachFifthPackageLostAllMessagesArriveOnce) {
  join();
  kernel.loss = 0.2;
  std::vector<std::string> texts;
  for (int i = 0; i < 300; ++i) {
    texts.push_back(std::to_string(i));
    ASSERT_TRUE(own.send(101, texts.back()));
    kernel.send(200, Port::kPush, texts.back());
  }
  world.run(20s);
  EXPECT_THAT(kernel.texts(), UnorderedElementsAreArray(texts));
  EXPECT_THAT(own.texts(), UnorderedElementsAreArray(texts));
  EXPECT_THAT(own.outcomes, AllOf(SizeIs(300), Each(Outcome::kDelivered)));
  EXPECT_GT(counters().resends, 50u);
  EXPECT_GT(counters().duplicates, 20u);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp));
}

TEST_F(NodeFaults, ALongMessageArrivesWholeInSpiteOfLoss) {
  join();
  kernel.loss = 0.1;
  ASSERT_TRUE(own.send(101, std::string(60'000, 'x')));
  world.run(20s);
  EXPECT_THAT(own.outcomes, ElementsAre(Outcome::kDelivered));
  std::set<std::uint16_t> indexes;
  for (const auto& part : kernel.messages) {
    if (part.header.fragments > 0) indexes.insert(part.header.fragment);
  }
  EXPECT_THAT(indexes, SizeIs(59)) << "60,000 bytes in packages of 1024";
}

TEST_F(NodeFaults, AHostThatAcknowledgesNothingGetsEightCopiesAtTheTimesOfKernels) {
  join();
  kernel.acknowledges = false;
  sent_at = world.time.now();
  ASSERT_TRUE(own.send(101, "value"));
  world.run(60s);
  const auto times = times_of("value");
  ASSERT_THAT(times, SizeIs(8));
  const std::vector<Duration> expected{0ms, 400ms, 800ms, 1600ms, 2800ms, 4400ms, 6400ms, 8800ms};
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_GE(times[i], expected[i]);
    EXPECT_LE(times[i], expected[i] + 100ms);
  }
  EXPECT_THAT(own.outcomes, ElementsAre(Outcome::kGivenUp));
  EXPECT_EQ(counters().given_up, 1u);
  EXPECT_TRUE(own.sees(101)) << "it still speaks";
}

TEST_F(NodeFaults, AHostThatAcknowledgesNothingHoldsOneWindowAndThenSendersWait) {
  join();
  kernel.acknowledges = false;
  const std::string body(200, 'x');
  int taken = 0;
  Result<void> sent;
  while (taken < 5000 && (sent = own.send(101, body))) ++taken;
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().code, ErrorCode::kBusy);
  EXPECT_THAT(taken, AllOf(Ge(128), Le(128 + 65536 / 200 + 1)));
  world.run(300ms);
  EXPECT_EQ(kernel.texts().size(), 128u);
  EXPECT_THAT(own.ready, IsEmpty());
  kernel.acknowledges = true;
  world.run(20s);
  EXPECT_THAT(own.ready, ElementsAre(OwnerId{101}));
  EXPECT_EQ(own.node->unacknowledged(OwnerId{101}), 0u);
}

TEST_F(NodeFaults, ARestartWithANewMagicIsALossAndANewHost) {
  join();
  ASSERT_TRUE(own.send(101, "never acknowledged"));
  auto before = kernel.magic;
  kernel.close();
  kernel.magic = 0x777777;
  kernel.connect(own.node->local().port);
  world.run(2s);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kLost, HostEvent::kUp));
  EXPECT_EQ(own.events[1].host.magic, before);
  EXPECT_EQ(own.events[2].host.magic, 0x777777u);
  EXPECT_THAT(own.outcomes, ElementsAre(Outcome::kHostGone));
  ASSERT_TRUE(own.send(101, "after"));
  world.run(1s);
  EXPECT_THAT(kernel.texts(), ::testing::Contains("after"));
}

TEST_F(NodeFaults, ARestartIsNoticedWhileTheOldConnectionSeemsOpen) {
  kernel.notices_fin = false;
  join();
  KernelPeer reborn(world, 101, 9001);
  reborn.magic = 0x777777;
  reborn.connect(own.node->local().port);
  world.run(2s);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kLost, HostEvent::kUp));
  EXPECT_THAT(own.node->links(), SizeIs(1)) << "the old one is closed";
  ASSERT_TRUE(own.send(101, "to the new one"));
  world.run(1s);
  EXPECT_THAT(reborn.texts(), ElementsAre("to the new one"));
}

TEST_F(NodeFaults, AfterOurRestartAKernelResetsTheFirstConnectionAndTheNextOneHolds) {
  kernel.resets_reborn = true;
  own.options.connect = {"127.0.0.1:9000"};
  ASSERT_TRUE(own.open());
  world.run(1s);
  ASSERT_TRUE(own.sees(101));
  own.node.reset();
  own.options.magic += 1;
  own.events.clear();
  ASSERT_TRUE(own.open());
  world.run(2s);
  EXPECT_THAT(kernel.greetings, SizeIs(3)) << "one before the restart, one that was reset, one that holds";
  EXPECT_EQ(kernel.links(), 1u);
  ASSERT_TRUE(own.sees(101));
  ASSERT_TRUE(own.send(101, "value"));
  world.run(1s);
  EXPECT_THAT(kernel.texts(), ElementsAre("value"));
  EXPECT_THAT(own.outcomes, ElementsAre(Outcome::kDelivered));
}

TEST_F(NodeFaults, AKernelThatDoesNotNoticeOurEndIsReachedOverTheNewConnection) {
  kernel.notices_fin = false;
  join();
  world.net.tcp.cut();
  world.run(2s);
  EXPECT_THAT(kernel.greetings, SizeIs(1)) << "we connected again";
  EXPECT_EQ(kernel.links(), 2u) << "it keeps the dead one";
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(own.send(101, std::to_string(i)));
    world.run(1s);
  }
  EXPECT_THAT(own.outcomes, AllOf(SizeIs(10), Each(Outcome::kDelivered)));
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kBack));
}

TEST_F(NodeFaults, AnOldStartThatComesBackIsRefusedSoThatTwoOfOneIdDoNotFight) {
  join();
  KernelPeer other(world, 101, 9001);
  other.magic = 0x777777;
  other.connect(own.node->local().port);
  world.run(1s);
  for (int i = 0; i < 10; ++i) {
    kernel.connect(own.node->local().port);
    world.run(2s);
  }
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kLost, HostEvent::kUp));
  EXPECT_EQ(own.events.back().host.magic, 0x777777u);
}

TEST_F(NodeFaults, AStartThatHasItsIdBackMayLoseItsConnectionLikeAnyOther) {
  join();
  KernelPeer other(world, 101, 9001);
  other.magic = 0x777777;
  other.connect(own.node->local().port);
  world.run(1s);
  other.close();
  world.until([&] { return !own.sees(101); }, 5min);
  kernel.connect(own.node->local().port);
  world.run(3s);
  ASSERT_TRUE(own.sees(101));
  own.events.clear();
  kernel.close();
  world.run(1s);
  kernel.connect(own.node->local().port);
  world.run(3s);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kBack));
}

TEST_F(NodeFaults, TheSameMagicBackWithinFiftyMillisecondsIsNoLossAndWhatWasSentArrives) {
  join();
  world.net.tcp.stall(true);
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(own.send(101, std::to_string(i)));
  world.net.tcp.cut();
  world.run(50ms);
  world.net.tcp.stall(false);
  kernel.connect(own.node->local().port);
  world.run(300ms);
  EXPECT_EQ(kernel.texts().size(), 20u) << "sent again at once, in order";
  EXPECT_EQ(kernel.texts().front(), "0");
  EXPECT_EQ(kernel.texts().back(), "19");
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kBack));
  world.run(1s);
  EXPECT_THAT(own.outcomes, AllOf(SizeIs(20), Each(Outcome::kDelivered)));
}

TEST_F(NodeFaults, AHostWithoutAWayIsLostAfterTwoRoutingPeriods) {
  join();
  ASSERT_TRUE(own.send(101, "one"));
  kernel.stop_listening();
  kernel.close();
  const auto gone = world.time.now();
  ASSERT_TRUE(own.send(101, "two")) << "it may come back";
  world.run(60s);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kLost));
  EXPECT_THAT(own.events[1].at - gone, AllOf(Ge(20s), Le(20s + 100ms)));
  EXPECT_THAT(own.outcomes, SizeIs(2));
  EXPECT_EQ(own.send(101, "x").error().code, ErrorCode::kNotFound);
}

TEST_F(NodeFaults, AKernelThatComesBackAfterItWasLostIsMadeToForgetUsSoThatItSubscribesAgain) {
  join();
  kernel.stop_listening();
  kernel.close();
  world.run(40s);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kLost));
  kernel.received.clear();
  kernel.listen();
  kernel.connect(own.node->local().port);
  world.run(3s);
  ASSERT_THAT(kernel.of(Port::kDeadHost), SizeIs(1));
  EXPECT_EQ(*read_dead_host(base::as_bytes(kernel.of(Port::kDeadHost)[0].body)),
            (DeadHost{OwnerId{200}, DeathReason::kLost}));
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kLost, HostEvent::kUp));
  EXPECT_THAT(kernel.greetings, SizeIs(1)) << "we connected again at once";
  world.run(60s);
  EXPECT_THAT(own.events_of(101), SizeIs(3)) << "once";
}

TEST_F(NodeFaults, ARestartedKernelGetsNoRouteToItsFormerStart) {
  join();
  const auto former = kernel.magic++;
  kernel.received.clear();
  kernel.connect(own.node->local().port);
  world.run(15s);
  const auto pages = kernel.of(Port::kRouting);
  EXPECT_FALSE(pages.empty());
  for (const auto& package : pages) {
    const auto page = read_routing_page(base::as_bytes(package.body));
    for (const auto& entry : page->entries) EXPECT_NE(entry.magic, former);
  }
}

TEST_F(NodeFaults, ASilentConnectionEndsAfterThirtySeconds) {
  kernel.sends_routing = false;
  join();
  const auto start = world.time.now();
  world.until([&] { return own.node->links().empty(); }, 120s);
  EXPECT_THAT(world.time.now() - start, AllOf(Ge(29s), Le(31s)));
  EXPECT_EQ(counters().silent_links, 1u);
}

TEST_F(NodeFaults, WithoutRoutingFromItAKernelIsUsedAsLongAsItTalks) {
  kernel.sends_routing = false;
  join();
  for (int i = 0; i < 10; ++i) {
    kernel.send(200, Port::kPush, std::to_string(i));
    world.run(20s);
  }
  EXPECT_THAT(own.texts(), SizeIs(10));
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp));
}

TEST_F(NodeFaults, AKernelWhoseStreamLocksUpIsConnectedToAgainAfterTwoSeconds) {
  join();
  kernel.hold(true);
  const auto start = world.time.now();
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(own.send(101, std::string(1000, 'x')));
  world.until([&] { return counters().stuck_links > 0; }, 10s);
  EXPECT_THAT(world.time.now() - start, AllOf(Ge(2s), Le(3s)));
  world.run(1s);
  EXPECT_THAT(kernel.greetings, SizeIs(1)) << "same magic, at once";
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kBack));
  world.run(5s);
  EXPECT_THAT(own.outcomes, AllOf(SizeIs(100), Each(Outcome::kDelivered)));
}

TEST_F(NodeFaults, NoMoreThanTwentyThousandBytesWaitInTheSocketToAKernel) {
  join();
  kernel.hold(true);
  for (int i = 0; i < 190; ++i) ASSERT_TRUE(own.send(101, std::string(1000, 'x')));
  for (int i = 0; i < 100; ++i) {
    world.run(10ms);
    EXPECT_LE(own.node->links().at(0).unacknowledged, kMaxUnacknowledgedBytes);
  }
  EXPECT_GT(own.node->links().at(0).unacknowledged, kMaxUnacknowledgedBytes - 2000);
}

TEST_F(NodeFaults, AForgedDeathIsIgnoredAndNotPassedOn) {
  join();
  KernelPeer forger(world, 103, 9003);
  forger.connect(own.node->local().port);
  world.run(1s);
  ASSERT_TRUE(own.sees(103));
  const auto dead = write(DeadHost{OwnerId{101}, DeathReason::kLost});
  forger.send_raw(forger.header(Routing::kBroadcast, Port::kDeadHost), dead);
  auto in_its_name = forger.header(Routing::kBroadcast, Port::kDeadHost);
  in_its_name.source = OwnerId{101};
  forger.send_raw(in_its_name, dead);
  forger.send_raw(forger.header(Routing::kDirect, Port::kDeadHost, 200), dead);
  world.run(4s);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp));
  EXPECT_EQ(counters().forged_deaths, 3u);
  EXPECT_THAT(kernel.of(Port::kDeadHost), IsEmpty());
  kernel.send_raw(kernel.header(Routing::kBroadcast, Port::kDeadHost),
                  write(DeadHost{OwnerId{101}, DeathReason::kMessage}));
  kernel.send_raw(kernel.header(Routing::kBroadcast, Port::kDeadHost),
                  write(DeadHost{OwnerId{101}, DeathReason::kReborn}));
  world.run(1s);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp)) << "only reason 1 counts";
}

TEST_F(NodeFaults, AHostThatDeclaresUsDeadHasForgottenUs) {
  join();
  kernel.send_raw(kernel.header(Routing::kDirect, Port::kDeadHost, 200),
                  write(DeadHost{OwnerId{200}, DeathReason::kReborn}));
  world.run(100ms);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp, HostEvent::kForgot));
}

TEST_F(NodeFaults, AHigherVersionIsRefusedAndEndsNothing) {
  ASSERT_TRUE(own.open());
  kernel.version = 501;
  kernel.connect(own.node->local().port);
  world.run(1s);
  EXPECT_EQ(counters().foreign_versions, 1u);
  EXPECT_EQ(kernel.links(), 0u);
  EXPECT_FALSE(own.sees(101));
  kernel.version = kProtocolVersion;
  kernel.connect(own.node->local().port);
  world.run(1s);
  EXPECT_TRUE(own.sees(101)) << "this node goes on";
}

TEST_F(NodeFaults, AnnouncementsOfOtherVersionsNetworksAndSizesAreIgnored) {
  own.options.multicast = true;
  ASSERT_TRUE(own.open());
  kernel.connects = false;
  kernel.announce();
  world.until([&] { return own.sees(101); }, 10s);
  ASSERT_TRUE(own.sees(101));
  auto record = kernel.record();
  record.id = OwnerId{102};
  const auto sound = write(Announcement{"default", record});
  const auto send = [&](Bytes datagram) { kernel.send_datagram(datagram); };
  auto version = sound;
  version[3] = 0xf5;
  send(version);
  send(write(Announcement{"other", record}));
  send(Bytes(sound.begin(), sound.end() - 1));
  send(Bytes(2000, 0xff));
  send({});
  world.run(100ms);
  EXPECT_EQ(counters().foreign_versions, 1u);
  EXPECT_EQ(counters().foreign_networks, 1u);
  EXPECT_EQ(counters().bad_announcements, 3u);
  world.run(5s);
  EXPECT_TRUE(own.sees(101));
}

TEST_F(NodeFaults, AnotherNetworkIsRefused) {
  ASSERT_TRUE(own.open());
  kernel.network = "other";
  kernel.connect(own.node->local().port);
  world.run(1s);
  EXPECT_EQ(counters().foreign_networks, 1u);
  EXPECT_THAT(own.node->links(), IsEmpty());
  EXPECT_EQ(kernel.links(), 0u);
}

TEST_F(NodeFaults, OurIdUsedByAnotherIsReportedOnceAndDisturbsNoHost) {
  own.options.multicast = true;
  join();
  KernelPeer other(world, 200, 9001);
  other.connects = false;
  other.listen();
  other.announce();
  other.connect(own.node->local().port);
  world.run(20s);
  ASSERT_THAT(own.taken, SizeIs(1));
  EXPECT_EQ(own.taken[0].magic, other.magic);
  EXPECT_EQ(own.taken[0].full_name, "kernel@hostx!1");
  EXPECT_EQ(other.links(), 0u);
  EXPECT_GT(counters().own_id_seen, 2u);
  EXPECT_THAT(own.events_of(101), ElementsAre(HostEvent::kUp));
}

TEST_F(NodeFaults, StrangeBytesCloseTheConnectionAndAreCounted) {
  ASSERT_TRUE(own.open());
  const auto sends = [&](Bytes bytes) {
    KernelPeer peer(world, 150, 9005);
    peer.connect(own.node->local().port);
    world.run(100ms);
    peer.send_bytes(bytes);
    world.run(100ms);
    return peer.links() == 0;
  };
  Bytes package;
  append_package(package, kernel.header(Routing::kLink, Port::kTrace), {});
  auto bad_sync = package, long_body = package, negative = package;
  bad_sync[1] = 1;
  long_body[30] = 0x04, long_body[31] = 0x01;
  negative[4] = 0x80;
  EXPECT_TRUE(sends(bad_sync));
  EXPECT_TRUE(sends(long_body));
  EXPECT_TRUE(sends(negative));
  EXPECT_EQ(counters().bad_streams, 3u);
}

TEST_F(NodeFaults, WhoConnectsAndDoesNotSpeakIsClosedAndSuchConnectionsAreFew) {
  ASSERT_TRUE(own.open());
  std::vector<std::unique_ptr<transport::TcpStream>> streams;
  int ended = 0;
  for (int i = 0; i < 50; ++i) {
    transport::TcpCallbacks calls;
    calls.failed = [&](const Error&) { ++ended; };
    streams.push_back(std::move(*world.machine.open_tcp({own.node->local()}, std::move(calls))));
  }
  world.run(100ms);
  EXPECT_EQ(own.node->links().size(), 32u);
  EXPECT_EQ(counters().too_many_links, 18u);
  world.run(10s);
  EXPECT_EQ(ended, 50);
  EXPECT_THAT(own.node->links(), IsEmpty());
}

TEST_F(NodeFaults, TimeMessagesAreIgnored) {
  join();
  const auto wall = world.time.wall_now();
  kernel.send_raw(kernel.header(Routing::kBroadcast, Port::kTimeSync), write(TimeSync{4'000'000'000, 1, true}));
  world.run(1s);
  EXPECT_EQ(counters().time_messages, 1u);
  EXPECT_EQ(world.time.wall_now() - wall, 1s);
}

TEST_F(NodeFaults, HostsRoutesAndConnectionsAreBounded) {
  join();
  RoutingPage page;
  for (std::uint32_t first = 1000; first < 4000; first += 70) {
    page.entries.clear();
    for (std::uint32_t i = 0; i < 70; ++i) page.entries.push_back({OwnerId{first + i}, 1, 7, 1, 1});
    page.page = static_cast<std::uint16_t>((first - 1000) / 70);
    page.pages = 43;
    kernel.send_raw(kernel.header(Routing::kLink, Port::kRouting), write(page));
  }
  world.run(1s);
  EXPECT_EQ(own.node->routes().size(), Routes::kMaxRoutes);
  EXPECT_GT(counters().too_many_routes, 0u);
  for (std::uint32_t i = 0; i < 3000; ++i) {
    auto record = kernel.record();
    record.id = OwnerId{10'000 + i};
    kernel.send_raw(kernel.header(Routing::kBroadcast, Port::kHostInfo), write(HostRecordMessage{record, true}));
  }
  world.run(1s);
  EXPECT_GT(counters().too_many_hosts, 0u);
  std::vector<std::unique_ptr<KernelPeer>> peers;
  for (std::uint32_t i = 0; i < 300; ++i) {
    peers.push_back(std::make_unique<KernelPeer>(world, 5000 + i, 9100));
    peers.back()->connect(own.node->local().port);
    world.run(10ms);
  }
  EXPECT_EQ(own.node->links().size(), 256u);
  EXPECT_TRUE(own.sees(101)) << "who is here stays";
}

}  // namespace
}  // namespace rubicon::tuples::peis
