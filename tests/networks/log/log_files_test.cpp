#include <gtest/gtest.h>

#include "networks/log/file_chain.h"

namespace rubicon::networks::log {
namespace {

using Paths = std::vector<std::string>;

TEST(FileList, RelativePathsStartAtTheDirectoryOfTheConfiguration) {
  EXPECT_EQ(list_files({"a.csv", "/b.csv", "../c.csv"}, "/etc/rubicon").value(),
            (Paths{"/etc/rubicon/a.csv", "/b.csv", "/etc/c.csv"}));
  EXPECT_EQ(list_files({"a.csv"}, "").value(), (Paths{"a.csv"}));
}

TEST(FileList, AWildcardGivesWhatIsThereInNaturalOrder) {
  const auto found = list_files({"tests/networks/log/log_*_test.cpp"}, RUBICON_SOURCE_DIR);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->size(), 7u);
  EXPECT_EQ(found->front(), RUBICON_SOURCE_DIR "/tests/networks/log/log_csv_reader_test.cpp");
}

TEST(FileList, AWildcardThatFitsNothingIsAnError) {
  EXPECT_EQ(list_files({"tests/networks/none_*"}, RUBICON_SOURCE_DIR).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(list_files({"tests/no such folder/*"}, RUBICON_SOURCE_DIR).error().code, ErrorCode::kNotFound);
}

TEST(FileList, WildcardsFitAsInAShell) {
  EXPECT_TRUE(matches_wildcard("a*.csv", "a12.csv"));
  EXPECT_TRUE(matches_wildcard("*", ""));
  EXPECT_TRUE(matches_wildcard("*a*b", "xaxbab"));
  EXPECT_TRUE(matches_wildcard("?.csv", "1.csv"));
  EXPECT_FALSE(matches_wildcard("?.csv", "12.csv"));
  EXPECT_FALSE(matches_wildcard("a*.csv", "a12.csv.bak"));
}

TEST(FileList, NumbersInNamesCountAsNumbers) {
  EXPECT_TRUE(natural_less("RSS_2.csv", "RSS_10.csv"));
  EXPECT_FALSE(natural_less("RSS_10.csv", "RSS_2.csv"));
  EXPECT_TRUE(natural_less("RSS_002.csv", "RSS_3.csv"));
  EXPECT_TRUE(natural_less("a", "b"));
  EXPECT_FALSE(natural_less("a", "a"));
}

TEST(FileList, TheLastNumberInANameIsItsKey) {
  EXPECT_EQ(number_in_name("/data/2024/MovementAAL_RSS_017.csv"), "17");
  EXPECT_EQ(number_in_name("17"), "17");
  EXPECT_EQ(number_in_name("day_0.csv"), "0");
  EXPECT_EQ(number_in_name("/data/2024/plain.csv"), "");
}

}  // namespace
}  // namespace rubicon::networks::log
