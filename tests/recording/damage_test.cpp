#include <gmock/gmock.h>

#include <algorithm>
#include <random>

#include "recording/file_format.h"
#include "recording/recording_reader.h"
#include "recordings.h"

namespace rubicon::recording {
namespace {

using testing::HasSubstr;

/// Where the blocks of a file end.
std::vector<std::size_t> ends_of(const Bytes& file) {
  std::vector<std::size_t> ends;
  auto at = find_sync(file, 0);
  while (at < file.size()) {
    at += sound_block(ByteView(file).subspan(at));
    ends.push_back(at);
  }
  return ends;
}

ReadAt read_at(const Bytes& file) {
  return [&file](std::uint64_t offset, std::span<std::uint8_t> into) -> Result<std::size_t> {
    const auto count = std::min<std::size_t>(into.size(), file.size() - std::min<std::size_t>(offset, file.size()));
    std::copy_n(file.begin() + static_cast<std::ptrdiff_t>(offset), count, into.begin());
    return count;
  };
}

Result<FileTail> tail_of(const Bytes& file) {
  return find_tail(file.size(), read_at(file));
}

TEST(RecordingDamage, CutAtAnyByteAllWholeBlocksAreReadAndTheRestIsNamed) {
  const auto file = file_of(three_blocks());
  const auto ends = ends_of(file);
  ASSERT_EQ(ends.size(), 3u);
  for (std::size_t size = 0; size < file.size(); ++size) {
    const auto found = read_all(ByteView(file).first(size));
    const auto whole =
        static_cast<std::size_t>(std::count_if(ends.begin(), ends.end(), [&](auto end) { return end <= size; }));
    EXPECT_EQ(found.lines.size(), 4 * whole) << "cut at " << size;
    const auto head = decode_head(ByteView(file).first(size));
    const auto sound = whole > 0 ? ends[whole - 1] : head.size;
    EXPECT_EQ(found.damaged_bytes(), size - sound) << "cut at " << size;
    if (size > sound) {
      EXPECT_EQ(found.damage.back().offset, sound) << "cut at " << size;
    }
  }
}

TEST(RecordingDamage, ATailThatNoCrashLeavesIsNotSearchedToItsBeginning) {
  auto file = file_of(three_blocks());
  const auto sound = file.size();
  file.resize(sound + (20 << 20), 0);
  EXPECT_EQ(tail_of(file)->sound, sound);
  file.resize(sound + (40 << 20), 0);
  const auto tail = tail_of(file);
  ASSERT_FALSE(tail);
  EXPECT_EQ(tail.error().code, ErrorCode::kInvalid);
  EXPECT_THAT(tail.error().text, HasSubstr("no sound block in the last 33554432 bytes, expected one"));
}

TEST(RecordingDamage, HeadsThatMakeTheSameBytesBeCheckedAgainAndAgainAreGivenUp) {
  auto file = file_of(three_blocks());
  BlockHead head;
  head.packed = head.raw = 1 << 20;
  head.records = 1;
  Bytes one(kBlockHead);
  encode_block_head(head, one.data());
  for (int i = 0; i < 2000; ++i) append(file, one);
  file.resize(file.size() + (1 << 20), 0);
  const auto tail = tail_of(file);
  ASSERT_FALSE(tail);
  EXPECT_THAT(tail.error().text, HasSubstr("no sound block"));
}

TEST(RecordingDamage, AnyFlippedBitCostsAtMostItsOwnBlock) {
  const auto file = file_of(three_blocks());
  const auto whole = read_all(file).lines;
  const auto begin = decode_head(file).size;
  for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
    auto damaged = file;
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    const auto found = read_all(damaged);
    const bool in_head = bit / 8 < begin;
    EXPECT_EQ(found.lines.size(), in_head ? 12u : 8u) << "bit " << bit;
    EXPECT_EQ(found.damage.size(), 1u) << "bit " << bit;
    for (const auto& line : found.lines) {
      EXPECT_NE(std::find(whole.begin(), whole.end(), line), whole.end()) << "bit " << bit << " changed a record";
    }
  }
}

TEST(RecordingDamage, GarbageBetweenBlocksIsPassedOverAndNamed) {
  const auto blocks = three_blocks();
  const auto file = file_of(blocks);
  const auto ends = ends_of(file);
  std::mt19937 dice(42);
  for (const std::size_t size : {1u, 7u, 8u, 9u, 1000u, 200'000u}) {
    Bytes garbage(size);
    for (auto& byte : garbage) byte = static_cast<std::uint8_t>(dice());
    auto mixed = file;
    mixed.insert(mixed.begin() + static_cast<std::ptrdiff_t>(ends[0]), garbage.begin(), garbage.end());
    const auto found = read_all(mixed, 4096);
    EXPECT_EQ(found.lines.size(), 12u) << size;
    ASSERT_EQ(found.damage.size(), 1u) << size;
    EXPECT_EQ(found.damage[0].offset, ends[0]);
    EXPECT_EQ(found.damage[0].bytes, size);
  }
}

TEST(RecordingDamage, WhatIsNoRecordingGivesNothingButDamage) {
  const std::string text(100'000, 'x');
  const auto found = read_all(base::as_bytes(text), 1000);
  EXPECT_TRUE(found.lines.empty());
  ASSERT_EQ(found.damage.size(), 1u);
  EXPECT_EQ(found.damage[0].bytes, text.size());
  EXPECT_THAT(found.damage[0].why, HasSubstr("no recording begins here"));
}

TEST(RecordingDamage, AGrowingFileIsFollowedBlockByBlock) {
  const auto file = file_of(three_blocks());
  const auto ends = ends_of(file);
  RecordingReader reader;
  Found found;
  for (std::size_t at = 0; at < file.size(); ++at) {
    reader.feed(ByteView(file).subspan(at, 1));
    drain(reader, found);
    const auto whole = std::count_if(ends.begin(), ends.end(), [&](auto end) { return end <= at + 1; });
    ASSERT_EQ(found.lines.size(), 4 * static_cast<std::size_t>(whole));
  }
  EXPECT_TRUE(found.damage.empty());
}

/// A block head with sound check sums that lies.
Bytes lying(BlockHead head, ByteView packed) {
  head.sum = crc32c(packed);
  Bytes block(kBlockHead);
  encode_block_head(head, block.data());
  append(block, packed);
  return block;
}

TEST(RecordingDamage, LengthsBeyondTheBoundsAreNotBelieved) {
  const Bytes few(100);
  for (const BlockHead& head : {BlockHead{0xffffffff, 100, 1, {}, {}, 0}, BlockHead{100, 0xffffffff, 1, {}, {}, 0},
                                BlockHead{100, kMaxRaw + 1, 1, {}, {}, 0}, BlockHead{100, 100, 0, {}, {}, 0},
                                BlockHead{100, 100, 101, {}, {}, 0}, BlockHead{0, 100, 1, {}, {}, 0}}) {
    EXPECT_FALSE(decode_block_head(lying(head, few)));
  }
}

TEST(RecordingDamage, BlocksThatUnpackToSomethingElseAreDamage) {
  BlockBuilder builder;
  const auto blocks = three_blocks();
  for (const auto& line : blocks[0]) builder.add(record_of(line));
  const auto block = builder.close();
  const auto head = *decode_block_head(block);
  const auto packed = block.subspan(kBlockHead);
  for (const auto& [raw, records] : {std::pair{head.raw + 1, head.records}, std::pair{head.raw - 1, head.records},
                                     std::pair{head.raw, head.records + 1}, std::pair{head.raw, head.records - 1}}) {
    auto lie = head;
    lie.raw = raw;
    lie.records = records;
    const auto found = read_all(lying(lie, packed));
    EXPECT_GE(found.damage.size(), 1u) << raw << " " << records;
    EXPECT_LE(found.lines.size(), 4u);
  }
  const Bytes noise(100, 0x55);
  EXPECT_EQ(read_all(lying({100, 100, 1, {}, {}, 0}, noise)).damage.size(), 1u);
}

TEST(RecordingDamage, BadRecordsEndTheirBlockOnly) {
  const std::vector<std::string> bad{"",
                                     "ff",
                                     "05",
                                     "0001",
                                     "0002",
                                     "00008d3361",
                                     "0001",
                                     "ffffffffffffffffffffff",
                                     "00018d33036162",
                                     "0000010261620000ffffffff0f"};
  for (const auto& hex : bad) {
    const auto raw = base::from_hex(hex).value();
    BlockHead head;
    head.records = 1;
    BlockDecoder records(head, raw);
    EXPECT_FALSE(records.next()) << hex;
    EXPECT_FALSE(records.fault().empty()) << hex;
    EXPECT_FALSE(records.next()) << hex;
  }
}

TEST(RecordingTail, OfEveryCutFileIsFoundAtTheEndOfTheLastWholeBlock) {
  const auto file = file_of(three_blocks());
  const auto ends = ends_of(file);
  const auto begin = decode_head(file).size;
  for (std::size_t size = 0; size <= file.size(); ++size) {
    const auto tail = tail_of(Bytes(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size)));
    ASSERT_TRUE(tail) << size;
    EXPECT_EQ(tail->has_head, size >= begin) << size;
    if (!tail->has_head) continue;
    std::uint64_t expected = begin;
    for (const auto end : ends) expected = end <= size ? end : expected;
    EXPECT_EQ(tail->sound, expected) << size;
  }
}

TEST(RecordingTail, DamageInTheMiddleIsLeftAlone) {
  auto file = file_of(three_blocks());
  file[ends_of(file)[0] + 50] ^= 1U;
  EXPECT_EQ(tail_of(file)->sound, file.size());
}

TEST(RecordingTail, IsFoundBehindMegabytesOfGarbage) {
  auto file = file_of(three_blocks());
  const auto sound = file.size();
  file.resize(sound + (5 << 20));
  const auto tail = tail_of(file);
  ASSERT_TRUE(tail);
  EXPECT_EQ(tail->sound, sound);
}

TEST(RecordingTail, RefusesWhatIsNoRecording) {
  const std::string text = "time,temperature\n";
  EXPECT_EQ(tail_of(Bytes(text.begin(), text.end())).error().code, ErrorCode::kInvalid);
  auto file = file_of(three_blocks());
  file[13] ^= 1U;
  EXPECT_THAT(tail_of(file).error().text, HasSubstr("head is damaged"));
}

}  // namespace
}  // namespace rubicon::recording
