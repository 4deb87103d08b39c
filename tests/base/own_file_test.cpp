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

TEST_F(OwnFiles, AreNotWrittenThroughASymbolicLink) {
  const auto path = (folder / "link").string();
  std::ofstream(folder / "theirs") << "precious";
  fs::create_symlink("theirs", path);
  const auto file = OwnFile::open(path, O_WRONLY | O_TRUNC);
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, ErrorCode::kRefused);
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
