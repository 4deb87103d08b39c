#include "networks/knx/line/line_fixture.h"

namespace rubicon::networks::knx::line {
namespace {

using Phase = LineState::Phase;

/// Tunnels over TCP.
class StreamTest : public LineFixture {
 protected:
  StreamTest() { options.via = TunnelOptions::Via::kTcp; }
  /// Opens without waiting for more than a moment.
  void open() {
    make_line();
    ASSERT_TRUE(line->open());
    time.run_for(100ms);
  }
};

TEST_F(StreamTest, ATunnelOverTcpNeedsNoAcks) {
  connect();
  for (std::uint16_t i = 0; i < 300; ++i) send(i);
  server->inject(0x1101, 0x0a08, 0x80, {1, 2});
  time.run_for(2s);
  EXPECT_EQ(order.size(), 300U);
  EXPECT_EQ(count("telegrams-sent"), 300U);
  EXPECT_EQ(received.size(), 1U);
  EXPECT_EQ(server->counters.acks, 0U);
  time.run_for(61s);
  EXPECT_EQ(server->counters.heartbeats, 1U);
}

TEST_F(StreamTest, FramesArriveByteByByteAndSeveralAtOnce) {
  net.tcp.segment = 1;
  connect();
  send(1);
  for (std::uint8_t i = 0; i < 20; ++i) server->inject(0x1101, 0x0a08, 0x80, {1, i});
  time.run_for(1s);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  EXPECT_EQ(received.size(), 20U);
  net.tcp.segment = 0;
  for (std::uint8_t i = 0; i < 20; ++i) server->inject(0x1101, 0x0a08, 0x80, {1, i});
  time.run_for(1s);
  EXPECT_EQ(received.size(), 40U);
  EXPECT_EQ(received.back().payload.bytes, (Bytes{1, 19}));
  EXPECT_EQ(count("bad-frames"), 0U);
}

TEST_F(StreamTest, AStreamWithAnInvalidHeaderIsClosed) {
  connect();
  server->send_raw({6, 0x11, 4, 0x20, 0, 8});
  time.run_for(100ms);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_NE(failures[0].text.find("version 11"), std::string::npos);
  time.run_for(1s);
  EXPECT_EQ(phase(), Phase::kUp);
}

TEST_F(StreamTest, ABrokenConnectionIsALostLineAndWhatWasUnderWayIsSentOnceMore) {
  connect();
  server->confirms = false;
  send(1);
  time.run_for(100ms);
  server->confirms = true;
  net.tcp.cut();
  time.run_for(10ms);
  EXPECT_EQ(failures.size(), 1U);
  time.run_for(1s);
  EXPECT_EQ(sent(1), SendOutcome::kSent);
  EXPECT_EQ(arrivals()[1], 2);
}

TEST_F(StreamTest, AClosedPortIsAFailureAndTheServerFoundWhenItStarts) {
  make_server();
  server->stop();
  open();
  EXPECT_EQ(failures.size(), 1U);
  server->start();
  time.run_for(1s);
  EXPECT_EQ(phase(), Phase::kUp);
}

TEST_F(StreamTest, DestructionClosesTheTunnel) {
  connect();
  line.reset();
  time.run_for(100ms);
  EXPECT_TRUE(server->channels().empty());
  EXPECT_EQ(server->counters.disconnects, 1U);
}

TEST_F(StreamTest, TelegramsToADeadPeerAreNotSentAfterTheirLifetime) {
  connect();
  net.tcp.stall(true);
  for (std::uint16_t i = 1; i <= 20; ++i) send(i, 5s);
  time.run_for(5900ms);
  EXPECT_EQ(phase(), Phase::kUp) << "one is under way and nothing is heard: the next ones are held";
  time.run_for(200ms);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_NE(failures[0].text.find("stopped responding"), std::string::npos) << failures[0].text;
  EXPECT_EQ(sent(1), SendOutcome::kLost);
  for (std::uint16_t i = 2; i <= 20; ++i) EXPECT_EQ(sent(i), SendOutcome::kExpired);
  time.run_for(5s);
  net.tcp.stall(false);
  time.run_for(60s);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_TRUE(server->heard().empty()) << server->heard().size();
}

TEST_F(StreamTest, MissingConfirmationsDoNotMakeTheBusSilent) {
  connect();
  server->confirms = false;
  for (std::uint16_t i = 1; i <= 3; ++i) send(i);
  time.run_for(10s);
  EXPECT_EQ(outcomes[1].why, "the interface did not confirm that it was sent to the bus");
  EXPECT_TRUE(line->state().bus);
  EXPECT_EQ(line->state().reason, "the interface did not confirm three telegrams in a row");
  server->confirms = true;
  send(4);
  time.run_for(1s);
  EXPECT_EQ(line->state().reason, "");
}

TEST_F(StreamTest, AMissingConfirmationOfALivePeerIsReportedAfterThreeSeconds) {
  connect();
  server->confirms = false;
  send(1);
  time.run_for(2900ms);
  EXPECT_TRUE(outcomes.empty());
  time.run_for(200ms);
  EXPECT_EQ(sent(1), SendOutcome::kUnconfirmed);
  EXPECT_EQ(server->counters.heartbeats, 1U) << "it was asked whether it lives";
  server->answers_heartbeats = false;
  send(2);
  time.run_for(4s);
  EXPECT_FALSE(outcomes.contains(2)) << "held";
  server->inject(0x1101, 0x0a08, 0x80, {1, 2});
  time.run_for(100ms);
  EXPECT_EQ(sent(2), SendOutcome::kUnconfirmed) << "something was heard";
  EXPECT_TRUE(failures.empty());
}

}  // namespace
}  // namespace rubicon::networks::knx::line
