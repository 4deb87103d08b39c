#include <gmock/gmock.h>

#include <fstream>
#include <iterator>

#include "simulators/motes/simulated_sink.h"

namespace rubicon::motes_simulator {
namespace {

using ::testing::ElementsAre;

Bytes shared_file(const std::string& name) {
  std::ifstream file(RUBICON_SOURCE_DIR "/../shared/data/motes/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<Came> frames_of(ByteView bytes) {
  motes::HdlcReader reader;
  std::vector<Came> all;
  while (auto frame = reader.next(bytes))
    all.push_back({frame->protocol, frame->sequence, {frame->packet.begin(), frame->packet.end()}, {}});
  return all;
}

std::size_t length_of(const Came& packet) {
  const auto net = packet.net();
  return net.transport == motes::kTransportAck ? 4 : 100;  // stale memory follows an acknowledgement
}

/// Packets of one mote in hex, stale bytes cut off.
std::vector<std::string> of_mote(const std::vector<Came>& frames, std::uint16_t mote) {
  std::vector<std::string> all;
  for (const auto& one : frames) {
    if (one.protocol == motes::kHdlcPacket && one.net().source_mote == mote)
      all.push_back(base::to_hex(ByteView(one.packet).first(8 + 14 + length_of(one))));
  }
  return all;
}

/// The recordings of the original firmware: the input is what the computer sent, the expected output what the sink
/// sent.
class Replay : public SimulatedSink {
 protected:
  void play(const std::string& name, Duration gap) {
    for (const auto& frame : frames_of(shared_file(name))) {
      const auto before = acks().size();
      send(motes::hdlc_acked_packet(frame.sequence, frame.packet));
      for (int i = 0; i < 1000 && acks().size() == before; ++i) time.run_for(1ms);
      time.run_for(gap);
    }
  }
};

TEST_F(Replay, GivesWhatTheOriginalJavaSawByteForByte) {
  const auto recorded = frames_of(shared_file("origjava_uart_mote2pc.bin"));
  if (recorded.empty()) GTEST_SKIP() << "no ../shared/data/motes beside the source tree";
  auto options = plain();
  options.first_boot = 1s;
  make(options);
  // Its LOG has 3007 and 3008 ms between the commands, some 60 of them until the acknowledgement.
  play("origjava_uart_pc2mote.bin", 2947ms);
  time.run_for(20s);
  // Which mote's message comes first depends on when the original's computer sent; each mote's own do not.
  for (const auto mote : {std::uint16_t{2}, std::uint16_t{3}}) {
    const auto expected = of_mote(recorded, mote);
    auto got = of_mote(came, mote);
    ASSERT_GE(got.size(), expected.size());
    got.resize(expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(got[i], expected[i]) << "mote " << mote << ", " << i;
  }
}

TEST_F(Replay, GivesWhatTheEmulatedSinkSaidToTheForwarder) {
  const auto recorded = frames_of(shared_file("avr_sink_uart_mote2pc.bin"));
  if (recorded.empty()) GTEST_SKIP() << "no ../shared/data/motes beside the source tree";
  make(plain());
  time.run_for(3s);
  play("avr_sink_uart_pc2mote.bin", 1s);
  time.run_for(3s);
  EXPECT_THAT(acks(), ElementsAre(0x26, 0x27, 0x28, 0x29, 0x2a, 0x2b, 0x2c, 0x2d));
  // Joins, and the first report of mote 2 and acknowledgement of mote 3: the same bytes.
  for (const auto mote : {std::uint16_t{2}, std::uint16_t{3}}) {
    const auto expected = of_mote(recorded, mote);
    const auto got = of_mote(came, mote);
    ASSERT_GE(got.size(), 2u);
    EXPECT_EQ(got[0], expected[0]);
    EXPECT_EQ(got[1], expected[1]);
  }
  EXPECT_EQ(of_mote(came, 1), of_mote(recorded, 1)) << "the sink's own acknowledgement, sequence number included";
  EXPECT_THAT(acknowledged(1), ElementsAre(0x0106));
  // beef twice: the truncated command and the next; the recording lost the acknowledgement of the second.
  EXPECT_THAT(acknowledged(3), ::testing::IsSupersetOf({0xbeef, 0x0102, 0x0103}));
}

TEST_F(Replay, GivesTheRampsAndTheFloodOfTheTruncatedCommand) {
  if (shared_file("avr_sink_uart_pc2mote.bin").empty()) GTEST_SKIP() << "no ../shared/data/motes";
  make(plain());
  time.run_for(3s);
  play("avr_sink_uart_pc2mote.bin", 1s);
  const auto recorded = frames_of(shared_file("avr_sink_uart_mote2pc.bin"));
  for (const auto* frames : {&recorded, static_cast<const std::vector<Came>*>(&came)}) {
    for (const auto& one : *frames) {
      if (one.protocol != motes::kHdlcPacket || one.net().transport != motes::kTransportConnectionless) continue;
      const auto record = motes::decode_record(one.net()).value();
      const auto* report = std::get_if<motes::DemoReport>(&record);
      if (report == nullptr) continue;
      const int readings = report->temperature - 6500;
      EXPECT_EQ(report->light, static_cast<std::uint16_t>(300 + 7 * readings));
    }
  }
  // About 20 reports a second, each after about 170 readings.
  const auto light = lights(3);
  ASSERT_GT(light.size(), 15u);
  const double jump = static_cast<double>(light[14] - light[0]) / 14 / 7;
  EXPECT_GT(jump, 110);
  EXPECT_LT(jump, 231);
}

}  // namespace
}  // namespace rubicon::motes_simulator
