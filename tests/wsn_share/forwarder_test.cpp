#include "networks/wsn/share/forwarder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "base/virtual_scheduler.h"
#include "transport/memory_transports.h"

namespace rubicon::networks::wsn {
namespace {

using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

/// One that tells which it is, in the form of wsn.md 3: dispatch, AM header, payload of `size` bytes.
Bytes packet(std::uint8_t number, std::size_t size = 4, std::uint8_t type = 0x1c) {
  Bytes bytes{0x00, 0x00, 0x01, 0x00, 0x00, static_cast<std::uint8_t>(size), 0x00, type};
  bytes.resize(8 + size, number);
  return bytes;
}

/// As it stands in the stream.
Bytes sent(const Bytes& packet) {
  Bytes bytes{static_cast<std::uint8_t>(packet.size())};
  bytes.insert(bytes.end(), packet.begin(), packet.end());
  return bytes;
}

const Bytes kHello{0x55, 0x20};

/// Another program, which speaks as wsn.md 4.1 says.
struct Program {
  std::unique_ptr<transport::TcpStream> stream;
  Bytes heard;
  bool hung_up_on = false;

  void connect(transport::Transports& transports) {
    transport::TcpCalls calls;
    calls.received = [this](ByteView bytes) { heard.insert(heard.end(), bytes.begin(), bytes.end()); };
    calls.failed = [this](const Error&) { hung_up_on = true; };
    stream = std::move(transports.open_tcp({{"127.0.0.1", 9002}}, std::move(calls))).value();
  }
  void greet(transport::Transports& transports) {
    connect(transports);
    send(kHello);
  }
  void send(const Bytes& bytes) { EXPECT_TRUE(stream->send(bytes)); }
  void say(const Bytes& packet) { send(sent(packet)); }
  /// What came behind the greeting, cut into packets.
  std::vector<Bytes> packets() const {
    std::vector<Bytes> all;
    for (std::size_t at = 2; at < heard.size(); at += std::size_t{1} + heard[at]) {
      const auto first = heard.begin() + static_cast<std::ptrdiff_t>(at + 1);
      all.emplace_back(first, first + heard[at]);
    }
    return all;
  }
};

class ForwarderTest : public ::testing::Test {
 protected:
  ForwarderTest() { host.join(net); }

  void open(ForwarderOptions options = {}) {
    ForwarderCalls calls;
    calls.packet = [this](ByteView bytes) {
      if (taken.size() >= space) return ++refused, false;
      taken.emplace_back(bytes.begin(), bytes.end());
      return true;
    };
    calls.failed = [this](const Error& error) { failures.push_back(error); };
    calls.note = [this](const std::string& subject, std::string_view text) {
      notes.push_back(subject + ": " + std::string(text));
    };
    forwarder = std::make_unique<Forwarder>(std::move(options), time, host, std::move(calls));
    ASSERT_TRUE(forwarder->open());
  }
  void run(Duration span = 1s) { time.run_for(span); }
  /// So many packets more are taken.
  void make_room(std::size_t more) {
    space = taken.size() + more;
    forwarder->room();
    run();
  }
  std::uint64_t counted(const std::string& name) const { return forwarder->counters().at(name); }
  std::vector<int> numbers() const {
    std::vector<int> all;
    for (const auto& one : taken) all.push_back(one.back());
    return all;
  }

  VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MemoryTransports host;
  std::vector<Bytes> taken;
  std::size_t space = 1000000, refused = 0;
  std::vector<Error> failures;
  std::vector<std::string> notes;
  std::unique_ptr<Forwarder> forwarder;
};

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
  for (std::uint8_t number = 1; number <= 3; ++number) forwarder->tell(packet(number, 114));
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

TEST_F(ForwarderTest, AClientThatDoesNotGreetIsHungUpOnAndDisturbsNobody) {
  open();
  Program silent, half, sound;
  silent.connect(host);
  half.connect(host);
  half.send({0x55});
  sound.greet(host);
  run(4990ms);
  EXPECT_FALSE(silent.hung_up_on);
  sound.say(packet(1));
  run(20ms);
  EXPECT_TRUE(silent.hung_up_on);
  EXPECT_TRUE(half.hung_up_on);
  EXPECT_FALSE(sound.hung_up_on);
  EXPECT_THAT(numbers(), ElementsAre(1));
  EXPECT_EQ(counted("dropped-silent"), 2u);
  EXPECT_EQ(counted("clients"), 1u);
  EXPECT_THAT(notes, Contains(HasSubstr("did not greet within 5 s")));
  run(1h);
  EXPECT_FALSE(sound.hung_up_on) << "who greeted may be silent for ever";
}

TEST_F(ForwarderTest, OnlyWhoSpeaksTheProtocolIsKept) {
  open();
  const std::vector<std::pair<Bytes, bool>> cases{
      {{0x55, 0x20}, true},  {{0x55, 0x21}, true},  {{0x55, 0xff}, true},         {{0x55, 0x1f}, false},
      {{0x54, 0x20}, false}, {{0x20, 0x55}, false}, {{'G', 'E', 'T', ' '}, false}};
  for (const auto& [greeting, kept] : cases) {
    Program program;
    program.connect(host);
    program.send(greeting);
    run(100ms);
    EXPECT_EQ(program.hung_up_on, !kept) << base::to_hex(greeting);
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
  EXPECT_TRUE(one.hung_up_on);
  EXPECT_FALSE(two.hung_up_on);
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
  EXPECT_FALSE(one.hung_up_on);
  EXPECT_EQ(counted("dropped-bad-packets"), 4u);
  EXPECT_THAT(notes, ElementsAre(HasSubstr("dropped a packet of 1 bytes, expected 8 to 122"))) << "once a minute";
  run(1min);
  one.say(packet(3, 115));
  run();
  EXPECT_THAT(notes, Contains(HasSubstr("dropped a packet of 123 bytes, expected 8 to 122")));
}

TEST_F(ForwarderTest, AClientOfBadPacketsAloneIsHungUpOn) {
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
  EXPECT_FALSE(garbage.hung_up_on);
  bad(garbage, 1000);
  run();
  EXPECT_TRUE(garbage.hung_up_on);
  EXPECT_FALSE(mixed.hung_up_on) << "a good one between them";
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
  EXPECT_FALSE(one.hung_up_on);

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

TEST_F(ForwarderTest, ContentIsNotLookedAt) {
  open();
  Program one;
  one.greet(host);
  const Bytes strange(20, 0x25);  // no AM packet: another dispatch byte
  one.say(strange);
  run();
  EXPECT_THAT(taken, ElementsAre(strange));
}

TEST_F(ForwarderTest, ASlowClientIsHungUpOnAndHoldsUpNobody) {
  ForwarderOptions options;
  options.client_bytes = 1000;
  open(options);
  Program slow, quick;
  slow.greet(host);
  quick.greet(host);
  run();
  slow.stream->hold(true);
  for (int i = 0; i < 20; ++i) {
    forwarder->tell(packet(1, 114));
    run(11ms);
    EXPECT_EQ(forwarder->clients(), i < 8 ? 2u : 1u) << "8 packets of 123 bytes wait in 1000 bytes: " << i;
  }
  EXPECT_THAT(quick.packets(), SizeIs(20));
  EXPECT_EQ(counted("dropped-slow-clients"), 1u);
  EXPECT_THAT(notes, ElementsAre(StartsWith("dropped-slow-clients: ")));
}

TEST_F(ForwarderTest, AClientIsHeldWhileThereIsNoRoomAndNothingIsLostOrReordered) {
  open();
  space = 3;
  Program one;
  one.greet(host);
  for (std::uint8_t number = 1; number <= 100; ++number) one.say(packet(number, 100));
  run();
  EXPECT_THAT(taken, SizeIs(3));
  EXPECT_EQ(refused, 1u) << "not asked again before room()";
  std::vector<int> expected;
  for (int number = 1; number <= 100; ++number) expected.push_back(number);
  while (taken.size() < 100) {
    const auto before = taken.size();
    make_room(7);
    ASSERT_GT(taken.size(), before);
  }
  EXPECT_EQ(numbers(), expected);
  EXPECT_EQ(counted("packets-from-clients"), 100u);
  one.say(packet(101));
  space = 1000;
  run();
  EXPECT_EQ(taken.back(), packet(101)) << "read from again";
}

TEST_F(ForwarderTest, NoRoomReachesTheSender) {
  open();
  space = 0;
  Program one;
  one.greet(host);
  std::size_t said = 0;
  while (said < 10000 && one.stream->send(sent(packet(1, 114)))) {
    ++said;
    run(1ms);
  }
  EXPECT_LT(said, 2000u) << "it should have been told that it is busy";
  make_room(100000);
  run(10s);
  EXPECT_EQ(taken.size(), said);
}

TEST_F(ForwarderTest, ClientsThatWaitTakeTurns) {
  open();
  space = 0;
  Program greedy, modest;
  greedy.greet(host);
  modest.greet(host);
  run();
  for (std::uint8_t number = 1; number <= 50; ++number) greedy.say(packet(number));
  run();
  for (std::uint8_t number = 201; number <= 203; ++number) modest.say(packet(number));
  run();
  for (int i = 0; i < 2; ++i) make_room(1);
  EXPECT_THAT(numbers(), ElementsAre(1, 201));
  make_room(7);
  EXPECT_THAT(numbers(), ElementsAre(1, 201, 2, 202, 3, 203, 4, 5, 6)) << "also when there is room for several";
}

TEST_F(ForwarderTest, APacketDoesNotOvertakeAnothersThatWaits) {
  open();
  space = 0;
  Program one, two;
  one.greet(host);
  two.greet(host);
  run();
  one.say(packet(1));
  run();
  space = 10;  // but room() is not called yet
  two.say(packet(2));
  run();
  EXPECT_THAT(taken, IsEmpty());
  forwarder->room();
  EXPECT_THAT(numbers(), ElementsAre(1, 2));
}

TEST_F(ForwarderTest, WhatAClientSaidBeforeItHungUpStillReachesTheSink) {
  open();
  space = 1;
  Program one;
  one.greet(host);
  for (std::uint8_t number = 1; number <= 4; ++number) one.say(packet(number));
  run(1ms);
  one.stream.reset();
  run();
  EXPECT_EQ(forwarder->clients(), 0u);
  make_room(10);
  EXPECT_THAT(numbers(), ElementsAre(1, 2, 3, 4));
}

TEST_F(ForwarderTest, ClientsThatHungUpTakeNobodysPlaceAndDoNotPileUp) {
  ForwarderOptions options;
  options.clients = 2;
  open(options);
  space = 0;
  for (std::uint8_t number = 1; number <= 5; ++number) {
    Program passing;
    passing.greet(host);
    passing.say(packet(number));
    run(10ms);
    EXPECT_FALSE(passing.hung_up_on) << int{number};
    passing.stream.reset();
    run(10ms);
  }
  EXPECT_EQ(counted("refused-clients"), 0u);
  EXPECT_EQ(counted("dropped-gone"), 3u);
  make_room(10);
  EXPECT_THAT(numbers(), ElementsAre(1, 2)) << "what the first ones said is kept";
}

TEST_F(ForwarderTest, WhatTheSinkCouldNotTakeInTimeIsDroppedAndNothingElse) {
  open();
  space = 2;
  Program gone, stays, silent;
  for (auto* program : {&gone, &stays, &silent}) program->greet(host);
  run();
  for (std::uint8_t number = 1; number <= 4; ++number) gone.say(packet(number));
  run(10ms);
  stays.say(packet(11));
  stays.say(packet(12));
  run(10ms);
  gone.stream.reset();
  stays.say(packet(13));
  run(19900ms);
  EXPECT_EQ(counted("dropped-expired"), 0u);
  run(200ms);
  EXPECT_EQ(counted("dropped-expired"), 5u) << "3, 4, 11, 12, and 13, which nobody had read";
  run(1h);
  make_room(10);
  EXPECT_THAT(numbers(), ElementsAre(1, 2));
  stays.say(packet(14));
  silent.say(packet(21));
  run();
  EXPECT_THAT(numbers(), ElementsAre(1, 2, 14, 21)) << "read from again";
  EXPECT_FALSE(stays.hung_up_on);
}

/// An hour without a sink: what is then taken is no older than what may wait here and in the system's buffers.
TEST_F(ForwarderTest, AClientThatGoesOnWhileThereIsNoSinkIsNotHeardAnHourLater) {
  open();
  space = 0;
  Program one;
  one.greet(host);
  run();
  for (int minute = 0; minute < 60; ++minute) {
    one.say(packet(static_cast<std::uint8_t>(minute)));
    run(1min);
  }
  EXPECT_EQ(counted("dropped-expired"), 60u);
  one.say(packet(60));
  run(1s);
  make_room(100);
  EXPECT_THAT(numbers(), ElementsAre(60));
}

TEST_F(ForwarderTest, MoreClientsThanAllowedAreHungUpOn) {
  ForwarderOptions options;
  options.clients = 2;
  open(options);
  Program one, two, three;
  for (auto* program : {&one, &two, &three}) {
    program->greet(host);
    run(10ms);
  }
  EXPECT_FALSE(one.hung_up_on);
  EXPECT_FALSE(two.hung_up_on);
  EXPECT_TRUE(three.hung_up_on);
  EXPECT_EQ(counted("refused-clients"), 1u);
  one.stream.reset();
  run();
  Program four;
  four.greet(host);
  run();
  EXPECT_FALSE(four.hung_up_on) << "a place is free again";
}

/// A connection that broke while nothing was read from it: only sending tells.
class BrokenStream final : public transport::TcpStream {
 public:
  Result<void> send(ByteView) override {
    if (broken) return fail(ErrorCode::kUnreachable, "broken pipe");
    return {};
  }
  void hold(bool) override {}
  std::size_t queued() const override { return 0; }
  bool connected() const override { return true; }
  void abort() override {}
  transport::Endpoint local() const override { return {"127.0.0.1", 9002}; }
  transport::Endpoint remote() const override { return {"127.0.0.1", 40000}; }

  bool broken = false;
};

/// A port whose connections the test makes.
class OwnPort final : public transport::Transports {
 public:
  class Listener final : public transport::TcpListener {
    transport::Endpoint local() const override { return {"127.0.0.1", 9002}; }
  };
  Result<std::unique_ptr<transport::FileSource>> open_file(const std::string& path) override {
    return fail(ErrorCode::kNotFound, path);
  }
  Result<std::unique_ptr<transport::TcpListener>> listen_tcp(const transport::Endpoint&, transport::TcpAccept accepts,
                                                             transport::TcpDeaf) override {
    accept = std::move(accepts);
    return std::make_unique<Listener>();
  }

  transport::TcpAccept accept;
};

TEST_F(ForwarderTest, AHeldClientThatDiedIsNoticedWhenItIsSentTo) {
  OwnPort port;
  Forwarder held({}, time, port, {[](ByteView) { return false; }, {}, {}});
  ASSERT_TRUE(held.open());
  auto owned = std::make_unique<BrokenStream>();
  auto* const stream = owned.get();
  const auto calls = port.accept(std::move(owned));
  calls.received(kHello);
  calls.received(sent(packet(1)));
  held.tell(packet(2));
  EXPECT_EQ(held.clients(), 1u);
  stream->broken = true;
  held.tell(packet(3));
  EXPECT_EQ(held.clients(), 0u);
  EXPECT_EQ(held.counters().at("packets-to-clients"), 1u);
}

TEST_F(ForwarderTest, ALostPortIsToldTheClientsStayAndItCanBeOpenedAgain) {
  open();
  Program one;
  one.greet(host);
  run();
  net.tcp.deafen();
  run();
  ASSERT_THAT(failures, SizeIs(1));
  EXPECT_THAT(failures[0].text, HasSubstr("127.0.0.1:9002"));
  EXPECT_EQ(forwarder->local(), transport::Endpoint());
  forwarder->tell(packet(1));
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

TEST_F(ForwarderTest, ADestroyedForwarderHangsUpOnAll) {
  open();
  Program one, two;
  one.greet(host);
  two.connect(host);
  run();
  forwarder.reset();
  run(10s);
  EXPECT_TRUE(one.hung_up_on);
  EXPECT_TRUE(two.hung_up_on);
  EXPECT_EQ(net.tcp.open_streams(), 0u);
}

TEST_F(ForwarderTest, APacketThatNoLengthByteCanAnnounceIsForNobody) {
  open();
  Program one;
  one.greet(host);
  run();
  forwarder->tell({});
  forwarder->tell(Bytes(256, 1));
  forwarder->tell(Bytes(255, 1));
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
      EXPECT_FALSE(original.hung_up_on);
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
}  // namespace rubicon::networks::wsn
