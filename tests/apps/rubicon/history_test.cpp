#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "apps/rubicon/live_island.h"

namespace rubicon::cli {
namespace {

using testing::HasSubstr;

TEST(HistoryCommand, CompactCreatesNoFile) {
  Folder folder;
  const auto compacted = rubicon({"history", folder.file("typo.history"), "compact"});
  EXPECT_EQ(compacted.code, 1) << compacted.output;
  EXPECT_THAT(compacted.errors, HasSubstr("does not exist"));
  EXPECT_FALSE(std::filesystem::exists(folder.file("typo.history")));
}

TEST(HistoryCommand, LeavesAFileThatIsNoHistory) {
  Folder folder;
  const auto notes = folder.write("notes.txt", std::string(2000, 'n'));
  for (const auto* command : {"info", "compact"}) {
    const auto refused = rubicon({"history", notes, command});
    EXPECT_EQ(refused.code, 1) << refused.output;
    EXPECT_THAT(refused.errors, HasSubstr("is not an SQLite database"));
  }
  EXPECT_FALSE(std::filesystem::exists(notes + "-lock"));
}

}  // namespace
}  // namespace rubicon::cli
