#include <gmock/gmock.h>

#include <limits>
#include <random>

#include "recording/file_format.h"
#include "recordings.h"

namespace rubicon::recording {
namespace {

using testing::ElementsAreArray;

TEST(Crc32c, AgreesWithTheExamplesOfRfc3720) {
  EXPECT_EQ(crc32c(Bytes(32, 0)), 0x8a9136aaU);
  EXPECT_EQ(crc32c(Bytes(32, 0xff)), 0x62a8ab43U);
  EXPECT_EQ(crc32c(base::as_bytes("123456789")), 0xe3069283U);
  EXPECT_EQ(crc32c({}), 0U);
}

TEST(RecordingFormat, AHeadIsReadAsItWasWritten) {
  const auto bytes = encode_head({IslandId(7), "house", wall(5), "writer 1"});
  const auto found = decode_head(bytes);
  ASSERT_EQ(found.state, HeadState::kSound);
  EXPECT_EQ(found.head.island, IslandId(7));
  EXPECT_EQ(found.head.prefix, "house");
  EXPECT_EQ(found.head.created, wall(5));
  EXPECT_EQ(found.head.writer, "writer 1");
  EXPECT_EQ(found.size, bytes.size());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_EQ(decode_head(ByteView(bytes).first(size)).state, HeadState::kIncomplete) << size;
  }
}

TEST(RecordingFormat, AHeadOfANewerVersionIsToldApart) {
  auto bytes = encode_head({IslandId(7), "proxy", {}, ""});
  bytes[8] = 2;
  EXPECT_EQ(decode_head(bytes).state, HeadState::kDamaged);
  const auto sum = crc32c(ByteView(bytes).first(bytes.size() - 4));
  for (std::size_t i = 0; i < 4; ++i) bytes[bytes.size() - 4 + i] = static_cast<std::uint8_t>(sum >> (8 * i));
  EXPECT_EQ(decode_head(bytes).state, HeadState::kNewer);
}

/// docs/recording-format.md shows these bytes.
TEST(RecordingFormat, TheWorkedExampleOfTheDocumentIsTrue) {
  const auto head = encode_head({IslandId(6541), "proxy", wall(1'767'225'600'000'000), "example"});
  EXPECT_EQ(base::to_hex(head),
            "895255425245430a01001e008d190000004020464847060005"
            "70726f7879076578616d706c65d5def7d2");
}

TEST(RecordingFormat, RecordsComeBackAsTheyWere) {
  const auto blocks = three_blocks();
  const auto found = read_all(file_of(blocks));
  std::vector<Line> expected;
  for (const auto& block : blocks) expected.insert(expected.end(), block.begin(), block.end());
  EXPECT_THAT(found.lines, ElementsAreArray(expected));
  EXPECT_EQ(found.blocks.size(), 3u);
  ASSERT_EQ(found.heads.size(), 1u);
  EXPECT_EQ(found.heads[0].island, IslandId(6541));
  EXPECT_TRUE(found.damage.empty());
}

TEST(RecordingFormat, PiecesOfAnySizeGiveTheSame) {
  const auto file = file_of(three_blocks());
  const auto whole = read_all(file);
  for (const std::size_t piece : {1u, 2u, 7u, 43u, 44u, 45u, 100u}) {
    const auto found = read_all(file, piece);
    EXPECT_EQ(found.lines, whole.lines) << piece;
    EXPECT_TRUE(found.damage.empty()) << piece;
  }
}

TEST(RecordingFormat, TheStrangestRecordsComeBackAsTheyWere) {
  constexpr auto kLast = std::numeric_limits<std::int64_t>::max(), kFirst = std::numeric_limits<std::int64_t>::min();
  std::vector<Line> lines;
  lines.push_back({RecordKind::kMark, 0, 6541, "", "start", "text/plain", 6541, 0, 0, 0, 0});
  lines.push_back({RecordKind::kSet, kLast, 0xffffffff, "a", std::string("\0\xff\n", 3), "application/json", 1,
                   std::numeric_limits<std::uint64_t>::max(), kFirst, kLast, 1});
  lines.push_back({RecordKind::kDeleted, kFirst, 0xffffffff, "a", "", "", 0xffffffff, 0, kLast, kFirst, -1});
  lines.push_back({RecordKind::kExpired, -1, 1, "a", "ü", "text/plain", 1, 1, 1, 1, 1});
  lines.push_back({RecordKind::kPresent, -1, 1, std::string(255, 'k'), std::string(kMaxValue, 'v'),
                   std::string(255, 'm'), 1, 1, 1, 1, 1});
  const auto found = read_all(file_of({lines})).lines;
  // Times that no calendar holds come back as the furthest ones: the difference of any two is a number.
  for (auto& line : lines) {
    for (auto* time : {&line.seen, &line.write, &line.user, &line.expire})
      *time = std::clamp(*time, -kFurthest.count(), kFurthest.count());
  }
  EXPECT_THAT(found, ElementsAreArray(lines));
  EXPECT_GT(kFurthest - -kFurthest, kFurthest);
}

TEST(RecordingFormat, ThousandsOfKeysAndMediaTypesInOneBlockStayApart) {
  std::mt19937 dice(42);
  std::vector<Line> lines;
  for (int i = 0; i < 20'000; ++i) {
    Line line = reading(i, std::to_string(dice() % 100));
    line.key = "key." + std::to_string(dice() % 5000);
    line.owner = static_cast<std::uint32_t>(1 + dice() % 3);
    line.media_type = "type/" + std::to_string(dice() % 20);
    line.sequence = dice();
    lines.push_back(std::move(line));
  }
  EXPECT_THAT(read_all(file_of({lines})).lines, ElementsAreArray(lines));
}

TEST(RecordingFormat, WhatIsTooLongIsNotTaken) {
  BlockBuilder builder;
  Line line = reading(1, "1");
  line.value.assign(kMaxValue + 1, 'x');
  EXPECT_FALSE(builder.add(record_of(line)));
  line = reading(1, "1");
  line.key.assign(kMaxKey + 1, 'x');
  EXPECT_FALSE(builder.add(record_of(line)));
  line = reading(1, "1");
  line.media_type.assign(kMaxMediaType + 1, 'x');
  EXPECT_FALSE(builder.add(record_of(line)));
  EXPECT_TRUE(builder.empty());
}

TEST(RecordingFormat, ABlockIsFullBeforeItIsTooLongForAReader) {
  BlockBuilder builder;
  Line line = reading(1, std::string(kMaxValue, 'x'));
  int records = 0;
  for (; !builder.full(); ++records) ASSERT_TRUE(builder.add(record_of(line)));
  const auto block = builder.close();
  const auto head = decode_block_head(block);
  ASSERT_TRUE(head);
  EXPECT_LE(head->raw, kMaxRaw);
  EXPECT_EQ(head->records, static_cast<std::uint32_t>(records));
  EXPECT_EQ(sound_block(block), block.size());
}

TEST(RecordingFormat, ReadingsTakeFewBytes) {
  std::vector<Line> lines;
  std::mt19937 dice(42);
  for (int i = 0; i < 10'000; ++i) lines.push_back(reading(i, std::to_string(200 + dice() % 50)));
  EXPECT_LT(file_of({lines}).size(), 10u * lines.size());
}

}  // namespace
}  // namespace rubicon::recording
