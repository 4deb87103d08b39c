#include <gmock/gmock.h>

#include <array>

#include "networks/wsn/share/forwarder_fixture.h"

namespace rubicon::networks::wsn::share {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

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
  std::size_t sent_count = 0;
  while (sent_count < 10000 && one.stream->send(sent(packet(1, 114)))) {
    ++sent_count;
    run(1ms);
  }
  EXPECT_LT(sent_count, 2000u) << "the connection should have refused more";
  make_room(100000);
  run(10s);
  EXPECT_EQ(taken.size(), sent_count);
}

/// A sink takes some sixteen packets a second: the last of a thousand waits for a minute, and is not late.
TEST_F(ForwarderTest, ABusySinkIsNoReasonToDropWhatWaitsForIt) {
  open();
  space = 0;
  std::array<Program, 5> programs;
  for (auto& program : programs) {
    program.greet(host);
    for (std::uint8_t number = 1; number <= 200; ++number) program.say(packet(number));
  }
  run();
  for (int i = 0; i < 1000; ++i) {
    make_room(1);
    run(62ms);
  }
  EXPECT_EQ(taken.size(), 1000u);
  EXPECT_EQ(counted("dropped-expired"), 0u);
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
  forwarder->resume();
  EXPECT_THAT(numbers(), ElementsAre(1, 2));
}

TEST_F(ForwarderTest, PacketsOfADisconnectedClientStillReachTheSink) {
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

TEST_F(ForwarderTest, DisconnectedClientsTakeNoPlaceAndAreLimited) {
  ForwarderOptions options;
  options.clients = 2;
  open(options);
  space = 0;
  for (std::uint8_t number = 1; number <= 5; ++number) {
    Program passing;
    passing.greet(host);
    passing.say(packet(number));
    run(10ms);
    EXPECT_FALSE(passing.disconnected) << int{number};
    passing.stream.reset();
    run(10ms);
  }
  EXPECT_EQ(counted("refused-clients"), 0u);
  EXPECT_EQ(counted("dropped-gone"), 3u);
  make_room(10);
  EXPECT_THAT(numbers(), ElementsAre(1, 2)) << "packets of the first ones are kept";
}

TEST_F(ForwarderTest, OnlyPacketsThatTheSinkDidNotTakeInTimeAreDropped) {
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
  EXPECT_EQ(counted("dropped-expired"), 5u) << "3, 4, 11, 12, and 13, which was not read yet";
  run(1h);
  make_room(10);
  EXPECT_THAT(numbers(), ElementsAre(1, 2));
  stays.say(packet(14));
  silent.say(packet(21));
  run();
  EXPECT_THAT(numbers(), ElementsAre(1, 2, 14, 21)) << "read from again";
  EXPECT_FALSE(stays.disconnected);
}

/// An hour without a sink: what is then taken is no older than what may wait here and in the system's buffers.
TEST_F(ForwarderTest, PacketsSentWhileThereIsNoSinkAreNotExecutedAnHourLater) {
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

/// A connection that broke while nothing was read from it: only sending detects it.
class BrokenStream final : public transport::TcpStream {
 public:
  Result<void> send(ByteView) override {
    if (broken) return fail(ErrorCode::kUnreachable, "broken pipe");
    return {};
  }
  void hold(bool) override {}
  std::size_t queued() const override { return 0; }
  bool connected() const override { return true; }
  std::size_t unacknowledged() const override { return 0; }
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
                                                             transport::ListenerFailed) override {
    accept = std::move(accepts);
    return std::make_unique<Listener>();
  }

  transport::TcpAccept accept;
};

TEST_F(ForwarderTest, AHeldClientThatDiedIsDetectedWhenSending) {
  OwnPort port;
  Forwarder held({}, time, port, {[](ByteView) { return false; }, {}, {}});
  ASSERT_TRUE(held.open());
  auto owned = std::make_unique<BrokenStream>();
  auto* const stream = owned.get();
  const auto calls = port.accept(std::move(owned));
  calls.received(kHello);
  calls.received(sent(packet(1)));
  held.broadcast(packet(2));
  EXPECT_EQ(held.clients(), 1u);
  stream->broken = true;
  held.broadcast(packet(3));
  EXPECT_EQ(held.clients(), 0u);
  EXPECT_EQ(held.counters().at("packets-to-clients"), 1u);
}

}  // namespace
}  // namespace rubicon::networks::wsn::share
