#include "base/bytes.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace rubicon::base {
namespace {

TEST(Base64, TheExamplesOfRfc4648) {
  const std::vector<std::pair<std::string, std::string>> cases{{"", ""},
                                                               {"f", "Zg=="},
                                                               {"fo", "Zm8="},
                                                               {"foo", "Zm9v"},
                                                               {"foob", "Zm9vYg=="},
                                                               {"fooba", "Zm9vYmE="},
                                                               {"foobar", "Zm9vYmFy"}};
  for (const auto& [bytes, text] : cases) {
    EXPECT_EQ(to_base64(bytes), text);
    EXPECT_EQ(from_base64(text).value_or("(error)"), bytes);
  }
}

TEST(Base64, EveryByteSurvives) {
  std::string bytes;
  for (int i = 0; i < 256; ++i) bytes += static_cast<char>(i);
  EXPECT_EQ(from_base64(to_base64(bytes)).value(), bytes);
}

TEST(Base64, WhatIsWrongIsNamed) {
  EXPECT_EQ(from_base64("Zm9").error().text,
            "base 64: 3 characters; expected groups of four, the last one padded with =");
  EXPECT_EQ(from_base64("Zm 9").error().text, "base 64: character 3 is not one of A-Z a-z 0-9 + /");
  EXPECT_EQ(from_base64("Z=9v").error().text, "base 64: character 2 is not one of A-Z a-z 0-9 + /");
  EXPECT_FALSE(from_base64("===="));
}

}  // namespace
}  // namespace rubicon::base
