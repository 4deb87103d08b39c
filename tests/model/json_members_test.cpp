#include "model/json_members.h"

#include <gtest/gtest.h>

#include <limits>

namespace rubicon::model {
namespace {

TEST(JsonMembers, OfAnotherKindAreEmpty) {
  const auto odd = object_of(R"({"ok": 1, "id": 7, "text": true, "count": -1, "share": 0.5, "list": "x"})");
  EXPECT_FALSE(flag_of(odd, "ok"));
  EXPECT_EQ(text_of(odd, "id"), "");
  EXPECT_EQ(number_of(odd, "text"), 0);
  EXPECT_EQ(count_of(odd, "count"), 0U);
  EXPECT_EQ(count_of(odd, "share"), 0U);
  EXPECT_TRUE(texts_of(odd, "list").empty());
  EXPECT_EQ(time_of(odd, "count"), WallTime{});
  EXPECT_FALSE(flag_of(object_of("7"), "ok"));
}

TEST(JsonMembers, OfTheRightKindAreRead) {
  const auto good = object_of(R"({"ok": true, "count": 18446744073709551615, "list": ["a", 7, "b"]})");
  EXPECT_TRUE(flag_of(good, "ok"));
  EXPECT_EQ(count_of(good, "count"), 18446744073709551615U);
  EXPECT_EQ(texts_of(good, "list"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(dump(good["list"]), R"(["a",7,"b"])");
}

TEST(JsonMembers, TimesAreSecondsWithAFraction) {
  EXPECT_EQ(time_from_seconds(1.5), WallTime(std::chrono::microseconds(1500000)));
  EXPECT_EQ(time_from_seconds(-1), WallTime{});
  EXPECT_EQ(time_from_seconds(1e300), WallTime{});
  EXPECT_EQ(time_from_seconds(std::numeric_limits<double>::quiet_NaN()), WallTime{});
  EXPECT_EQ(dump(seconds_json(time_from_seconds(1767225600))), "1767225600");
  const auto text_of_micros = [](std::int64_t micros) {
    std::string text;
    append_seconds(WallTime(std::chrono::microseconds(micros)), text);
    return text;
  };
  EXPECT_EQ(text_of_micros(1'767'225'600'250'000), "1767225600.25");
  EXPECT_EQ(text_of_micros(1'000'001), "1.000001");
  EXPECT_EQ(text_of_micros(100'000), "0.1");
  EXPECT_EQ(text_of_micros(0), "0");
  EXPECT_EQ(text_of_micros(-1'500'000), "-1") << "before 1970: whole seconds";
}

TEST(JsonMembers, BrokenTextIsReplaced) {
  std::string out;
  append_json("a\xff", out);
  EXPECT_EQ(out, "\"a\xef\xbf\xbd\"");
}

}  // namespace
}  // namespace rubicon::model
