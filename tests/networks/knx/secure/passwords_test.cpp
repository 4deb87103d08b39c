#include "networks/knx/secure/passwords.h"

#include <gtest/gtest.h>

#include "networks/knx/secure/vectors.h"

namespace rubicon::networks::knx::secure {
namespace {

std::string hex_of(const Result<PasswordKey>& keys) {
  return keys ? base::to_hex(keys->key.view()) : keys.error().text;
}

// knx.md, section 10.1.
TEST(SecurePasswords, KeysOfTheWorkedVectors) {
  const auto device = device_code(Secret::of_text("trustme"));
  EXPECT_EQ(hex_of(device), "e158e4012047bd6cc41aafbc5c04c1fc");
  EXPECT_EQ(device->forms(), 1U);
  EXPECT_EQ(hex_of(user_key(Secret::of_text("user2pw"))), "43e24ee1095ee6e9483baa42598b4aba");
}

// Computed with the PBKDF2 of Python: 'schl\xfcssel' and 'schl?ssel'.
TEST(SecurePasswords, LettersBeyondAsciiAreLatin1AndMayBeQuestionMarks) {
  const auto keys = user_key(Secret::of_text("schl\u00fcssel"));
  EXPECT_EQ(hex_of(keys), "a0229d9a13360bc7051e1a1bbbdf0cd3");
  ASSERT_TRUE(keys && keys->forms() == 3);
  EXPECT_EQ(base::to_hex(keys->form(1).view()), "8b8bc6010253c87441db80ed6c0a651a");
  EXPECT_EQ(keys->form(1), user_key(Secret::of_text("schl?ssel"))->key);
  EXPECT_EQ(keys->form(2), user_key(Secret::of_text("schl??ssel"))->key) << "each byte of UTF-8";
}

TEST(SecurePasswords, WhatLatin1CannotWriteHasOnlyTheReplacements) {
  const auto keys = user_key(Secret::of_text("10 \u20ac"));
  EXPECT_EQ(hex_of(keys), hex_of(user_key(Secret::of_text("10 ?"))));
  ASSERT_EQ(keys->forms(), 2U);
  EXPECT_EQ(keys->form(1), user_key(Secret::of_text("10 ???"))->key);
}

TEST(SecurePasswords, APasswordThatIsNotUtf8IsAnErrorWithoutThePassword) {
  const auto keys = user_key(Secret::of_text("secret\xff"));
  ASSERT_FALSE(keys);
  EXPECT_EQ(keys.error().code, ErrorCode::kInvalid);
  EXPECT_EQ(keys.error().text.find("secret"), std::string::npos);
}

// knx.md, section 13.4; the second computed with the PBKDF2 of Python.
TEST(SecurePasswords, ArchivesOfEts6HaveADerivedPassword) {
  EXPECT_EQ(archive_password(Secret::of_text("flatpass"))->text(), "+TXwaOJ3i2n02g0bV3/tpIcebCwR98fDyWkzKX4nwgY=");
  EXPECT_EQ(archive_password(Secret::of_text("schl\u00fcssel 10 \u20ac \U0001f511"))->text(),
            "QS1NKSOhi9jM1TxvI9ynXJRLCiPZWNl3cPxV4mYHKYk=");
  EXPECT_EQ(archive_password(Secret())->text(), "a/wV5L61/gTOfxSn9IoDBw4EDcvJCKjUFlzyMXurLmg=");
  EXPECT_EQ(archive_password(Secret::of_text("\xff")).error().code, ErrorCode::kInvalid);
}

}  // namespace
}  // namespace rubicon::networks::knx::secure
