#include "networks/knx/secure/secured_apdu.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "networks/knx/secure/vectors.h"

namespace rubicon::networks::knx::secure {
namespace {

using ::testing::HasSubstr;
using wire::DataFrame;

const Key kGroupKey(counting(0x30, 16).view());

/// 7.1.11 to 1/2/7, as in knx.md, section 18.
DataFrame frame_with(ByteView tpdu) {
  DataFrame frame;
  frame.source = wire::IndividualAddress(0x710b);
  frame.destination = 0x0a07;
  frame.tpdu = tpdu;
  return frame;
}

struct Vector {
  const char* plain;
  std::uint8_t control;
  const char* secured;
};
constexpr Vector kVectors[]{{"0081", control::kEncrypted, "03f110000000000005b24e2f0c2e22"},
                            {"008080", control::kEncrypted, "03f110000000000005b24f441773a652"},
                            {"00800c33", control::kEncrypted, "03f110000000000005b24fc8764c872131"},
                            {"0081", control::kAuthenticated, "03f1000000000000050081050215be"}};

TEST(SecuredApdu, WorkedVectorsAreSealedAndOpenedByteForByte) {
  Ccm ccm;
  for (const auto& [plain, scf, secured] : kVectors) {
    const auto tpdu = hex(plain);
    EXPECT_EQ(base::to_hex(*seal(ccm, kGroupKey, frame_with(tpdu), scf, 5)), secured);
    const auto closed = hex(secured);
    const auto opened = open(ccm, kGroupKey, frame_with(closed));
    ASSERT_TRUE(opened) << opened.error().text;
    EXPECT_EQ(base::to_hex(*opened), plain);
    EXPECT_EQ(closed.size(), tpdu.size() + kSecurityBytes);
  }
}

TEST(SecuredApdu, EachBitIsProtected) {
  Ccm ccm;
  for (const auto& vector : kVectors) {
    const auto good = hex(vector.secured);
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
      auto bad = good;
      bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ 1U << bit % 8);
      if (!is_secured(bad)) continue;
      EXPECT_FALSE(open(ccm, kGroupKey, frame_with(bad))) << vector.secured << " bit " << bit;
    }
  }
}

TEST(SecuredApdu, AddressesAreProtectedAndHopCountAndPriorityAreNot) {
  Ccm ccm;
  const auto tpdu = hex(kVectors[2].secured);
  const auto opens = [&](auto change) {
    auto frame = frame_with(tpdu);
    change(frame);
    return open(ccm, kGroupKey, frame).has_value();
  };
  EXPECT_TRUE(opens([](DataFrame& frame) { frame.control2 = 0xc0; })) << "hop count";
  EXPECT_TRUE(opens([](DataFrame& frame) { frame.control1 = 0x9c; })) << "priority, repetition";
  EXPECT_FALSE(opens([](DataFrame& frame) { frame.source = wire::IndividualAddress(0x710c); }));
  EXPECT_FALSE(opens([](DataFrame& frame) { frame.destination = 0x0a08; }));
  EXPECT_FALSE(opens([](DataFrame& frame) { frame.control2 = 0x60; })) << "address type";
  EXPECT_FALSE(opens([](DataFrame& frame) { frame.control2 = 0xe1; })) << "extended frame format";
}

TEST(SecuredApdu, AnotherKeyOpensNothing) {
  Ccm ccm;
  const auto tpdu = hex(kVectors[0].secured);
  const auto opened = open(ccm, Key(counting(0x31, 16).view()), frame_with(tpdu));
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kRefused);
}

TEST(SecuredApdu, ShortAndUnknownOnesAreRefused) {
  Ccm ccm;
  const auto good = hex(kVectors[0].secured);
  for (std::size_t size = 2; size < 15; ++size) {
    const auto cut = ByteView(good).first(size);
    EXPECT_EQ(open(ccm, kGroupKey, frame_with(cut)).error().code, ErrorCode::kInvalid) << size;
  }
  auto other = good;
  other[2] = 0x20;
  EXPECT_EQ(open(ccm, kGroupKey, frame_with(other)).error().code, ErrorCode::kUnsupported);
}

TEST(SecuredApdu, OnlyShortValuesFitAnInterfaceWithoutExtendedFrames) {
  wire::Telegram telegram;
  telegram.payload = {{1}, true};
  EXPECT_TRUE(fits_secured(telegram, 15));
  telegram.payload = {{0x80}, false};
  EXPECT_TRUE(fits_secured(telegram, 15)) << "15 bytes behind the TPCI";
  telegram.payload = {{0x0c, 0x33}, false};
  const auto refused = fits_secured(telegram, 15);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().text, HasSubstr("at most 15 bytes"));
  EXPECT_THAT(refused.error().text, HasSubstr("a value of 2 bytes then needs 16"));
  EXPECT_TRUE(fits_secured(telegram, 55));
  telegram.payload = {};
  telegram.service = wire::Service::kRead;
  EXPECT_TRUE(fits_secured(telegram, 15));
}

}  // namespace
}  // namespace rubicon::networks::knx::secure
