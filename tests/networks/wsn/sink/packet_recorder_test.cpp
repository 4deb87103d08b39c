#include "networks/wsn/sink/packet_logs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/virtual_scheduler.h"
#include "motes/mote_vectors.h"
#include "support/memory/memory_transports.h"

namespace rubicon::networks::wsn::sink {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

const auto kPacket = base::from_hex("00000100000300250a000c").value();
constexpr std::size_t kRecord = 24;

class WsnPacketRecorder : public testing::Test {
 protected:
  std::unique_ptr<PacketRecorder> make() {
    return std::make_unique<PacketRecorder>("/r.log", time, disk, [this](const auto& subject, std::string_view text) {
      notes.emplace_back(subject + ": " + std::string(text));
    });
  }
  std::uint64_t count(const std::string& name) const { return recorder->counters().at(name); }

  VirtualScheduler time;
  transport::MemoryTransports disk;
  std::vector<std::string> notes;
  std::unique_ptr<PacketRecorder> recorder = make();
};

TEST_F(WsnPacketRecorder, WritesTheVectorsByteForByte) {
  std::size_t records = 0;
  for (const auto& vector : motes::shared_vectors()) {
    if (vector.name != "log-rec-write" && vector.name != "log-rec-read") continue;
    ++records;
    base::ByteReader reader(vector.bytes);
    time.set_wall(WallTime(std::chrono::milliseconds(reader.u64_be())));
    disk.put("/r.log", Bytes{});
    recorder = make();
    ASSERT_TRUE(recorder->open());
    const auto packet = ByteView(vector.bytes).subspan(13);
    if (vector.name == "log-rec-read")
      recorder->read(packet);
    else
      recorder->written(packet);
    EXPECT_EQ(base::to_hex(disk.bytes("/r.log")), base::to_hex(vector.bytes)) << vector.name;
  }
  if (records == 0) GTEST_SKIP() << "no ../shared/data/motes/vectors.tsv beside the source tree";
  EXPECT_EQ(records, 2U);
}

TEST_F(WsnPacketRecorder, WritesEachRecordAtOnceWithItsTimeAndDirection) {
  ASSERT_TRUE(recorder->open());
  time.set_wall(WallTime(1795220343166ms));
  recorder->written(kPacket);
  EXPECT_EQ(base::to_hex(disk.bytes("/r.log")), "000001a1fb78897e000000000b00000100000300250a000c");
  time.run_for(10s);
  recorder->read(kPacket);
  EXPECT_EQ(base::to_hex(disk.bytes("/r.log")).substr(48, 18), "000001a1fb78b08e01");
  EXPECT_EQ(count("recorded"), 2U);
}

TEST_F(WsnPacketRecorder, AppendsToASoundLog) {
  ASSERT_TRUE(recorder->open());
  recorder->read(kPacket);
  recorder = nullptr;
  recorder = make();
  ASSERT_TRUE(recorder->open());
  recorder->read(kPacket);
  EXPECT_EQ(disk.bytes("/r.log").size(), 2 * kRecord);
}

TEST_F(WsnPacketRecorder, LeavesAFileAloneThatIsNoPacketLog) {
  disk.put("/r.log", "a diary, and not to be written to");
  const auto opened = recorder->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kInvalid);
  EXPECT_THAT(opened.error().text, HasSubstr("/r.log"));
  recorder->read(kPacket);
  EXPECT_EQ(base::as_text(disk.bytes("/r.log")), "a diary, and not to be written to");
  EXPECT_EQ(count("unrecorded"), 1U);
}

TEST_F(WsnPacketRecorder, RefusesAFileThatSomebodyElseWrites) {
  ASSERT_TRUE(recorder->open());
  auto other = make();
  EXPECT_EQ(other->open().error().code, ErrorCode::kBusy);
}

TEST_F(WsnPacketRecorder, StopsOnAFullDiskAndTriesAgainAMinuteLater) {
  ASSERT_TRUE(recorder->open());
  recorder->read(kPacket);
  disk.room(10);
  recorder->read(kPacket);
  EXPECT_EQ(disk.bytes("/r.log").size(), kRecord) << "no half record is left";
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_THAT(notes[0], HasSubstr("No space left"));
  time.run_for(59s);
  disk.room(std::nullopt);
  recorder->read(kPacket);
  EXPECT_EQ(disk.bytes("/r.log").size(), kRecord);
  EXPECT_EQ(count("unrecorded"), 2U);
  EXPECT_EQ(count("recording-stops"), 1U);
  EXPECT_EQ(notes.size(), 1U);
  time.run_for(1s);
  recorder->read(kPacket);
  EXPECT_EQ(disk.bytes("/r.log").size(), 2 * kRecord);
  EXPECT_EQ(count("recorded"), 2U);
}

TEST_F(WsnPacketRecorder, ComesBackWhenItsFolderDoes) {
  disk.lose_folder("");
  EXPECT_FALSE(recorder->open());
  recorder->read(kPacket);
  disk.give_folder("");
  recorder->read(kPacket);
  EXPECT_FALSE(disk.has("/r.log"));
  time.run_for(1min);
  recorder->read(kPacket);
  EXPECT_EQ(disk.bytes("/r.log").size(), kRecord);
  EXPECT_EQ(count("unrecorded"), 2U);
}

TEST_F(WsnPacketRecorder, PassesOverWhatNoReaderWouldFind) {
  ASSERT_TRUE(recorder->open());
  recorder->read(Bytes{0, 1, 2});
  recorder->read(Bytes(256, 0));
  EXPECT_TRUE(disk.bytes("/r.log").empty());
  EXPECT_EQ(count("unrecorded"), 2U);
  EXPECT_TRUE(notes.empty());
}

}  // namespace
}  // namespace rubicon::networks::wsn::sink
