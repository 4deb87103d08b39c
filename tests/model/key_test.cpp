#include "rubicon/key.hpp"

#include <gtest/gtest.h>

namespace rubicon::model {
namespace {

std::string refusal(const Result<void>& result) {
  return result ? "accepted" : result.error().text;
}

std::string pattern_refusal(std::string_view text) {
  const auto pattern = Pattern::parse(text);
  return pattern ? "accepted" : pattern.error().text;
}

bool matches(std::string_view pattern, std::string_view key, OwnerId owner = OwnerId{6541}) {
  const auto parsed = Pattern::parse(pattern);
  EXPECT_TRUE(parsed) << pattern;
  return parsed && parsed->matches(owner, key);
}

/// `count` times the part, joined by dots.
std::string parts_of(std::size_t count, std::string_view part) {
  std::string key(part);
  for (std::size_t i = 1; i < count; ++i) key.append(".").append(part);
  return key;
}

TEST(Key, PartsAreLettersDigitsUnderscoreAndMinus) {
  EXPECT_TRUE(check_key("proxy.knx-hall.1_4_6.actuator.switch-1.command"));
  EXPECT_TRUE(check_key("GATEWAY"));
  EXPECT_TRUE(check_key("a"));
  EXPECT_TRUE(check_key("-.-._._"));
  EXPECT_TRUE(check_key("0.1"));
}

TEST(Key, AnEmptyPartIsRefusedWithItsPosition) {
  EXPECT_EQ(refusal(check_key("")), "key is empty");
  EXPECT_EQ(refusal(check_key(".")), "key '.': empty part at position 0");
  EXPECT_EQ(refusal(check_key(".a")), "key '.a': empty part at position 0");
  EXPECT_EQ(refusal(check_key("a.")), "key 'a.': empty part at position 2");
  EXPECT_EQ(refusal(check_key("a..b")), "key 'a..b': empty part at position 2");
}

TEST(Key, OtherCharactersAreRefusedWithTheirPosition) {
  EXPECT_EQ(refusal(check_key("a/b")), "key 'a/b': '/' at position 1; parts are [A-Za-z0-9_-]+");
  EXPECT_EQ(refusal(check_key("ab.c d")), "key 'ab.c d': ' ' at position 4; parts are [A-Za-z0-9_-]+");
  EXPECT_EQ(refusal(check_key("a\nb")), "key 'a\\x0ab': '\\x0a' at position 1; parts are [A-Za-z0-9_-]+");
  EXPECT_EQ(refusal(check_key("gr\xc3\xbcn")), "key 'gr\xc3\xbcn': '\xc3\xbc' at position 2; parts are [A-Za-z0-9_-]+");
  EXPECT_EQ(refusal(check_key(std::string_view("a\0b", 3))),
            "key 'a\\x00b': '\\x00' at position 1; parts are [A-Za-z0-9_-]+");
  EXPECT_EQ(refusal(check_key("a.*")), "key 'a.*': '*' at position 2; parts are [A-Za-z0-9_-]+");
  EXPECT_EQ(check_key("a/b").error().code, ErrorCode::kInvalid);
}

TEST(Key, LengthIsBounded) {
  EXPECT_TRUE(check_key(std::string(kMaxKeyLength, 'a')));
  EXPECT_FALSE(check_key(std::string(kMaxKeyLength + 1, 'a')));
  EXPECT_EQ(refusal(check_key(std::string(10240, 'k'))),
            "key '" + std::string(60, 'k') + "...' has 10240 characters, at most 255 are allowed");
}

TEST(Key, TheNumberOfPartsIsBounded) {
  EXPECT_TRUE(check_key(parts_of(kMaxKeyParts, "a")));
  EXPECT_EQ(refusal(check_key(parts_of(kMaxKeyParts + 1, "a"))),
            "key 'a.a.a.a.a.a.a.a.a.a.a.a.a' has 13 parts, at most 12 are allowed");
}

TEST(Key, PartsAreSplitAtDots) {
  EXPECT_EQ(key_parts("a.bc.d"), (std::vector<std::string_view>{"a", "bc", "d"}));
  EXPECT_EQ(key_parts("a"), (std::vector<std::string_view>{"a"}));
  EXPECT_EQ(key_parts(""), (std::vector<std::string_view>{""}));
  EXPECT_EQ(key_parts(".a."), (std::vector<std::string_view>{"", "a", ""}));
}

TEST(KeyPart, IsMadeOfAnyText) {
  EXPECT_EQ(to_key_part("1.4.6"), "1_4_6");
  EXPECT_EQ(to_key_part("1/2/3"), "1_2_3");
  EXPECT_EQ(to_key_part("K\xc3\xbc"
                        "che"),
            "K__che");
  EXPECT_EQ(to_key_part("a\nb"), "a_b");
  EXPECT_EQ(to_key_part("Abc-9_x"), "Abc-9_x");
  EXPECT_EQ(to_key_part(""), "_");
  EXPECT_EQ(to_key_part("*"), "_");
}

TEST(KeyPart, IsCutAtTheLimit) {
  EXPECT_EQ(to_key_part(std::string(10240, 'x')), std::string(64, 'x'));
  EXPECT_EQ(to_key_part("abcdef", 3), "abc");
  EXPECT_EQ(to_key_part("abc", 0), "_");
}

TEST(KeyPart, IsAlwaysAValidKey) {
  for (int c = 0; c < 256; ++c) EXPECT_TRUE(check_key(to_key_part(std::string(2, static_cast<char>(c))))) << c;
}

TEST(Quoted, IsPrintableAndShort) {
  EXPECT_EQ(model::quoted("hello"), "'hello'");
  EXPECT_EQ(model::quoted(""), "''");
  EXPECT_EQ(model::quoted("\x1b[31m\x7f"), "'\\x1b[31m\\x7f'");
  EXPECT_EQ(model::quoted(std::string(60, 'a')), "'" + std::string(60, 'a') + "'");
  EXPECT_EQ(model::quoted("K\xc3\xbc"
                          "che \xe2\x82\xac"),
            "'K\xc3\xbc"
            "che \xe2\x82\xac'")
      << "as it was typed";
  EXPECT_EQ(model::quoted("a\xc3"
                          "b\xff\xe2\x80\xae"),
            "'a\\xc3b\\xff\\xe2\\x80\\xae'")
      << "broken, and a mark that turns the text";
  EXPECT_EQ(model::quoted(std::string(61, 'a')), "'" + std::string(60, 'a') + "...'");
}

TEST(Pattern, WithoutWildcardMatchesTheKeyOnly) {
  EXPECT_TRUE(matches("proxy.networks", "proxy.networks"));
  EXPECT_FALSE(matches("proxy.networks", "proxy.network"));
  EXPECT_FALSE(matches("proxy.networks", "proxy.networks.a"));
  EXPECT_FALSE(matches("proxy.networks", "proxy"));
  EXPECT_FALSE(matches("proxy.networks", "Proxy.networks"));
}

TEST(Pattern, AStarStandsForExactlyOnePart) {
  EXPECT_TRUE(matches("proxy.*.status", "proxy.wsn-1.status"));
  EXPECT_FALSE(matches("proxy.*.status", "proxy.status"));
  EXPECT_FALSE(matches("proxy.*.status", "proxy.wsn-1.7.status"));
  EXPECT_TRUE(matches("*", "a"));
  EXPECT_FALSE(matches("*", "a.b"));
  EXPECT_TRUE(matches("*.*", "a.b"));
  EXPECT_FALSE(matches("a.*", "a"));
}

TEST(Pattern, DoubleStarStandsForTheRest) {
  EXPECT_TRUE(matches("proxy.**", "proxy.a"));
  EXPECT_TRUE(matches("proxy.**", "proxy.a.b.c"));
  EXPECT_FALSE(matches("proxy.**", "proxies.a"));
  EXPECT_TRUE(matches("**", "a"));
  EXPECT_TRUE(matches("**", "a.b.c"));
  EXPECT_TRUE(matches("a.*.**", "a.b"));
  EXPECT_FALSE(matches("a.*.**", "a"));
}

TEST(Pattern, DoubleStarAlsoMatchesNothing) {
  EXPECT_TRUE(matches("proxy.**", "proxy"));
  EXPECT_TRUE(matches("a.b.**", "a.b"));
  EXPECT_FALSE(matches("a.b.**", "a"));
}

TEST(Pattern, AnOwnerStandsBeforeAColon) {
  EXPECT_TRUE(matches("6541:proxy.**", "proxy.a", OwnerId{6541}));
  EXPECT_FALSE(matches("6541:proxy.**", "proxy.a", OwnerId{6542}));
  EXPECT_TRUE(matches("*:proxy.**", "proxy.a", OwnerId{1}));
  EXPECT_TRUE(matches("proxy.**", "proxy.a", OwnerId{1}));
  EXPECT_EQ(Pattern::parse("4294967295:a")->owner, OwnerId{4294967295});
  EXPECT_EQ(Pattern::parse("*:a")->owner, std::nullopt);
}

TEST(Pattern, ABadOwnerIsRefused) {
  for (const std::string text : {"0:a", ":a", "-1:a", "+1:a", "x:a", "1 :a", "4294967296:a", "0x10:a", "**:a"}) {
    EXPECT_EQ(pattern_refusal(text), "pattern '" + text + "': expected an owner id or * before the colon");
  }
  EXPECT_NE(pattern_refusal("1:2:a"), "accepted");
}

TEST(Pattern, BadWildcardsAreRefused) {
  EXPECT_EQ(pattern_refusal("a.**.b"), "pattern 'a.**.b': ** may only be the last part");
  EXPECT_EQ(pattern_refusal("**.**"), "pattern '**.**': ** may only be the last part");
  EXPECT_EQ(pattern_refusal("a.b*"), "key 'a.b*': '*' at position 3; parts are [A-Za-z0-9_-]+");
  EXPECT_EQ(pattern_refusal("***"), "key '***': '*' at position 0; parts are [A-Za-z0-9_-]+");
}

TEST(Pattern, BadKeysAreRefused) {
  EXPECT_EQ(pattern_refusal(""), "key is empty");
  EXPECT_EQ(pattern_refusal("5:"), "key is empty");
  EXPECT_EQ(pattern_refusal("a..*"), "key 'a..*': empty part at position 2");
  EXPECT_EQ(pattern_refusal("a/*"), "key 'a/*': '/' at position 1; parts are [A-Za-z0-9_-]+");
  EXPECT_NE(pattern_refusal("a\n.*"), "accepted");
  EXPECT_NE(pattern_refusal("gr\xc3\xbcn.*"), "accepted");
  EXPECT_NE(pattern_refusal(std::string(10240, '*')), "accepted");
  EXPECT_NE(pattern_refusal(parts_of(kMaxKeyParts + 1, "*")), "accepted");
  EXPECT_EQ(pattern_refusal(parts_of(kMaxKeyParts, "*")), "accepted");
}

TEST(Pattern, IsExactWithoutWildcards) {
  EXPECT_TRUE(Pattern::parse("a.b")->exact());
  EXPECT_TRUE(Pattern::parse("*:a.b")->exact());
  EXPECT_FALSE(Pattern::parse("a.*")->exact());
  EXPECT_FALSE(Pattern::parse("**")->exact());
}

TEST(Pattern, ItsTextParsesBackToIt) {
  for (const std::string text : {"a.b", "6541:a.*.c", "**", "7:**"}) {
    const auto pattern = Pattern::parse(text);
    ASSERT_TRUE(pattern);
    EXPECT_EQ(to_string(*pattern), text);
    EXPECT_EQ(*Pattern::parse(to_string(*pattern)), *pattern);
  }
  EXPECT_EQ(to_string(*Pattern::parse("*:a.b")), "a.b");
}

}  // namespace
}  // namespace rubicon::model
