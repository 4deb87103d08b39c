#include "motes/packet_log.h"

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

namespace rubicon::motes {
namespace {

using testing::HasSubstr;

// Vector log-file-3rec: written SET_ISLAND_ID, read join of mote 5, read updates of mote 5 (log.md 1.1).
std::string three_records() {
  const std::string zeros91(182, '0'), zeros86(172, '0');
  const auto bytes = base::from_hex(
      "000001a1fb6476da000000000b 00000100000300250a7d7e"
      "000001a1fb647945010000007a 00ffff000172221c 000bfffd000b0005000000 66 030a 10000b000501004301" +
      zeros91 +
      "000001a1fb647b9a010000007a 00ffff000172221c 000bfffd000b0005001234 66 030a 23030001012c00021964004004b0" +
      zeros86);
  return std::string(base::as_text(*bytes));
}

struct Read {
  std::vector<PacketRecord> records;
  std::vector<Damage> damages;
};

Read read_all(std::string_view content, std::size_t piece = 64 * 1024) {
  PacketLogReader reader;
  Read out;
  const auto drain = [&] {
    while (auto item = reader.next()) {
      if (auto* record = std::get_if<PacketRecord>(&*item))
        out.records.push_back(std::move(*record));
      else
        out.damages.push_back(std::get<Damage>(*item));
    }
  };
  for (std::size_t at = 0; at < content.size(); at += piece) {
    reader.feed(base::as_bytes(content.substr(at, piece)));
    drain();
  }
  reader.end();
  drain();
  return out;
}

TEST(PacketLog, ReadsRecordsWithTimeDirectionAndPacket) {
  const Read read = read_all(three_records());
  ASSERT_EQ(read.records.size(), 3u);
  EXPECT_TRUE(read.damages.empty());
  EXPECT_EQ(read.records[0].offset, 0u);
  EXPECT_FALSE(read.records[0].from_sink);
  EXPECT_EQ(read.records[1].offset, 24u);
  EXPECT_EQ(read.records[1].time.count(), 0x01a1fb647945);
  EXPECT_TRUE(read.records[1].from_sink);
  EXPECT_EQ(read.records[2].offset, 159u);
  EXPECT_EQ(read.records[2].packet.size(), 122u);
}

TEST(PacketLog, IsTheSameInPiecesOfAnySize) {
  for (const std::size_t piece : {1u, 2u, 7u, 13u, 134u, 135u}) {
    const Read read = read_all(three_records(), piece);
    EXPECT_EQ(read.records.size(), 3u) << piece;
    EXPECT_TRUE(read.damages.empty()) << piece;
  }
}

TEST(PacketLog, EveryTruncationGivesTheWholeRecordsBeforeIt) {
  const std::string whole = three_records();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const Read read = read_all(std::string_view(whole).substr(0, length));
    const std::size_t expected = length < 24 ? 0u : length < 159 ? 1u : 2u;
    EXPECT_EQ(read.records.size(), expected) << length;
    const bool between_records = length == 0 || length == 24 || length == 159;
    ASSERT_EQ(read.damages.size(), between_records ? 0u : 1u) << length;
    if (between_records) continue;
    EXPECT_THAT(read.damages[0].why, HasSubstr("cut short by the end of the file"));
  }
}

TEST(PacketLog, ADamagedRecordIsReportedAndTheNextSoundOneFound) {
  struct Change {
    std::size_t at;
    std::uint8_t value;
    const char* why;
  };
  for (const Change& change : {Change{24 + 8, 2, "direction 2, expected 0 or 1"},
                               Change{24 + 9, 0xff, "packet length -16777094, expected 8 to 255"},
                               Change{24 + 12, 0, "packet length 0, expected 8 to 255"},
                               Change{24 + 12, 0x7b, "dispatch byte 00 and AM length 114 in a packet of 123 bytes"},
                               Change{24 + 13, 7, "dispatch byte 07 and AM length 114 in a packet of 122 bytes"}}) {
    std::string content = three_records();
    content[change.at] = static_cast<char>(change.value);
    const Read read = read_all(content);
    ASSERT_EQ(read.records.size(), 2u) << change.why;
    EXPECT_EQ(read.records[1].offset, 159u);
    ASSERT_EQ(read.damages.size(), 1u) << change.why;
    EXPECT_EQ(read.damages[0].offset, 24u);
    EXPECT_EQ(read.damages[0].bytes, 135u);
    EXPECT_EQ(read.damages[0].why, change.why);
  }
}

TEST(PacketLog, GarbageBeforeAndBetweenRecordsIsSkipped) {
  const std::string whole = three_records();
  const Read read = read_all("hello" + whole.substr(0, 24) + std::string(1000, '\x01') + whole.substr(24));
  EXPECT_EQ(read.records.size(), 3u);
  ASSERT_EQ(read.damages.size(), 2u);
  EXPECT_EQ(read.damages[0].bytes, 5u);
  EXPECT_EQ(read.damages[1].offset, 29u);
  EXPECT_EQ(read.damages[1].bytes, 1000u);
}

/// The capture of the original recorder (log.md 1.1).
class PacketLogCapture : public testing::Test {
 protected:
  void SetUp() override {
    std::ifstream file(RUBICON_SOURCE_DIR "/tests/cases/log/two_motes.bin", std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    capture_ = text.str();
  }

  std::string capture_;
};

TEST_F(PacketLogCapture, EveryTruncationIsSurvived) {
  for (std::size_t length = 0; length < capture_.size(); length += 1) {
    const Read read = read_all(std::string_view(capture_).substr(0, length));
    EXPECT_EQ(read.records.size(), length < 24 ? 0 : 1 + (length - 24) / 135) << length;
    EXPECT_LE(read.damages.size(), 1u) << length;
  }
}

TEST_F(PacketLogCapture, EverySingleByteCorruptionCostsAtMostItsRecord) {
  for (std::size_t at = 0; at < capture_.size(); ++at) {
    std::string damaged = capture_;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    EXPECT_GE(read_all(damaged).records.size(), 40u) << at;
  }
}

}  // namespace
}  // namespace rubicon::motes
