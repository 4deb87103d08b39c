#include "motes/packet_log.h"

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

namespace rubicon::motes {
namespace {

using namespace std::chrono_literals;

class Memory final : public base::ByteSink {
 public:
  Result<void> append(ByteView more) override {
    if (full) return fail(ErrorCode::kIo, "the disk is full");
    bytes.insert(bytes.end(), more.begin(), more.end());
    return {};
  }
  Bytes bytes;
  bool full = false;
};

Bytes hex(std::string_view text) {
  return base::from_hex(text).value();
}

// log.md 1.1: the first two records of the original's recording of motes 2 and 3.
const std::string kFirst = "000001a1fb78897e 00 0000000b 0000010000030025 0a000c";
const std::string kSecond =
    "000001a1fb78a44c 01 0000007a 00ffff000072001c 000cfffd000c0002000000 66030a1000 0c00020100b001" +
    std::string(2 * 91, '0');

TEST(PacketLogWriter, WritesTheOriginalsRecordsByteForByte) {
  Memory file;
  PacketLogWriter writer(file);
  ASSERT_TRUE(writer.write(1795220343166ms, PacketDirection::kWritten, hex("0000010000030025 0a000c")));
  EXPECT_EQ(file.bytes, hex(kFirst));
  const auto second = hex(kSecond);
  ASSERT_EQ(second.size(), 135u);
  ASSERT_TRUE(writer.write(1795220350028ms, PacketDirection::kRead, ByteView(second).subspan(13)));
  EXPECT_EQ(file.bytes, hex(kFirst + kSecond));
  EXPECT_EQ(writer.records(), 2u);
}

TEST(PacketLogWriter, RefusesPacketsNoReaderWouldFindAgain) {
  Memory file;
  PacketLogWriter writer(file);
  EXPECT_EQ(writer.write(1ms, PacketDirection::kRead, {}).error().code, ErrorCode::kOutOfRange);
  EXPECT_EQ(writer.write(1ms, PacketDirection::kRead, Bytes(7)).error().code, ErrorCode::kOutOfRange);
  EXPECT_EQ(writer.write(1ms, PacketDirection::kRead, Bytes(256)).error().code, ErrorCode::kOutOfRange);
  EXPECT_TRUE(writer.write(1ms, PacketDirection::kRead, Bytes(255)));
  EXPECT_EQ(file.bytes.size(), 13u + 255u);
}

TEST(PacketLogWriter, SaysWhatTheDiskSaid) {
  Memory file;
  file.full = true;
  PacketLogWriter writer(file);
  EXPECT_EQ(writer.write(1ms, PacketDirection::kRead, Bytes(8)).error().text, "the disk is full");
  EXPECT_EQ(writer.records(), 0u);
}

TEST(PacketLogWriter, AppendsOnlyToPacketLogs) {
  EXPECT_TRUE(check_packet_log({}));
  EXPECT_TRUE(check_packet_log(hex(kFirst)));
  for (const std::string text : {"time,temperature\n0,20.5\n", "short"}) {
    EXPECT_EQ(check_packet_log(base::as_bytes(text)).error().code, ErrorCode::kInvalid) << text;
  }
  auto wrong = hex(kFirst);
  wrong[8] = 2;
  EXPECT_FALSE(check_packet_log(wrong));
}

TEST(PacketLogWriter, RewritesTheOriginalsCaptureIdentically) {
  std::ifstream file(RUBICON_SOURCE_DIR "/tests/cases/log/two_motes.bin", std::ios::binary);
  ASSERT_TRUE(file);
  std::ostringstream text;
  text << file.rdbuf();
  const auto content = text.str();
  const auto original = base::as_bytes(content);
  Memory copy;
  PacketLogWriter writer(copy);
  base::ByteReader reader(original);
  while (reader.remaining() > 0) {
    const std::chrono::milliseconds time(static_cast<std::int64_t>(reader.u64_be()));
    const auto direction = static_cast<PacketDirection>(reader.u8());
    const auto packet = reader.take(reader.u32_be());
    ASSERT_TRUE(reader.ok());
    ASSERT_TRUE(writer.write(time, direction, packet));
  }
  EXPECT_EQ(writer.records(), 41u);
  EXPECT_TRUE(std::equal(copy.bytes.begin(), copy.bytes.end(), original.begin(), original.end()));
}

}  // namespace
}  // namespace rubicon::motes
