#include "rights/rights.h"

#include <gmock/gmock.h>

namespace rubicon::rights {
namespace {

TEST(Rule, KeysAreCheckedPartByPart) {
  for (const auto* good : {"a", "**", "*", "proxy.**", "proxy.*.*.sensor.motion-*.**", "a.*b*c.d", "island:2", "own"})
    EXPECT_TRUE(check_rule_key(good)) << good;
  for (const auto* bad : {"", ".", "a.", ".a", "a..b", "**.a", "a**", "a.**b", "1:a", "island:", "island:0",
                          "island:70000", "island:2.a", "a b", "a?", "\xc3\xa4", "1.2.3.4.5.6.7.8.9.10.11.12.13"})
    EXPECT_FALSE(check_rule_key(bad)) << bad;
  EXPECT_FALSE(check_rule_key(std::string(256, 'a')));
  EXPECT_EQ(check_rule_key("a..b").error().text,
            "'a..b': expected parts of A-Z a-z 0-9 _ - joined by dots, with * for any text in a part and ** for all "
            "that follow, or island:<id>");
}

TEST(Rule, NamesAreThoseOfCertificatesOrTheWords) {
  for (const auto* good :
       {"robot", "everybody", "peis", "island:2", "anna@home", "a.b-c_d", "user:ann@hall", "token:t@hall"})
    EXPECT_TRUE(check_who(good)) << good;
  for (const auto* bad : {"", "a b", "island:", "island:x", "island:65533", "a,b", "*"})
    EXPECT_FALSE(check_who(bad)) << bad;
  EXPECT_FALSE(check_who(std::string(65, 'a')));
}

TEST(Rule, EachRightHasItsWord) {
  for (const auto right : kRights) EXPECT_EQ(right_of(to_string(right)), right);
  EXPECT_FALSE(right_of("all"));
  EXPECT_FALSE(right_of("write"));
}

}  // namespace
}  // namespace rubicon::rights
