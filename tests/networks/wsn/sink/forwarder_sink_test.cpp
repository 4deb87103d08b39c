#include "networks/wsn/sink/stream_sinks.h"

#include <gmock/gmock.h>

#include "networks/wsn/sink/sink_fixture.h"

namespace rubicon::networks::wsn::sink {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class ForwarderSinkTest : public SinkTold {
 protected:
  ForwarderSinkTest() {
    options.source = parse_source("sf@10.0.0.9:9002").value();
    listener = net.tcp.listen({"10.0.0.9", 9002}, [this](auto accepted) {
      stream = std::move(accepted);
      transport::TcpCallbacks calls;
      calls.received = [this](ByteView bytes) {
        heard.insert(heard.end(), bytes.begin(), bytes.end());
        heard_at.push_back(time.now());
      };
      calls.failed = [this](const Error&) { stream.reset(); };
      say(greeting);
      return calls;
    });
  }

  void say(ByteView bytes) {
    if (bytes.empty()) return;
    ASSERT_TRUE(stream && stream->send(bytes));
  }
  void make() { sink = make_sink(options, time, transports, calls()); }
  void connect() {
    make();
    ASSERT_TRUE(sink->open());
    time.run_for(1s);
    ASSERT_EQ(phase(), Phase::kUp) << sink->state().reason;
  }
  /// Fails on what the peer sent.
  Error failure(const Bytes& first, const Bytes& then = {}) {
    reopens = false;
    greeting = first;
    make();
    EXPECT_TRUE(sink->open());
    time.run_for(1s);
    if (!then.empty()) say(then);
    time.run_for(10s);
    EXPECT_EQ(failures.size(), 1U);
    EXPECT_EQ(phase(), Phase::kOff);
    EXPECT_EQ(stream, nullptr) << "disconnected";
    return failures.empty() ? Error{} : failures.front();
  }

  Bytes greeting = hex("5520");
  std::unique_ptr<transport::MemoryListener> listener;
  std::unique_ptr<transport::TcpStream> stream;
  Bytes heard;
  std::vector<SteadyTime> heard_at;
};

TEST_F(ForwarderSinkTest, GreetsAtOnceThenSendsTheFirstPacket) {
  options.greeting = set_island(0x7d7e);
  greeting.clear();
  make();
  ASSERT_TRUE(sink->open());
  time.run_for(1s);
  EXPECT_EQ(base::to_hex(heard), "5520");
  EXPECT_EQ(phase(), Phase::kConnecting);
  say(hex("5520"));
  time.run_for(1s);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_EQ(base::to_hex(heard), "55200b00000100000300250a7d7e");
  EXPECT_THAT(left, ElementsAre(set_island(0x7d7e)));
}

TEST_F(ForwarderSinkTest, DeliversPacketsInPiecesOfAnySize) {
  net.tcp.segment = 1;
  connect();
  say(hex("0a00ffff000102221c01020a00ffff000102221c0103"));
  time.run_for(10ms);
  EXPECT_THAT(received, ElementsAre(hex("00ffff000102221c0102"), hex("00ffff000102221c0103")));
}

TEST_F(ForwarderSinkTest, DeliversWhatCameWithTheGreeting) {
  greeting = hex("55200a00ffff000102221c0102");
  connect();
  EXPECT_THAT(received, ElementsAre(hex("00ffff000102221c0102")));
}

TEST_F(ForwarderSinkTest, LeavesATenthOfASecondBetweenPackets) {
  connect();
  heard_at.clear();
  for (std::uint16_t i = 0; i < 10; ++i) ASSERT_TRUE(send(i));
  time.run_for(850ms);
  EXPECT_EQ(results.size(), 9U);
  time.run_for(5s);
  ASSERT_EQ(heard_at.size(), 10U);
  for (std::size_t i = 1; i < heard_at.size(); ++i) EXPECT_GE(heard_at[i] - heard_at[i - 1], 100ms);
  for (std::uint16_t i = 0; i < 10; ++i) EXPECT_EQ(outcome(i), SendResult::kAcknowledged);
  EXPECT_EQ(count("acknowledged"), 11U);
}

TEST_F(ForwarderSinkTest, SendsACommandInTheNextTurnAfterAPause) {
  connect();
  ASSERT_TRUE(send(1));
  EXPECT_EQ(left.size(), 1U);
  time.run_ready();
  EXPECT_EQ(left.size(), 2U);
}

TEST_F(ForwarderSinkTest, TakesANewerVersion) {
  greeting = hex("5521");
  connect();
}

TEST_F(ForwarderSinkTest, RefusesAnOlderVersion) {
  EXPECT_THAT(failure(hex("551f")).text, HasSubstr("version 1f of the serial-forwarder protocol, expected 20"));
}

TEST_F(ForwarderSinkTest, RefusesAnotherProtocol) {
  EXPECT_THAT(failure(base::from_hex("485454502f").value()).text, HasSubstr("not the serial-forwarder protocol"));
}

TEST_F(ForwarderSinkTest, RefusesAPacketOfLengthZero) {
  const auto why = failure(hex("5520"), hex("0a00ffff000102221c010200"));
  EXPECT_THAT(why.text, HasSubstr("sf@10.0.0.9:9002: a packet of 0 bytes"));
  EXPECT_EQ(received.size(), 1U) << "what came before is good";
}

TEST_F(ForwarderSinkTest, WaitsTenSecondsForAGreeting) {
  greeting.clear();
  reopens = false;
  make();
  ASSERT_TRUE(sink->open());
  time.run_for(9900ms);
  EXPECT_THAT(failures, IsEmpty());
  time.run_for(200ms);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_THAT(failures[0].text, HasSubstr("no greeting"));
}

TEST_F(ForwarderSinkTest, KeepsWhatWaitsOverALostConnection) {
  connect();
  for (std::uint16_t i = 0; i < 5; ++i) ASSERT_TRUE(send(i));
  time.run_for(150ms);
  stream.reset();
  time.run_for(100ms);
  ASSERT_EQ(failures.size(), 1U);
  heard.clear();
  time.run_for(5s);
  EXPECT_EQ(results.size(), 5U);
  EXPECT_EQ(base::to_hex(heard).substr(0, 28), "55200b00000100000300250a002a") << "the greeting goes first again";
}

TEST_F(ForwarderSinkTest, SendsNothingToAForwarderThatDoesNotRead) {
  connect();
  net.tcp.stall(true);
  for (std::uint16_t i = 0; i < 5; ++i) ASSERT_TRUE(send(i, {Lane::kCommand, 5s}));
  time.run_for(10s);
  EXPECT_EQ(count("acknowledged"), 2U) << "the greeting, and what was handed over before that showed";
  EXPECT_EQ(outcome(4), SendResult::kExpired);
}

TEST_F(ForwarderSinkTest, DropsWhatIsNoSerialAm) {
  connect();
  say(hex("0201ff0a00ffff000102221c0102"));
  time.run_for(10ms);
  EXPECT_EQ(received.size(), 1U);
  EXPECT_EQ(count("unknown-dispatches"), 1U);
}

TEST_F(ForwarderSinkTest, MayBeDestroyedInEachOfItsCalls) {
  for (int call = 0; call < 2; ++call) {
    on_received = on_left = nullptr;
    connect();
    if (call == 0) on_received = [&] { sink.reset(); };
    if (call == 1) on_left = [&] { sink.reset(); };
    ASSERT_TRUE(send(static_cast<std::uint16_t>(call)));
    say(hex("0a00ffff000102221c01020a00ffff000102221c0103"));
    time.run_for(1s);
    EXPECT_EQ(sink, nullptr) << call;
  }
}

}  // namespace
}  // namespace rubicon::networks::wsn::sink
