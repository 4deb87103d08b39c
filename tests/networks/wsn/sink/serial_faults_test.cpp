#include <gmock/gmock.h>

#include <fstream>
#include <regex>
#include <sstream>

#include "networks/wsn/sink/sink_fixture.h"

namespace rubicon::networks::wsn::sink {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// What a serial line may bring that no sink should send (wsn.md 2 and 10).
class SerialFaults : public SerialSinkFixture {
 protected:
  void hear(std::string_view bytes) {
    mote.say_raw(hex(bytes));
    time.run_for(10ms);
  }
};

constexpr std::string_view kSound = "7e4500ffff000102221c0102dd2b7e";
const auto kOnePacket = hex("00ffff000102221c0102");

TEST_F(SerialFaults, PassOverGarbageBadSumsAndHalfFrames) {
  connect();
  hear("67617262616765");
  hear(kSound);
  hear("7e440900ffff000102221c0102544c7e");
  hear(kSound);
  hear("7e4500ffff00010222");
  hear(kSound);
  hear(kSound);
  EXPECT_THAT(received, ElementsAre(kOnePacket, kOnePacket, kOnePacket, kOnePacket));
  EXPECT_EQ(count("bad-crc"), 3U) << "what stands between two flags may be a frame";
  EXPECT_TRUE(noted("bad-crc"));
  EXPECT_THAT(mote.acks, IsEmpty());
}

TEST_F(SerialFaults, AreCountedByTheirKind) {
  connect();
  hear("7e01027e");
  hear("7e460b00ffff000102221c01020cea7e");
  hear("7e45007d7e");
  Bytes longest(300, 0x11);
  longest.front() = longest.back() = 0x7e;
  mote.say_raw(longest);
  time.run_for(10ms);
  mote.say(hex("01ffff000102221c0102"));
  time.run_for(10ms);
  hear(kSound);
  EXPECT_THAT(received, ElementsAre(kOnePacket));
  EXPECT_EQ(count("short-frames"), 1U);
  EXPECT_EQ(count("unknown-protocols"), 1U);
  EXPECT_EQ(count("broken-escapes"), 1U);
  EXPECT_EQ(count("long-frames"), 1U);
  EXPECT_EQ(count("unknown-dispatches"), 1U);
  EXPECT_EQ(count("packets-read"), 1U);
}

TEST_F(SerialFaults, LetFramesShareAFlag) {
  connect();
  hear("7e440c00ffff000102221c01025bc57e440d00ffff000102221c0102121d7e");
  EXPECT_THAT(received, ElementsAre(kOnePacket, kOnePacket));
  EXPECT_THAT(mote.acks, ElementsAre(0x0c, 0x0d));
}

TEST_F(SerialFaults, DeliverARepeatedFrameTwiceAndAckItTwice) {
  connect();
  hear("7e440700ffff000102221c01022f1f7e");
  hear("7e440700ffff000102221c01022f1f7e");
  EXPECT_THAT(received, ElementsAre(kOnePacket, kOnePacket));
  EXPECT_THAT(mote.acks, ElementsAre(0x07, 0x07));
}

TEST_F(SerialFaults, AckAnEmptyPacketAndDropIt) {
  connect();
  hear("7e44278d957e");
  EXPECT_THAT(received, IsEmpty());
  EXPECT_THAT(mote.acks, ElementsAre(0x27));
  EXPECT_EQ(count("unknown-dispatches"), 1U);
}

/// The rows that came from a serial line, as the C forwarder answered them: acks to the line, packets to its clients.
TEST_F(SerialFaults, AreAnsweredAsTheOfficialForwarderDid) {
  std::ifstream table(RUBICON_SOURCE_DIR "/../shared/data/motes/csf_faults.annot.txt");
  if (!table) GTEST_SKIP() << "no ../shared/data/motes/csf_faults.annot.txt beside the source tree";
  connect();
  static const std::regex kRow(R"((.*): wrote_pty=([0-9a-f]+) wrote_tcp=- -> pty=(\S+) tcp=(\S+))");
  std::size_t rows = 0;
  for (std::string line; std::getline(table, line);) {
    std::smatch row;
    if (!std::regex_match(line, row, kRow)) continue;
    ++rows;
    mote.raw.clear();
    received.clear();
    hear(row[2].str());
    Bytes clients;
    for (const auto& packet : received) {
      clients.push_back(static_cast<std::uint8_t>(packet.size()));
      clients.insert(clients.end(), packet.begin(), packet.end());
    }
    EXPECT_EQ(base::to_hex(mote.raw), row[3] == "-" ? "" : row[3].str()) << row[1];
    EXPECT_EQ(base::to_hex(clients), row[4] == "-" ? "" : row[4].str()) << row[1];
  }
  EXPECT_EQ(rows, 13U);
}

TEST_F(SerialFaults, GiveTheSameInPiecesOfAnySize) {
  std::vector<Bytes> whole;
  for (const std::size_t piece : {0U, 1U, 3U, 7U}) {
    net.tcp.segment = piece;
    received.clear();
    connect();
    hear(std::string("6761727e7e7e") + std::string(kSound) + "7e440c00ffff000102221c01025bc57e440d00ffff0001022200" +
         std::string(kSound));
    if (piece == 0) whole = received;
    EXPECT_EQ(received, whole) << piece;
    sink.reset();
    time.run_for(1s);
  }
  EXPECT_EQ(whole.size(), 3U);
}

/// Ten times the line's rate: 900 packets a second, while each command waits for its ack among them.
TEST_F(SerialFaults, FloodDoesNotStarveSending) {
  connect();
  mote.ack_delay = 5ms;
  std::function<void()> flood = [&] {
    for (int i = 0; i < 9; ++i) mote.say(numbered(3));
    reopening = time.after(10ms, flood);
  };
  flood();
  for (std::uint16_t i = 0; i < 100; ++i) {
    const auto before = mote.heard.size();
    ASSERT_TRUE(send(i));
    time.run_for(net.tcp.transit);
    EXPECT_EQ(mote.heard.size(), before + 1) << i;
    time.run_for(20ms);
    EXPECT_EQ(outcome(i), SendResult::kAcknowledged) << i;
  }
  reopening.cancel();
  time.run_for(1s);
  EXPECT_GT(received.size(), 1500U);
  EXPECT_EQ(count("packets-read"), received.size());
}

/// The line takes none of our bytes while the sink floods us: acks wait up to a bound, the others are not sent.
TEST_F(SerialFaults, FloodOfWhatWantsAcksDoesNotFillTheMemory) {
  SendQueue queue(time, 8, {[] {}, [](Lane) {}});
  SinkNotifier notifier(calls());
  std::size_t waits = 0, most = 0;
  SerialLink::Callbacks line;
  line.write = [&](ByteView bytes) { most = std::max(most, waits += bytes.size()); };
  line.unwritten = [&] { return waits; };
  line.heard = [] {};
  line.acknowledges = [](bool) {};
  line.failed = [](const Error&) {};
  SerialLink link({}, time, queue, notifier, std::move(line));
  link.begin();
  const auto frame = motes::hdlc_acked_packet(1, kOnePacket);
  const auto unsent = [&] {
    std::map<std::string, std::uint64_t> counters;
    link.count(counters);
    return counters.at("unsent-acks");
  };
  for (int i = 0; i < 4000; ++i) link.take(frame);
  EXPECT_EQ(received.size(), 4000U) << "packets are delivered all the same";
  const auto ack = motes::hdlc_ack(1).size();
  EXPECT_GT(most, SerialLink::kMaxUnwritten);
  EXPECT_LE(most, SerialLink::kMaxUnwritten + ack);
  EXPECT_EQ(unsent(), 4000 - most / ack);
  EXPECT_TRUE(noted("unsent-acks"));
  waits = 0;
  link.take(frame);
  EXPECT_EQ(waits, ack) << "sent again once the line takes them";
}

TEST_F(SerialFaults, ASinkThatGoesMuteIsALostLine) {
  connect();
  reopens = false;
  mote.answers = false;
  for (std::uint16_t i = 0; i < 4; ++i) ASSERT_TRUE(send(i));
  time.run_for(8900ms);
  EXPECT_THAT(failures, IsEmpty()) << "three packets, three attempts each";
  time.run_for(200ms);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_THAT(failures[0].text, testing::HasSubstr("the sink stopped answering"));
  EXPECT_EQ(failures[0].code, ErrorCode::kUnreachable);
  EXPECT_EQ(phase(), Phase::kOff);
  for (std::uint16_t i = 0; i < 3; ++i) EXPECT_EQ(outcome(i), SendResult::kNotAcknowledged) << i;
  EXPECT_EQ(outcome(3), std::nullopt) << "waiting packets stay";
  mote.answers = true;
  mote.executed.clear();
  ASSERT_TRUE(sink->open());
  time.run_for(1s);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_THAT(mote.executed, ElementsAre(set_island(42), numbered(3)));
}

TEST_F(SerialFaults, ASinkThatDoesNotAckButSpeaksIsNoLostLine) {
  connect();
  mote.answers = false;
  for (std::uint16_t i = 0; i < 10; ++i) {
    ASSERT_TRUE(send(i));
    if (i % 2 == 1) mote.say(numbered(1));
    time.run_for(3100ms);
    EXPECT_EQ(outcome(i), SendResult::kNotAcknowledged) << i;
  }
  EXPECT_THAT(failures, IsEmpty());
  EXPECT_EQ(phase(), Phase::kUp);
}

TEST_F(SerialFaults, SayingNothingForAnHourIsNoFault) {
  connect();
  time.run_for(1h);
  EXPECT_EQ(phase(), Phase::kUp);
  EXPECT_THAT(failures, IsEmpty());
}

}  // namespace
}  // namespace rubicon::networks::wsn::sink
