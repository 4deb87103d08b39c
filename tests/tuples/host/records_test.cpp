#include "tuples/host/connection.h"

#include <gtest/gtest.h>

namespace rubicon::tuples::host {
namespace {

TEST(HostRecords, AreReadAsTheyWereWritten) {
  Bytes out;
  append(out, {Record::Type::kFrame, OwnerId(6541), OwnerId(70001), 1'800'000'000'000'000, "text",
               base::as_bytes("entries")});
  // Size, type 7, 6541, 70001, the incarnation, the text after its size, the content.
  EXPECT_EQ(base::to_hex(out),
            "1a000000"
            "07"
            "8d33"
            "f1a204"
            "8080e2c4f2a29903"
            "0474657874"
            "656e7472696573");
  const auto record = read_record(ByteView(out).subspan(kSizeBytes));
  ASSERT_TRUE(record);
  EXPECT_EQ(record->type, Record::Type::kFrame);
  EXPECT_EQ(record->id, OwnerId(6541));
  EXPECT_EQ(record->target, OwnerId(70001));
  EXPECT_EQ(record->number, 1'800'000'000'000'000U);
  EXPECT_EQ(record->text, "text");
  EXPECT_EQ(base::as_text(record->content), "entries");
}

TEST(HostRecords, OfAnUnknownTypeOrShortOnesAreInvalid) {
  for (const auto* wrong : {"", "00", "0c0000000000", "07", "0700", "0700000005", "07ffffffffff7f000000"}) {
    const auto bytes = *base::from_hex(wrong);
    EXPECT_FALSE(read_record(bytes)) << wrong;
  }
  const auto bytes = *base::from_hex("0c00000000");
  EXPECT_EQ(read_record(bytes).error().text, "invalid record of type 12");
}

TEST(HostRecords, TokensAreSixteenHexadecimalDigits) {
  EXPECT_TRUE(is_token("0123456789abcdef"));
  for (const auto* wrong : {"", "0123456789abcde", "0123456789abcdef0", "0123456789ABCDEF", "../../etc/passwd"})
    EXPECT_FALSE(is_token(wrong)) << wrong;
}

}  // namespace
}  // namespace rubicon::tuples::host
