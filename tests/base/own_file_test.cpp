#include "base/own_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace rubicon::base {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A folder, and a process that would give its files to everybody.
struct OwnFiles : testing::Test {
  OwnFiles() { fs::create_directories(folder); }
  ~OwnFiles() override {
    ::umask(before);
    fs::remove_all(folder);
  }
  const fs::path folder = fs::path(testing::TempDir()) / ("rubicon_own_file_" + std::to_string(::getpid()));
  const mode_t before = ::umask(0);
};

TEST_F(OwnFiles, AreReadByTheirUserAndGroupOnly) {
  const auto path = (folder / "new").string();
  const auto file = OwnFile::open(path, O_WRONLY);
  ASSERT_TRUE(file) << file.error().text;
  ASSERT_TRUE(file->write("text", path));
  EXPECT_EQ(fs::status(path).permissions(), fs::perms(0640));
  EXPECT_EQ(fs::file_size(path), 4U);
}

TEST_F(OwnFiles, ThatEverybodyMayReadAreClosedToOthersAndTheRestIsLeftAlone) {
  for (const auto& [before_it, after_it] : {std::pair{0644, 0640}, {0666, 0640}, {0600, 0600}, {0660, 0660}}) {
    const auto path = (folder / std::to_string(before_it)).string();
    const auto mode = [&] { return static_cast<int>(fs::status(path).permissions()); };
    std::ofstream(path) << "text";
    fs::permissions(path, fs::perms(before_it));
    ASSERT_TRUE(OwnFile::open(path, O_WRONLY));
    EXPECT_EQ(mode(), after_it);
    fs::permissions(path, fs::perms(before_it));
    OwnFile::close_to_others(path);
    EXPECT_EQ(mode(), after_it);
    EXPECT_EQ(fs::file_size(path), 4U);
  }
}

TEST_F(OwnFiles, AreNotClosedToOthersThroughASymbolicLink) {
  std::ofstream(folder / "theirs") << "for all";
  fs::create_symlink("theirs", folder / "link");
  OwnFile::close_to_others((folder / "link").string());
  OwnFile::close_to_others((folder / "absent").string());
  EXPECT_EQ(fs::status(folder / "theirs").permissions(), fs::perms(0666));
  EXPECT_FALSE(fs::exists(folder / "absent"));
}

TEST_F(OwnFiles, AreNotWrittenThroughASymbolicLink) {
  const auto path = (folder / "link").string();
  std::ofstream(folder / "theirs") << "precious";
  fs::create_symlink("theirs", path);
  const auto file = OwnFile::open(path, O_WRONLY | O_TRUNC);
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, ErrorCode::kInvalid);
  EXPECT_THAT(file.error().text, HasSubstr(path + ": is a symbolic link"));
  EXPECT_EQ(fs::file_size(folder / "theirs"), 8U);
}

TEST_F(OwnFiles, OfAnAbsentFolderAreNamed) {
  const auto path = (folder / "none" / "file").string();
  const auto file = OwnFile::open(path, O_WRONLY);
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(file.error().text, HasSubstr(path));
}

}  // namespace
}  // namespace rubicon::base
