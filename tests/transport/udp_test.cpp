#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <memory>

#include "transport/interfaces.h"
#include "transport/machine_sockets.h"
#include "transport/worlds.h"

namespace rubicon::transport {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST(AsioUdp, WaitsOnlyForWhatCanBeWaitedFor) {
  EXPECT_EQ(after_send(0), AfterSend::kSent);
  EXPECT_EQ(after_send(EAGAIN), AfterSend::kWait);
  // A full queue of the device leaves the socket writable: to wait for that would spin.
  EXPECT_EQ(after_send(ENOBUFS), AfterSend::kDrop);
  EXPECT_EQ(after_send(EMSGSIZE), AfterSend::kRefused);
}

/// A socket and all it heard.
struct Listener {
  std::vector<std::pair<Endpoint, std::string>> heard;
  std::vector<Error> undelivered, failures;
  std::unique_ptr<UdpSocket> socket;

  Result<void> open(Transports& transports, UdpOptions options = {{"127.0.0.1", 0}, 2048}) {
    UdpCallbacks calls;
    calls.received = [this](const Endpoint& from, ByteView bytes) { heard.emplace_back(from, base::as_text(bytes)); };
    calls.undelivered = [this](Error error) { undelivered.push_back(std::move(error)); };
    calls.failed = [this](Error error) { failures.push_back(std::move(error)); };
    auto opened = transports.open_udp(options, std::move(calls));
    if (!opened) return fail(opened.error());
    socket = std::move(*opened);
    return {};
  }
  Endpoint at() const { return {"127.0.0.1", socket->local().port}; }
};

class Udp : public ::testing::TestWithParam<Where> {
 protected:
  Transports& transports() { return world->transports(); }

  std::unique_ptr<World> world = make_world(GetParam());
};

TEST_P(Udp, DatagramsArriveWholeAndInOrderWithTheirSource) {
  Listener a, b;
  ASSERT_TRUE(a.open(transports()));
  ASSERT_TRUE(b.open(transports()));
  EXPECT_NE(a.at().port, 0);
  for (const auto* text : {"one", "", "three"}) ASSERT_TRUE(a.socket->send(b.at(), base::as_bytes(text)));
  ASSERT_TRUE(world->until([&] { return b.heard.size() == 3; }));
  EXPECT_THAT(b.heard, ElementsAre(std::pair(a.at(), "one"), std::pair(a.at(), ""), std::pair(a.at(), "three")));
  ASSERT_TRUE(b.socket->send(b.heard[0].first, base::as_bytes("back")));
  EXPECT_TRUE(world->until([&] { return a.heard.size() == 1; }));
}

TEST_P(Udp, ASocketOnAllAddressesHearsIPv4AsIPv4) {
  Listener all, one;
  ASSERT_TRUE(all.open(transports(), {{"", 0}, 2048}));
  ASSERT_TRUE(one.open(transports()));
  ASSERT_TRUE(one.socket->send(all.at(), base::as_bytes("x")));
  ASSERT_TRUE(world->until([&] { return !all.heard.empty(); }));
  EXPECT_EQ(all.heard[0].first, one.at());
  ASSERT_TRUE(all.socket->send(one.at(), base::as_bytes("y"))) << "and sends to it";
  EXPECT_TRUE(world->until([&] { return !one.heard.empty(); }));
}

TEST_P(Udp, ALongDatagramArrivesCut) {
  Listener a, b;
  ASSERT_TRUE(a.open(transports()));
  ASSERT_TRUE(b.open(transports(), {{"127.0.0.1", 0}, 16}));
  ASSERT_TRUE(a.socket->send(b.at(), base::as_bytes(std::string(17, 'x'))));
  ASSERT_TRUE(a.socket->send(b.at(), base::as_bytes("short")));
  ASSERT_TRUE(world->until([&] { return b.heard.size() == 2; }));
  EXPECT_EQ(b.heard[0].second, std::string(16, 'x'));
  EXPECT_EQ(b.heard[1].second, "short");
}

TEST_P(Udp, ATakenPortIsRefusedUntilItsSocketIsGone) {
  Listener a, b;
  ASSERT_TRUE(a.open(transports(), {{"", 0}, 2048}));
  const UdpOptions same{{"", a.at().port}, 2048};
  const auto refused = b.open(transports(), same);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBusy);
  EXPECT_THAT(refused.error().text, HasSubstr(std::to_string(a.at().port)));
  a.socket.reset();
  EXPECT_TRUE(b.open(transports(), same));
}

TEST_P(Udp, AnAbsentPeerIsReportedAndHarmless) {
  Listener a, b, c;
  ASSERT_TRUE(a.open(transports()));
  ASSERT_TRUE(b.open(transports()));
  ASSERT_TRUE(c.open(transports()));
  const auto gone = b.at();
  b.socket.reset();
  ASSERT_TRUE(a.socket->send(gone, base::as_bytes("x")));
  ASSERT_TRUE(world->until([&] { return !a.undelivered.empty(); }));
  EXPECT_EQ(a.undelivered[0].code, ErrorCode::kUnreachable);
  EXPECT_THAT(a.undelivered[0].text, HasSubstr(to_string(gone)));
  ASSERT_TRUE(a.socket->send(gone, base::as_bytes("x")));
  ASSERT_TRUE(a.socket->send(c.at(), base::as_bytes("y"))) << "what ICMP says of the one does not cost the other";
  ASSERT_TRUE(c.socket->send(a.at(), base::as_bytes("z")));
  EXPECT_TRUE(world->until([&] { return !c.heard.empty() && !a.heard.empty(); }));
  EXPECT_THAT(a.failures, IsEmpty());
}

TEST_P(Udp, TheSocketMayBeDestroyedWhileItIsCalled) {
  Listener a, b;
  ASSERT_TRUE(a.open(transports()));
  UdpCallbacks calls;
  bool called = false;
  std::unique_ptr<UdpSocket> mortal;
  calls.received = [&](const Endpoint&, ByteView) {
    EXPECT_FALSE(std::exchange(called, true));
    mortal.reset();
  };
  calls.undelivered = [](const Error&) {};
  calls.failed = [](const Error&) { ADD_FAILURE(); };
  mortal = std::move(transports().open_udp({{"127.0.0.1", 0}, 2048}, std::move(calls)).value());
  const auto to = mortal->local();
  ASSERT_TRUE(a.socket->send(to, base::as_bytes("1")));
  ASSERT_TRUE(a.socket->send(to, base::as_bytes("2")));
  EXPECT_TRUE(world->until([&] { return called; }));
  EXPECT_EQ(mortal, nullptr);
}

TEST_P(Udp, RefusesWhatIsNoEndpointAndWhatFitsNoDatagram) {
  Listener a;
  ASSERT_TRUE(a.open(transports()));
  EXPECT_EQ(a.socket->send({"localhost", 9}, {}).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(a.socket->send({"127.0.0.1", 0}, {}).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(a.socket->send(a.at(), Bytes(65508)).error().code, ErrorCode::kOutOfRange);
}

TEST_P(Udp, NamesAreLookedUpAndNumbersAreThemselves) {
  std::vector<Result<std::vector<std::string>>> found;
  const auto keep = [&](auto addresses) { found.push_back(std::move(addresses)); };
  const auto number = transports().look_up("127.0.0.2", keep);
  EXPECT_THAT(found, IsEmpty()) << "never from inside the call";
  ASSERT_TRUE(world->until([&] { return found.size() == 1; }));
  EXPECT_THAT(*found[0], ElementsAre("127.0.0.2"));
  const auto name = transports().look_up("localhost", keep);
  ASSERT_TRUE(world->until([&] { return found.size() == 2; }));
  EXPECT_EQ(found[1].value().front(), "127.0.0.1") << "IPv4 first";
  const auto unknown = transports().look_up("no-such-host.invalid", keep);
  ASSERT_TRUE(world->until([&] { return found.size() == 3; }));
  EXPECT_EQ(found[2].error().code, ErrorCode::kUnreachable);
  EXPECT_THAT(found[2].error().text, HasSubstr("no-such-host.invalid"));
}

TEST_P(Udp, AForgottenLookupReportsNothing) {
  bool reported = false;
  transports().look_up("localhost", [&](const auto&) { reported = true; }).reset();
  std::vector<std::string> other;
  const auto kept = transports().look_up("localhost", [&](auto found) { other = found.value(); });
  EXPECT_TRUE(world->until([&] { return !other.empty(); }));
  EXPECT_FALSE(reported);
}

/// A group is heard on the port it was sent to, by those who joined it.
UdpOptions in_group(std::uint16_t port, std::vector<std::string> groups = {"239.77.1.12"}) {
  UdpOptions options{{groups.empty() ? "" : groups[0], port}};
  options.multicast = UdpMulticast{std::move(groups), "127.0.0.1"};
  options.reuse_address = true;
  return options;
}

/// A port that no socket has.
std::uint16_t free_port(Transports& transports) {
  Listener probe;
  EXPECT_TRUE(probe.open(transports));
  return probe.at().port;
}

TEST_P(Udp, AGroupIsHeardByAllWhoJoinedItTheSenderToo) {
  const auto port = free_port(transports());
  Listener a, b, other;
  ASSERT_TRUE(a.open(transports(), in_group(port)));
  ASSERT_TRUE(b.open(transports(), in_group(port)));
  ASSERT_TRUE(other.open(transports(), in_group(port, {"239.77.1.13"})));
  ASSERT_TRUE(a.socket->send({"239.77.1.12", port}, base::as_bytes("all")));
  ASSERT_TRUE(other.socket->send({"239.77.1.13", port}, base::as_bytes("end")));
  ASSERT_TRUE(world->until([&] { return !a.heard.empty() && !b.heard.empty() && !other.heard.empty(); }));
  EXPECT_THAT(b.heard, ElementsAre(std::pair(Endpoint{"127.0.0.1", port}, "all")));
  EXPECT_THAT(a.heard, ElementsAre(std::pair(Endpoint{"127.0.0.1", port}, "all")));
  EXPECT_THAT(other.heard, ElementsAre(std::pair(Endpoint{"127.0.0.1", port}, "end"))) << "other groups are not heard";
}

TEST_P(Udp, WhatCameBeforeAGroupIsJoinedAgainIsHeard) {
  const auto port = free_port(transports());
  Listener a, b;
  ASSERT_TRUE(a.open(transports(), in_group(port)));
  ASSERT_TRUE(b.open(transports(), in_group(port)));
  ASSERT_TRUE(b.socket->send({"239.77.1.12", port}, base::as_bytes("one")));
  ASSERT_TRUE(a.socket->rejoin());
  ASSERT_TRUE(b.socket->send({"239.77.1.12", port}, base::as_bytes("two")));
  ASSERT_TRUE(world->until([&] { return a.heard.size() == 2; }));
  EXPECT_EQ(a.heard[0].second, "one");
  Listener plain;
  ASSERT_TRUE(plain.open(transports()));
  EXPECT_TRUE(plain.socket->rejoin()) << "nothing to do";
}

TEST_P(Udp, WhoBoundAGroupTakesNothingFromTheMachinesOwnPort) {
  const auto port = free_port(transports());
  Listener server, member, client;
  UdpOptions options{{"127.0.0.1", port}};
  options.reuse_address = true;
  ASSERT_TRUE(server.open(transports(), options));
  ASSERT_TRUE(member.open(transports(), in_group(port)));
  ASSERT_TRUE(client.open(transports()));
  ASSERT_TRUE(client.socket->send({"127.0.0.1", port}, base::as_bytes("x")));
  EXPECT_TRUE(world->until([&] { return !server.heard.empty(); }));
  EXPECT_THAT(member.heard, IsEmpty());
}

TEST_P(Udp, GroupsThatCannotBeJoinedAreNamed) {
  Listener listener;
  auto options = in_group(0, {"239.77.1.12"});
  options.multicast->interface_address = "192.0.2.1";
  auto refused = listener.open(transports(), options);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().text, HasSubstr("192.0.2.1"));
  options = in_group(0, {"239.77.1.12", "10.1.2.3"});
  refused = listener.open(transports(), options);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kIo);
  EXPECT_THAT(refused.error().text, HasSubstr("join group 10.1.2.3 on 127.0.0.1"));
}

TEST_P(Udp, APortIsSharedOnlyWhenBothWantIt) {
  Listener a, b;
  ASSERT_TRUE(a.open(transports()));
  UdpOptions options{a.at()};
  options.reuse_address = true;
  EXPECT_EQ(b.open(transports(), options).error().code, ErrorCode::kBusy);
}

TEST_P(Udp, AConnectedSocketHearsAndSendsToItsPeerOnly) {
  Listener peer, stranger, one;
  ASSERT_TRUE(peer.open(transports()));
  ASSERT_TRUE(stranger.open(transports()));
  UdpOptions options{{"", 0}};
  options.remote = peer.at();
  ASSERT_TRUE(one.open(transports(), options));
  ASSERT_TRUE(stranger.socket->send(one.at(), base::as_bytes("unheard")));
  ASSERT_TRUE(peer.socket->send(one.at(), base::as_bytes("heard")));
  ASSERT_TRUE(one.socket->send(peer.at(), base::as_bytes("x")));
  ASSERT_TRUE(world->until([&] { return !one.heard.empty() && !peer.heard.empty(); }));
  EXPECT_THAT(one.heard, ElementsAre(std::pair(peer.at(), "heard")));
  const auto refused = one.socket->send(stranger.at(), base::as_bytes("x"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalid);
  EXPECT_THAT(refused.error().text, HasSubstr(to_string(peer.at())));
  peer.socket.reset();
  ASSERT_TRUE(one.socket->send(*options.remote, base::as_bytes("x")));
  EXPECT_TRUE(world->until([&] { return !one.undelivered.empty(); })) << "ICMP errors arrive";
  EXPECT_THAT(one.failures, IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(On, Udp, ::testing::Values(Where::kMachine, Where::kPollLoop, Where::kMemory),
                         [](const auto& where) { return name_of(where.param); });

TEST(MachineUdp, ASendThatMeetsTheErrorOfAnotherOneIsNoReasonToKeepItQuiet) {
  MachineWorld world;
  Listener a, gone, quiet;
  ASSERT_TRUE(a.open(world.local));
  ASSERT_TRUE(gone.open(world.local));
  ASSERT_TRUE(quiet.open(world.local));
  const auto closed = gone.at();
  gone.socket.reset();
  ASSERT_TRUE(a.socket->send(closed, base::as_bytes("x")));  // over loopback ICMP answers at once
  ASSERT_TRUE(a.socket->send(quiet.at(), base::as_bytes("y")));
  ASSERT_TRUE(world.until([&] { return !a.undelivered.empty(); }));
  EXPECT_THAT(a.undelivered[0].text, HasSubstr(to_string(closed)));
  EXPECT_THAT(a.failures, IsEmpty());
}

TEST(MachineUdp, ALoopMayEndWhileNamesAreLookedUp) {
  for (int i = 0; i < 20; ++i) {
    Loop loop;
    LocalTransports local(loop);
    const auto kept = local.look_up("localhost", [](const auto&) { ADD_FAILURE() << "the loop never ran"; });
  }
}

TEST(MachineUdp, AForeignAddressCannotBeBound) {
  MachineWorld world;
  Listener listener;
  EXPECT_EQ(listener.open(world.local, {{"192.0.2.1", 0}, 2048}).error().code, ErrorCode::kIo);
  EXPECT_FALSE(listener.open(world.local, {{"nonsense", 0}, 2048}));
}

TEST(MachineUdp, ThePeerOfASocketIsNumeric) {
  MachineWorld world;
  Listener listener;
  UdpOptions options;
  options.remote = Endpoint{"localhost", 9};
  EXPECT_EQ(listener.open(world.local, options).error().code, ErrorCode::kInvalid);
}

TEST(Interfaces, TheMachineHasALoopback) {
  const auto all = ipv4_interfaces();
  const auto is_loopback = [](const Interface& one) { return one.is_loopback && one.address == "127.0.0.1"; };
  EXPECT_EQ(std::count_if(all.begin(), all.end(), is_loopback), 1);
}

TEST(MachineUdp, WithoutALoopThereAreOnlyFiles) {
  EXPECT_EQ(LocalTransports().open_udp({}, {}).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(MemoryTransports().open_udp({}, {}).error().code, ErrorCode::kUnsupported);
}

TEST(MemoryUdp, HostsHaveAddressesAndPortsOfTheirOwn) {
  MemoryWorld world;
  MemoryTransports other;
  other.join(world.net, "192.168.1.141");
  Listener here, there;
  ASSERT_TRUE(here.open(world.memory, {{"", 9000}, 2048}));
  ASSERT_TRUE(there.open(other, {{"", 9000}, 2048}));
  ASSERT_TRUE(here.socket->send({"192.168.1.141", 9000}, base::as_bytes("x")));
  world.time.run_for(1s);
  ASSERT_THAT(there.heard, SizeIs(1));
  EXPECT_EQ(there.heard[0].first, (Endpoint{"127.0.0.1", 9000}));
  EXPECT_EQ(world.net.open_sockets(), 2u);
}

/// Linux's own loopback interface brings all back, so that this shows in memory only.
TEST(MemoryUdp, WithoutLoopbackGroupsReachOtherMachinesOnly) {
  MemoryWorld world;
  MemoryTransports far;
  far.join(world.net, "10.0.0.2");
  Listener near, away, quiet;
  ASSERT_TRUE(near.open(world.memory, in_group(3671)));
  auto there = in_group(3671);
  there.multicast->interface_address = "10.0.0.2";
  ASSERT_TRUE(away.open(far, there));
  UdpOptions options{{"127.0.0.1", 0}};
  options.multicast = UdpMulticast{{}, "127.0.0.1", 1, false};
  ASSERT_TRUE(quiet.open(world.memory, options));
  ASSERT_TRUE(quiet.socket->send({"239.77.1.12", 3671}, base::as_bytes("x")));
  world.time.run_for(1s);
  EXPECT_THAT(near.heard, IsEmpty());
  EXPECT_THAT(away.heard, ElementsAre(std::pair(quiet.at(), "x"))) << "and with the port that was bound";
}

TEST(MemoryUdp, LosesRefusesAndKeepsQuietWhenATestWantsIt) {
  MemoryWorld world;
  Listener a, b;
  ASSERT_TRUE(a.open(world.memory));
  ASSERT_TRUE(b.open(world.memory));
  world.net.loses = [](const MemoryDatagram& datagram) { return base::as_text(datagram.bytes) == "lost"; };
  ASSERT_TRUE(a.socket->send(b.at(), base::as_bytes("lost")));
  ASSERT_TRUE(a.socket->send(b.at(), base::as_bytes("kept")));
  world.net.refuses = 1;
  EXPECT_EQ(a.socket->send(b.at(), base::as_bytes("busy")).error().code, ErrorCode::kBusy);
  EXPECT_EQ(a.socket->dropped(), 1u);
  world.net.reports_unreachable = false;
  ASSERT_TRUE(a.socket->send({"10.0.0.1", 7}, base::as_bytes("void")));
  world.time.run_for(1s);
  EXPECT_THAT(b.heard, SizeIs(1));
  EXPECT_THAT(a.undelivered, IsEmpty());
  EXPECT_THAT(world.net.sent(), SizeIs(3));
}

}  // namespace
}  // namespace rubicon::transport
