#include <gmock/gmock.h>

#include <map>

#include "motes/framing.h"
#include "motes/mote_records.h"
#include "motes/mote_vectors.h"
#include "motes/serial_lines.h"

namespace rubicon::motes {
namespace {

/// Vectors of the shared data; skipped where they are absent.
class HdlcVectors : public testing::Test {
 protected:
  void SetUp() override {
    vectors_ = shared_vectors();
    if (vectors_.empty()) GTEST_SKIP() << "no ../shared/data/motes/vectors.tsv beside the source tree";
  }

  std::vector<Vector> vectors_;
};

TEST_F(HdlcVectors, FramesAreReadAndWrittenByteForByte) {
  std::size_t frames = 0;
  for (const Vector& vector : vectors_) {
    if (vector.kind != "hdlc" || vector.name == "java-unk" || vector.name == "unknown-46-reply") continue;
    const auto heard = heard_in(vector.bytes);
    ASSERT_EQ(heard.size(), 1u) << vector.name;
    EXPECT_EQ(base::to_hex(written(heard[0])), base::to_hex(vector.bytes)) << vector.name;
    ++frames;
  }
  EXPECT_EQ(frames, 83u);
}

TEST_F(HdlcVectors, UnsoundFramesAndUnknownProtocolsGiveNothing) {
  const std::map<std::string, HdlcFaults> expected{
      {"bad-crc", {.bad_crc = 1}}, {"java-unk", {.unknown_protocols = 1}}, {"unknown-46-reply", {}}};
  std::size_t met = 0;
  for (const Vector& vector : vectors_) {
    const auto fault = expected.find(vector.name);
    EXPECT_TRUE(vector.kind != "hdlc-bad" || fault != expected.end()) << vector.name;
    if (fault == expected.end()) continue;
    HdlcReader reader;
    std::vector<Heard> heard;
    hear(reader, vector.bytes, heard);
    EXPECT_TRUE(heard.empty()) << vector.name;
    EXPECT_EQ(reader.faults(), fault->second) << vector.name;
    ++met;
  }
  EXPECT_EQ(met, expected.size());
}

TEST_F(HdlcVectors, StreamsGiveTheirFramesAsTheSameFramesAlone) {
  const std::map<std::string, std::vector<std::uint8_t>> expected{{"shared-flag", {0x0c, 0x0d}},
                                                                  {"garbage-then-frame", {0x0e}}};
  std::size_t met = 0;
  for (const Vector& vector : vectors_) {
    if (vector.kind != "stream") continue;
    ASSERT_TRUE(expected.contains(vector.name)) << vector.name;
    std::vector<std::uint8_t> sequences;
    for (const Heard& heard : heard_in(vector.bytes)) {
      sequences.push_back(heard.sequence);
      EXPECT_EQ(base::to_hex(heard.packet), "00ffff000102221c0102") << vector.name;
      // Alone it has both flags: the same bytes from the protocol byte on.
      const auto alone = base::to_hex(written(heard));
      EXPECT_NE(base::to_hex(vector.bytes).find(alone.substr(2)), std::string::npos) << vector.name;
    }
    EXPECT_EQ(sequences, expected.at(vector.name)) << vector.name;
    ++met;
  }
  EXPECT_EQ(met, expected.size());
}

/// The table of faults offered to the C forwarder: `name: wrote_pty=hex wrote_tcp=hex -> pty=hex tcp=hex`.
struct FaultRow {
  std::string name;
  Bytes wrote_pty, wrote_tcp, pty, tcp;
};

std::vector<FaultRow> fault_rows() {
  std::ifstream file(RUBICON_SOURCE_DIR "/../shared/data/motes/csf_faults.annot.txt");
  std::vector<FaultRow> rows;
  for (std::string line; std::getline(file, line);) {
    const auto column = [&line](const std::string& key) {
      const auto at = line.find(" " + key + "=") + key.size() + 2;
      const auto text = line.substr(at, line.find(' ', at) - at);
      return text == "-" ? Bytes{} : hex(text);
    };
    rows.push_back(
        {line.substr(0, line.find(": wrote")), column("wrote_pty"), column("wrote_tcp"), column("pty"), column("tcp")});
  }
  return rows;
}

TEST(HdlcFaultTable, WhatIsHeardIsWhatTheOfficialForwarderPassedOn) {
  const auto rows = fault_rows();
  if (rows.empty()) GTEST_SKIP() << "no ../shared/data/motes/csf_faults.annot.txt beside the source tree";
  HdlcReader reader;
  std::size_t from_serial = 0;
  for (const FaultRow& row : rows) {
    if (row.wrote_pty.empty()) continue;
    std::vector<Heard> heard;
    hear(reader, row.wrote_pty, heard);
    Bytes passed_on, answers;
    for (const Heard& one : heard) {
      passed_on = passed_on + forwarder_packet(one.packet);
      if (one.protocol == kHdlcAckedPacket) answers = answers + hdlc_ack(one.sequence);
    }
    EXPECT_EQ(base::to_hex(passed_on), base::to_hex(row.tcp)) << row.name;
    EXPECT_EQ(base::to_hex(answers), base::to_hex(row.pty)) << row.name;
    ++from_serial;
  }
  EXPECT_EQ(from_serial, 13u);
  // The text before a flag follows another one here: a frame with a wrong CRC.
  EXPECT_EQ(reader.faults(), (HdlcFaults{.bad_crc = 2, .too_short = 1, .too_long = 2, .unknown_protocols = 1}));
}

TEST(HdlcFaultTable, WhatClientsSendIsFramedAsTheOfficialForwarderFramesIt) {
  const auto rows = fault_rows();
  if (rows.empty()) GTEST_SKIP() << "no ../shared/data/motes/csf_faults.annot.txt beside the source tree";
  std::size_t from_tcp = 0;
  for (const FaultRow& row : rows) {
    if (row.wrote_tcp.size() < 3) continue;  // the greeting, and the empty packet that is never passed on
    ForwarderReader reader;
    ByteView bytes(kForwarderHello);
    ASSERT_TRUE(reader.next(bytes).has_value());
    bytes = row.wrote_tcp;
    const auto packet = reader.next(bytes);
    ASSERT_TRUE(packet && *packet) << row.name;
    const std::uint8_t sequence = row.pty.at(2);
    EXPECT_EQ(base::to_hex(hdlc_acked_packet(sequence, **packet)), base::to_hex(row.pty)) << row.name;
    ++from_tcp;
  }
  EXPECT_EQ(from_tcp, 2u);
}

/// A recording of one direction of a serial line, and what is in it.
struct Recording {
  std::string file;
  std::size_t bytes, acks, acked_packets, packets;
  std::uint8_t first_sequence;
};

const Recording kRecordings[] = {
    {"avr_sink_uart_mote2pc.bin", 7291, 8, 0, 57, 0x26}, {"avr_sink_uart_pc2mote.bin", 260, 0, 8, 0, 0x26},
    {"origjava_uart_mote2pc.bin", 4725, 4, 0, 37, 0x26}, {"origjava_uart_pc2mote.bin", 402, 0, 4, 0, 0x26},
    {"csf_serial_host2mote.bin", 25, 1, 1, 0, 0x26},     {"javasf_serial_host2mote.bin", 40, 1, 2, 0, 0x0e},
};

class HdlcRecordings : public testing::TestWithParam<Recording> {
 protected:
  void SetUp() override {
    bytes_ = recorded(GetParam().file);
    if (bytes_.empty()) GTEST_SKIP() << "no ../shared/data/motes/" << GetParam().file << " beside the source tree";
    whole_ = heard_in(bytes_);
  }

  Bytes bytes_;
  std::vector<Heard> whole_;
};

TEST_P(HdlcRecordings, HoldTheDocumentedFramesWithoutAFault) {
  const Recording& recording = GetParam();
  EXPECT_EQ(bytes_.size(), recording.bytes);
  std::map<std::uint8_t, std::size_t> counts;
  std::vector<std::uint8_t> sequences;
  for (const Heard& heard : whole_) {
    ++counts[heard.protocol];
    const bool numbered = recording.acked_packets > 0 ? heard.protocol == kHdlcAckedPacket : heard.protocol == kHdlcAck;
    if (numbered) sequences.push_back(heard.sequence);
  }
  EXPECT_EQ(counts[kHdlcAck], recording.acks);
  EXPECT_EQ(counts[kHdlcAckedPacket], recording.acked_packets);
  EXPECT_EQ(counts[kHdlcPacket], recording.packets);
  for (std::size_t i = 0; i < sequences.size(); ++i)
    EXPECT_EQ(sequences[i], static_cast<std::uint8_t>(recording.first_sequence + i));
  HdlcReader reader;
  std::vector<Heard> heard;
  hear(reader, bytes_, heard);
  EXPECT_EQ(reader.faults(), HdlcFaults{});
}

TEST_P(HdlcRecordings, AreWrittenAgainByteForByte) {
  Bytes again;
  for (const Heard& heard : whole_) again = again + written(heard);
  EXPECT_EQ(again, bytes_);
}

TEST_P(HdlcRecordings, SayTheSameByteByByteAndInRandomPieces) {
  EXPECT_EQ(heard_in_pieces(bytes_, [] { return 1u; }), whole_);
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::mt19937 random(seed);
    EXPECT_EQ(heard_in_pieces(bytes_, [&random] { return 1 + random() % 200; }), whole_) << seed;
  }
}

TEST_P(HdlcRecordings, SayTheSameWithGarbageBetweenTheFrames) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::mt19937 random(seed);
    Bytes dirty;
    for (const Heard& heard : whole_) {
      Bytes garbage(random() % 300);
      for (auto& byte : garbage) byte = static_cast<std::uint8_t>(random());
      // A lone flag would open a frame of garbage, which then costs only itself; an escape may cost the flag behind it.
      if (!garbage.empty() && garbage.back() == 0x7d) garbage.pop_back();
      dirty = dirty + garbage + written(heard);
    }
    EXPECT_EQ(heard_in_pieces(dirty, [&random] { return 1 + random() % 200; }), whole_) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Shared, HdlcRecordings, testing::ValuesIn(kRecordings),
                         [](const auto& test) { return test.param.file.substr(0, test.param.file.find('.')); });

struct Records {
  std::vector<Joined> joins;
  std::vector<DemoReport> demos;
  std::vector<MoteAck> acks;
  std::map<std::uint16_t, std::size_t> demos_of;
};

Records records_in(const std::vector<Heard>& heard) {
  Records records;
  for (const Heard& one : heard) {
    if (one.packet.empty()) continue;
    const auto packet = decode_packet(one.packet);
    const auto message = decode_net(packet.value().payload);
    const auto record = decode_record(message.value());
    if (const auto* joined = std::get_if<Joined>(&record.value())) records.joins.push_back(*joined);
    if (const auto* ack = std::get_if<MoteAck>(&record.value())) records.acks.push_back(*ack);
    if (const auto* demo = std::get_if<DemoReport>(&record.value())) {
      records.demos.push_back(*demo);
      ++records.demos_of[message->source_mote];
    }
  }
  return records;
}

class SinkRecordings : public testing::Test {
 protected:
  /// False: absent, the test is skipped.
  bool open(const std::string& name) {
    const Bytes bytes = recorded(name);
    records_ = records_in(heard_in(bytes));
    return !bytes.empty();
  }

  Records records_;
};

TEST_F(SinkRecordings, OfTheFirmwareHoldTwoJoins51ReportsAndFourAcknowledgements) {
  if (!open("avr_sink_uart_mote2pc.bin")) GTEST_SKIP() << "the recording is not here";
  ASSERT_EQ(records_.joins.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(records_.joins[i].island, 11);
    EXPECT_EQ(records_.joins[i].mote, 2 + i);
    EXPECT_EQ(records_.joins[i].transducers, 0x00b0);
    EXPECT_EQ(records_.joins[i].actuators, 0x01);
  }
  ASSERT_EQ(records_.demos.size(), 51u);
  EXPECT_EQ(records_.demos.front().light, 300);
  EXPECT_EQ(records_.demos.front().temperature, 6500);
  EXPECT_EQ(records_.demos.back().light, 412);
  EXPECT_EQ(records_.demos.back().temperature, 6516);
  // Ramps over the sensor reads so far: light 300 + 7n, temperature 6500 + n.
  for (const DemoReport& demo : records_.demos) EXPECT_EQ(demo.light - 300, 7 * (demo.temperature - 6500));
  ASSERT_EQ(records_.acks.size(), 4u);
  const std::uint16_t acked[] = {0xbeef, 0x0102, 0x0103, 0x0106};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(records_.acks[i].sequence, acked[i]);
}

TEST_F(SinkRecordings, OfTheOriginalHoldTwoJoins33ReportsAndTwoAcknowledgements) {
  if (!open("origjava_uart_mote2pc.bin")) GTEST_SKIP() << "the recording is not here";
  ASSERT_EQ(records_.joins.size(), 2u);
  for (const Joined& joined : records_.joins) EXPECT_EQ(joined.island, 12);
  EXPECT_EQ(records_.demos.size(), 33u);
  EXPECT_EQ(records_.demos_of.size(), 2u);
  for (const DemoReport& demo : records_.demos) EXPECT_EQ(demo.light - 300, 7 * (demo.temperature - 6500));
  ASSERT_EQ(records_.acks.size(), 2u);
  EXPECT_EQ(records_.acks[0].sequence, 0xee3c);
  EXPECT_EQ(records_.acks[1].sequence, 0x99bb);
}

}  // namespace
}  // namespace rubicon::motes
