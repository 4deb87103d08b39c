#include "base/text.h"

#include <gtest/gtest.h>

namespace rubicon::base {
namespace {

constexpr char32_t kLast = 0x10ffff, kReplacement = 0xfffd;

std::string utf8(char32_t character) {
  std::string out;
  append_utf8(character, out);
  return out;
}

/// The characters of a text; U+FFFD for each byte that is part of none.
std::u32string characters_of(std::string_view text) {
  std::u32string all;
  while (!text.empty()) all += take_utf8(text).value_or(kReplacement);
  return all;
}

bool is_surrogate(char32_t code) {
  return code >= 0xd800 && code <= 0xdfff;
}

TEST(Utf8, EachLengthHasTheBytesOfTheStandard) {
  EXPECT_EQ(utf8(0), std::string(1, '\0'));
  EXPECT_EQ(utf8(0x7f), "\x7f");
  EXPECT_EQ(utf8(0x80), "\xc2\x80");
  EXPECT_EQ(utf8(0xe9), "é");
  EXPECT_EQ(utf8(0x7ff), "\xdf\xbf");
  EXPECT_EQ(utf8(0x800), "\xe0\xa0\x80");
  EXPECT_EQ(utf8(0x20ac), "€");
  EXPECT_EQ(utf8(0xffff), "\xef\xbf\xbf");
  EXPECT_EQ(utf8(0x10000), "\xf0\x90\x80\x80");
  EXPECT_EQ(utf8(0x1f600), "😀");
  EXPECT_EQ(utf8(kLast), "\xf4\x8f\xbf\xbf");
}

TEST(Utf8, WhatIsNoCharacterIsReplaced) {
  for (const char32_t none : {0xd800U, 0xdbffU, 0xdc00U, 0xdfffU, 0x110000U, ~0U})
    EXPECT_EQ(utf8(none), "\xef\xbf\xbd");
}

TEST(Utf8, EveryCharacterReadsBackAndIsWellFormed) {
  for (char32_t code = 0; code <= kLast; ++code) {
    if (is_surrogate(code)) continue;
    const auto text = utf8(code);
    std::string_view rest = text;
    ASSERT_TRUE(take_utf8(rest) == code && rest.empty()) << std::hex << static_cast<std::uint32_t>(code);
    ASSERT_TRUE(is_utf8(text)) << std::hex << static_cast<std::uint32_t>(code);
  }
}

TEST(Utf8, ABrokenByteIsTakenAlone) {
  EXPECT_EQ(characters_of("a\xff\x80z"), U"a\ufffd\ufffdz");
  EXPECT_EQ(characters_of("\xc3"), U"\ufffd");
  EXPECT_EQ(characters_of("\xc3z"), U"\ufffdz");
  EXPECT_EQ(characters_of("\xe2\x82"), U"\ufffd\ufffd");
  std::string_view empty;
  EXPECT_EQ(take_utf8(empty), std::nullopt);
}

TEST(Utf8, OverlongFormsSurrogatesAndMoreThanTheLastAreBroken) {
  for (const auto* text : {"\xc0\x80", "\xc1\xbf", "\xe0\x9f\xbf", "\xf0\x8f\xbf\xbf", "\xed\xa0\x80", "\xed\xbf\xbf",
                           "\xf4\x90\x80\x80", "\xf8\x88\x80\x80\x80"}) {
    std::string_view rest = text;
    EXPECT_EQ(take_utf8(rest), std::nullopt) << text;
    EXPECT_EQ(utf8_prefix(text), 0U) << text;
  }
  EXPECT_EQ(utf8_prefix("Küche \xed\xa0\x80"), 7U);
}

}  // namespace
}  // namespace rubicon::base
