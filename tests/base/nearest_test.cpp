#include "base/compare_text.h"

#include <gtest/gtest.h>

namespace rubicon::base {
namespace {

using Words = std::vector<std::string>;

TEST(Nearest, InsertedDeletedReplacedAndSwappedLettersCountOneEach) {
  EXPECT_EQ(edit_distance("silence", "silence"), 0u);
  EXPECT_EQ(edit_distance("silnce", "silence"), 1u);
  EXPECT_EQ(edit_distance("silennce", "silence"), 1u);
  EXPECT_EQ(edit_distance("silance", "silence"), 1u);
  EXPECT_EQ(edit_distance("lihgt", "light"), 1u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
}

TEST(Nearest, CaseDoesNotMatter) {
  EXPECT_EQ(edit_distance("Temperature", "temperature"), 0u);
  EXPECT_EQ(nearest("Temperature", {"humidity", "temperature"}), Words{"temperature"});
}

TEST(Nearest, TheNearestComesFirst) {
  EXPECT_EQ(nearest("lamp-3", {"lamps-33", "lamp-1", "lamp-30"}), (Words{"lamp-1", "lamp-30", "lamps-33"}));
}

TEST(Nearest, ShortWordsHaveFewNeighbours) {
  EXPECT_EQ(nearest("gte", {"get", "set", "tree"}), Words{"get"});
  EXPECT_TRUE(nearest("frobnicate", {"get", "set", "tree", "devices"}).empty());
}

TEST(Nearest, TheBeginningOfAWordFindsTheWhole) {
  EXPECT_EQ(nearest("temp", {"light", "temperature"}), Words{"temperature"});
  EXPECT_TRUE(nearest("te", {"temperature"}).empty());
}

TEST(Nearest, AtMostSoManyAndNoneTwice) {
  EXPECT_EQ(nearest("lamp-9", {"lamp-1", "lamp-1", "lamp-2", "lamp-3", "lamp-4"}),
            (Words{"lamp-1", "lamp-2", "lamp-3"}));
  EXPECT_EQ(nearest("lamp-9", {"lamp-1", "lamp-2"}, 1), Words{"lamp-1"});
}

TEST(Nearest, NothingAndVeryLongWordsAreNoSlips) {
  EXPECT_TRUE(nearest("", {"a"}).empty());
  EXPECT_TRUE(nearest(std::string(101, 'a'), {std::string(101, 'a')}).empty());
}

TEST(Nearest, TheQuestionNamesWhatIsNear) {
  EXPECT_EQ(did_you_mean("wacth", {"watch", "get"}), "did you mean 'watch'?");
  EXPECT_EQ(did_you_mean("lamp-9", {"lamp-1", "lamp-2", "lamp-3"}), "did you mean 'lamp-1', 'lamp-2' or 'lamp-3'?");
  EXPECT_EQ(did_you_mean("frobnicate", {"get"}), "");
  EXPECT_EQ(did_you_mean("lamp-1", {"lamp-2", "lamp-1"}), "") << "it is no misspelling";
}

}  // namespace
}  // namespace rubicon::base
