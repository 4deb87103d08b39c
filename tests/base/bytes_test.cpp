#include "base/bytes.h"

#include <gtest/gtest.h>

namespace rubicon::base {
namespace {

const Bytes kCounting = {0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x08, 0x09};

TEST(ByteReader, ReadsBigEndian) {
  ByteReader in(kCounting);
  EXPECT_EQ(in.u8(), 0x01);
  EXPECT_EQ(in.u16_be(), 0x0203);
  EXPECT_EQ(in.u32_be(), 0x04050607U);
  EXPECT_EQ(in.position(), 7U);
  EXPECT_EQ(in.remaining(), 2U);
  EXPECT_EQ(ByteReader(kCounting).u64_be(), 0x0102030405060708U);
}

TEST(ByteReader, ReadsLittleEndian) {
  ByteReader in(kCounting);
  EXPECT_EQ(in.u16_le(), 0x0201);
  EXPECT_EQ(in.u32_le(), 0x06050403U);
}

TEST(ByteReader, TakesAndSkips) {
  ByteReader in(kCounting);
  in.skip(2);
  const auto taken = in.take(3);
  EXPECT_EQ(Bytes(taken.begin(), taken.end()), (Bytes{3, 4, 5}));
  EXPECT_TRUE(in.take(0).empty());
  EXPECT_TRUE(in.ok());
}

TEST(ByteReader, NeverReadsBeyondTheEnd) {
  ByteReader in(ByteView(kCounting).first(3));
  EXPECT_EQ(in.u32_be(), 0U);
  EXPECT_FALSE(in.ok());
  EXPECT_EQ(in.position(), 0U);
  EXPECT_EQ(in.remaining(), 3U);
}

TEST(ByteReader, GivesZeroForEverAfterAShortRead) {
  ByteReader in(ByteView(kCounting).first(3));
  in.skip(4);
  EXPECT_EQ(in.u8(), 0);
  EXPECT_EQ(in.u16_le(), 0);
  EXPECT_TRUE(in.take(1).empty());
  EXPECT_FALSE(in.ok());
}

TEST(ByteReader, HugeCountsAreShortReads) {
  ByteReader in(kCounting);
  in.skip(1);
  EXPECT_TRUE(in.take(SIZE_MAX).empty());
  EXPECT_FALSE(in.ok());
}

TEST(ByteReader, AnEmptyInputIsSoundUntilRead) {
  ByteReader in({});
  EXPECT_TRUE(in.ok());
  EXPECT_EQ(in.u8(), 0);
  EXPECT_FALSE(in.ok());
}

TEST(ByteWriter, WritesWhatTheReaderReads) {
  ByteWriter out;
  out.u8(0xff).u16_be(0x0102).u32_be(0x03040506).u64_be(0x0708090a0b0c0d0e).u16_le(0x0f10).u32_le(0x11121314);
  out.bytes(as_bytes("hi"));
  EXPECT_EQ(to_hex(out.view()),
            "ff"
            "0102"
            "03040506"
            "0708090a0b0c0d0e"
            "100f"
            "14131211"
            "6869");
  EXPECT_EQ(out.take().size(), 23U);
}

TEST(Hex, IsLowerCaseWithoutBlanks) {
  EXPECT_EQ(to_hex(Bytes{0x00, 0x0a, 0xff}), "000aff");
  EXPECT_EQ(to_hex({}), "");
}

TEST(Hex, ReadsBothCasesAndBlanksBetweenBytes) {
  EXPECT_EQ(*from_hex("00 0a FF fF"), (Bytes{0x00, 0x0a, 0xff, 0xff}));
  EXPECT_EQ(*from_hex("  01  02 "), (Bytes{1, 2}));
  EXPECT_EQ(*from_hex(""), Bytes());
}

TEST(Hex, AnErrorNamesThePosition) {
  EXPECT_EQ(from_hex("00zz").error(), (Error{ErrorCode::kInvalid, "hex text: position 2 is not a hex digit"}));
  EXPECT_EQ(from_hex("0 0").error().text, "hex text: position 1 is not a hex digit");
  EXPECT_EQ(from_hex("0x00").error().text, "hex text: position 1 is not a hex digit");
  EXPECT_EQ(from_hex("000").error().text, "hex text: odd number of digits");
}

TEST(Bytes, ABufferThatGrewAndIsEmptyGivesItsMemoryBack) {
  Bytes usual(kKeptBuffer / 2), large(4 * kKeptBuffer);
  drop_front(usual, usual.size());
  EXPECT_GT(usual.capacity(), 0U);
  drop_front(large, large.size() - 1);
  EXPECT_EQ(large.size(), 1U);
  EXPECT_GE(large.capacity(), 4 * kKeptBuffer) << "it is in use";
  drop_front(large, 1);
  EXPECT_EQ(large.capacity(), 0U);
}

TEST(Bytes, AreTextAndBack) {
  EXPECT_EQ(as_text(as_bytes("gr\xc3\xbcn")), "gr\xc3\xbcn");
  EXPECT_EQ(as_bytes("\xff")[0], 0xff);
}

}  // namespace
}  // namespace rubicon::base
