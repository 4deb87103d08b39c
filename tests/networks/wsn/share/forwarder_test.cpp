#include <gmock/gmock.h>

#include <fstream>
#include <iterator>

#include "networks/wsn/share/forwarder_fixture.h"

namespace rubicon::networks::wsn::share {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using ::testing::StartsWith;

TEST_F(ForwarderTest, GreetsFirstAndAtOnce) {
  open();
  Program silent;
  silent.connect(host);
  run(1ms);
  EXPECT_EQ(silent.heard, kHello);
  EXPECT_EQ(forwarder->clients(), 1u);
  EXPECT_EQ(counted("clients-total"), 1u);
}

TEST_F(ForwarderTest, EveryClientThatGreetedHearsEveryPacketOfTheSink) {
  open();
  Program one, two, silent;
  one.greet(host);
  two.greet(host);
  silent.connect(host);
  run();
  for (std::uint8_t number = 1; number <= 3; ++number) forwarder->broadcast(packet(number, 114));
  run();
  for (auto* program : {&one, &two})
    EXPECT_THAT(program->packets(), ElementsAre(packet(1, 114), packet(2, 114), packet(3, 114)));
  EXPECT_EQ(silent.heard, kHello);
  EXPECT_EQ(counted("packets-to-clients"), 6u);
}

TEST_F(ForwarderTest, APacketOfAClientReachesTheSinkAndNoOtherClient) {
  open();
  Program one, two;
  one.greet(host);
  two.greet(host);
  run();
  one.say(packet(1));
  run();
  EXPECT_THAT(taken, ElementsAre(packet(1)));
  EXPECT_EQ(one.heard, kHello);
  EXPECT_EQ(two.heard, kHello);
  EXPECT_EQ(counted("packets-from-clients"), 1u);
}

TEST_F(ForwarderTest, ReadsMaySplitAnywhere) {
  net.tcp.segment = 1;
  open();
  Program one;
  one.greet(host);
  for (std::uint8_t number = 1; number <= 5; ++number) one.say(packet(number, 114));
  run();
  EXPECT_THAT(numbers(), ElementsAre(1, 2, 3, 4, 5));
}

TEST_F(ForwarderTest, AClientThatDoesNotGreetIsDisconnected) {
  open();
  Program silent, half, greeted;
  silent.connect(host);
  half.connect(host);
  half.send({0x55});
  greeted.greet(host);
  run(4990ms);
  EXPECT_FALSE(silent.disconnected);
  greeted.say(packet(1));
  run(20ms);
  EXPECT_TRUE(silent.disconnected);
  EXPECT_TRUE(half.disconnected);
  EXPECT_FALSE(greeted.disconnected);
  EXPECT_THAT(numbers(), ElementsAre(1));
  EXPECT_EQ(counted("dropped-silent"), 2u);
  EXPECT_EQ(counted("clients"), 1u);
  EXPECT_THAT(notes, Contains(HasSubstr("did not greet within 5 s")));
  run(1h);
  EXPECT_FALSE(greeted.disconnected) << "after the greeting it may be silent for ever";
}

TEST_F(ForwarderTest, OnlyClientsOfTheProtocolAreKept) {
  open();
  const std::vector<std::pair<Bytes, bool>> cases{
      {{0x55, 0x20}, true},  {{0x55, 0x21}, true},  {{0x55, 0xff}, true},         {{0x55, 0x1f}, false},
      {{0x54, 0x20}, false}, {{0x20, 0x55}, false}, {{'G', 'E', 'T', ' '}, false}};
  for (const auto& [greeting, kept] : cases) {
    Program program;
    program.connect(host);
    program.send(greeting);
    run(100ms);
    EXPECT_EQ(program.disconnected, !kept) << base::to_hex(greeting);
  }
  run();
  EXPECT_EQ(counted("dropped-strangers"), 4u);
  EXPECT_EQ(forwarder->clients(), 0u);
}

TEST_F(ForwarderTest, ALengthOf0EndsThatClientOnly) {
  open();
  Program one, two;
  one.greet(host);
  two.greet(host);
  run();
  one.say(packet(1));
  one.send({0x00});
  one.say(packet(2));
  two.say(packet(3));
  run();
  EXPECT_TRUE(one.disconnected);
  EXPECT_FALSE(two.disconnected);
  EXPECT_THAT(numbers(), ElementsAre(1, 3)) << "what came before the 0 counts";
  EXPECT_THAT(notes, ElementsAre(StartsWith("dropped-strangers: ")));
}

TEST_F(ForwarderTest, PacketsThatTheSinkCannotTakeAreDroppedAndTheClientStays) {
  open();
  Program one;
  one.greet(host);
  one.say(Bytes(1, 0));
  one.say(Bytes(7, 0));
  one.say(packet(1, 0));
  one.say(packet(2, 114));
  one.say(packet(3, 115));
  one.say(packet(4, 247));
  run();
  EXPECT_THAT(taken, ElementsAre(packet(1, 0), packet(2, 114)));
  EXPECT_FALSE(one.disconnected);
  EXPECT_EQ(counted("dropped-bad-packets"), 4u);
  EXPECT_THAT(notes, ElementsAre(HasSubstr("dropped a packet of 1 bytes, expected 8 to 122"))) << "once a minute";
  run(1min);
  one.say(packet(3, 115));
  run();
  EXPECT_THAT(notes, Contains(HasSubstr("dropped a packet of 123 bytes, expected 8 to 122")));
}

TEST_F(ForwarderTest, AClientThatSendsOnlyBadPacketsIsDisconnected) {
  open();
  Program garbage, mixed;
  garbage.greet(host);
  mixed.greet(host);
  run();
  const auto bad = [](Program& program, int count) {
    for (int i = 0; i < count; ++i) program.send({0x01, 0x00});
  };
  bad(garbage, 99);
  bad(mixed, 99);
  mixed.say(packet(1));
  bad(mixed, 99);
  run();
  EXPECT_FALSE(garbage.disconnected);
  bad(garbage, 1000);
  run();
  EXPECT_TRUE(garbage.disconnected);
  EXPECT_FALSE(mixed.disconnected) << "a good one between them";
  EXPECT_EQ(counted("dropped-bad-packets"), 100u + 198u);
  EXPECT_EQ(counted("dropped-strangers"), 1u);
  EXPECT_THAT(notes, ElementsAre(StartsWith("dropped-bad-packets"), HasSubstr("100 bad packets in a row")));
}

/// wsn.md 4.3, worked: SET_ISLAND_ID 7D7E.
const Bytes kSetIsland{0x00, 0x00, 0x01, 0x00, 0x00, 0x03, 0x00, 0x25, 0x0a, 0x7d, 0x7e};

TEST_F(ForwarderTest, ConfigPacketsAreRefusedUnlessClientsMayConfigure) {
  open();
  Program one;
  one.greet(host);
  one.say(kSetIsland);
  one.say(packet(1));
  run();
  EXPECT_THAT(taken, ElementsAre(packet(1)));
  EXPECT_EQ(counted("dropped-config"), 1u);
  EXPECT_FALSE(one.disconnected);

  forwarder.reset();
  taken.clear();
  ForwarderOptions options;
  options.may_configure = true;
  open(options);
  Program two;
  two.greet(host);
  two.say(kSetIsland);
  run();
  EXPECT_THAT(taken, ElementsAre(kSetIsland));
}

TEST_F(ForwarderTest, ContentIsNotInterpreted) {
  open();
  Program one;
  one.greet(host);
  const Bytes strange(20, 0x25);  // no AM packet: another dispatch byte
  one.say(strange);
  run();
  EXPECT_THAT(taken, ElementsAre(strange));
}

TEST_F(ForwarderTest, ASlowClientIsDisconnectedAndDelaysNoOther) {
  ForwarderOptions options;
  options.client_bytes = 1000;
  open(options);
  Program slow, quick;
  slow.greet(host);
  quick.greet(host);
  run();
  slow.stream->hold(true);
  for (int i = 0; i < 20; ++i) {
    forwarder->broadcast(packet(1, 114));
    run(11ms);
    EXPECT_EQ(forwarder->clients(), i < 8 ? 2u : 1u) << "8 packets of 123 bytes wait in 1000 bytes: " << i;
  }
  EXPECT_THAT(quick.packets(), SizeIs(20));
  EXPECT_EQ(counted("dropped-slow-clients"), 1u);
  EXPECT_THAT(notes, ElementsAre(StartsWith("dropped-slow-clients: ")));
}

/// The original's classes begin with it (wsn.md 9.1).
TEST_F(ForwarderTest, AConfigPacketThatSetsTheIslandOfTheSinkPassesAndEveryOtherIsRefused) {
  ForwarderOptions options;
  options.island = 0x7d7e;
  open(options);
  Program original;
  original.greet(host);
  original.say(kSetIsland);
  auto other = kSetIsland;
  other.back() = 0x7f;
  original.say(other);
  auto command = kSetIsland;
  command[8] = 0x0b;
  original.say(command);
  auto cut = kSetIsland;
  cut.pop_back();
  original.say(cut);
  run();
  EXPECT_THAT(taken, ElementsAre(kSetIsland));
  EXPECT_EQ(counted("dropped-config"), 3u);
  ASSERT_THAT(notes, SizeIs(1)) << "once a minute";
  EXPECT_THAT(notes[0], testing::HasSubstr("share-config"));
  EXPECT_FALSE(original.disconnected);
}

TEST_F(ForwarderTest, MoreClientsThanAllowedAreDisconnected) {
  ForwarderOptions options;
  options.clients = 2;
  open(options);
  Program one, two, three;
  for (auto* program : {&one, &two, &three}) {
    program->greet(host);
    run(10ms);
  }
  EXPECT_FALSE(one.disconnected);
  EXPECT_FALSE(two.disconnected);
  EXPECT_TRUE(three.disconnected);
  EXPECT_EQ(counted("refused-clients"), 1u);
  ASSERT_THAT(notes, SizeIs(1));
  EXPECT_THAT(notes[0], testing::HasSubstr("refused, 2 are connected (share-clients)"));
  one.stream.reset();
  run();
  Program four;
  four.greet(host);
  run();
  EXPECT_FALSE(four.disconnected) << "a place is free again";
}

TEST_F(ForwarderTest, ALostPortIsReportedTheClientsStayAndItCanBeOpenedAgain) {
  open();
  Program one;
  one.greet(host);
  run();
  net.tcp.fail_listeners();
  run();
  ASSERT_THAT(failures, SizeIs(1));
  EXPECT_THAT(failures[0].text, HasSubstr("127.0.0.1:9002"));
  EXPECT_EQ(forwarder->local(), transport::Endpoint());
  forwarder->broadcast(packet(1));
  run();
  EXPECT_THAT(one.packets(), SizeIs(1));
  ASSERT_TRUE(forwarder->open());
  Program two;
  two.greet(host);
  run();
  EXPECT_EQ(forwarder->clients(), 2u);
}

TEST_F(ForwarderTest, ATakenPortIsBusyAndOpenIsHarmlessTwice) {
  open();
  EXPECT_TRUE(forwarder->open());
  EXPECT_EQ(forwarder->local(), (transport::Endpoint{"127.0.0.1", 9002}));
  Forwarder second({}, time, host, {[](ByteView) { return true; }, {}, {}});
  const auto refused_open = second.open();
  ASSERT_FALSE(refused_open);
  EXPECT_EQ(refused_open.error().code, ErrorCode::kBusy);
}

TEST_F(ForwarderTest, ADestroyedForwarderDisconnectsAll) {
  open();
  Program one, two;
  one.greet(host);
  two.connect(host);
  run();
  forwarder.reset();
  run(10s);
  EXPECT_TRUE(one.disconnected);
  EXPECT_TRUE(two.disconnected);
  EXPECT_EQ(net.tcp.open_streams(), 0u);
}

TEST_F(ForwarderTest, APacketThatALengthByteCannotExpressIsDiscarded) {
  open();
  Program one;
  one.greet(host);
  run();
  forwarder->broadcast({});
  forwarder->broadcast(Bytes(256, 1));
  forwarder->broadcast(Bytes(255, 1));
  run();
  EXPECT_THAT(one.packets(), ElementsAre(Bytes(255, 1)));
}

TEST_F(ForwarderTest, TheOriginalToolsRecordedConnectionArrivesWhole) {
  std::ifstream file(RUBICON_SOURCE_DIR "/../shared/data/motes/origjava_sf_tcp_pc2sf.bin", std::ios::binary);
  if (!file) GTEST_SKIP() << "no recording of the original tools here";
  const Bytes recorded{std::istreambuf_iterator<char>(file), {}};
  for (const bool may_configure : {true, false}) {
    for (const std::size_t segment : {std::size_t{0}, std::size_t{1}, std::size_t{7}}) {
      taken.clear();
      net.tcp.segment = segment;
      ForwarderOptions options;
      options.may_configure = may_configure;
      open(options);
      Program original;
      original.connect(host);
      original.send(recorded);
      run();
      EXPECT_FALSE(original.disconnected);
      ASSERT_THAT(taken, SizeIs(may_configure ? 4 : 3));
      Bytes again = kHello;
      for (const auto& one : taken)
        for (const auto byte : sent(one)) again.push_back(byte);
      EXPECT_EQ(again == recorded, may_configure);
      EXPECT_EQ(taken.front()[7], may_configure ? 0x25 : 0x1c);
      EXPECT_EQ(counted("dropped-config"), may_configure ? 0u : 1u);
      forwarder.reset();
      run();
    }
  }
}

}  // namespace
}  // namespace rubicon::networks::wsn::share
