#include "trust/folder_files.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>

#include "support/folder.h"
#include "support/host_group.h"
#include "trust/now.h"

namespace rubicon::trust {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxSize = 4096;
constexpr const char* kKey = "members/hall/key.pem";

void overwrite(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
}

mode_t mode_of(const fs::path& path) {
  struct stat about {};
  EXPECT_EQ(::lstat(path.c_str(), &about), 0) << path;
  return about.st_mode & 07777;
}

/// A folder with a document and a key.
class FilesOfAFolder : public testing::Test {
 protected:
  FilesOfAFolder() {
    for (const auto* name : {"", "members", "members/hall"}) EXPECT_TRUE(files_.make_folder(name, 0755)) << name;
    EXPECT_TRUE(files_.write("realm.p7s", "document", 0644));
    EXPECT_TRUE(files_.write(kKey, "key", 0600));
    EXPECT_TRUE(files_.lock());
  }
  Result<std::string> document() const { return files_.read("realm.p7s", kMaxSize); }

  const support::Folder folder_;
  const fs::path root_ = folder_ / "realm";
  const FolderFiles files_{root_};
};

TEST_F(FilesOfAFolder, WhoMayReadTheFolderCannotHoldItsLock) {
  const auto reader = OwnFile::of_descriptor(::open(root_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  ASSERT_EQ(::flock(reader.get(), LOCK_EX | LOCK_NB), 0);
  EXPECT_TRUE(files_.lock(Duration(0)));
  if (::geteuid() != 0) return;
  const auto child = ::fork();
  if (child == 0) {
    const bool denied = ::setuid(12345) == 0 && ::open((root_ / kLockFile).c_str(), O_RDONLY) < 0 && errno == EACCES;
    ::_exit(denied ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

TEST_F(FilesOfAFolder, TheLockIsForItsOwnerOnlyWhateverWasThere) {
  ASSERT_EQ(::chmod((root_ / kLockFile).c_str(), 0666), 0);
  EXPECT_TRUE(files_.lock());
  EXPECT_EQ(mode_of(root_ / kLockFile), 0600U);
  fs::remove(root_ / kLockFile);
  EXPECT_TRUE(files_.lock());
  EXPECT_EQ(mode_of(root_ / kLockFile), 0600U);
  fs::remove(root_ / kLockFile);
  fs::create_symlink(root_ / "realm.p7s", root_ / kLockFile);
  EXPECT_EQ(files_.lock().error().code, ErrorCode::kRefused);
  if (::geteuid() != 0) return;
  fs::remove(root_ / kLockFile);
  ASSERT_EQ(::chown(root_.c_str(), 12345, 12345), 0);
  EXPECT_TRUE(files_.lock());
  struct stat about {};
  ASSERT_EQ(::stat((root_ / kLockFile).c_str(), &about), 0);
  EXPECT_EQ(about.st_uid, 12345U) << "of the user whose folder it is";
}

/// Root gives the lock of a folder to its owner, and nothing else.
TEST_F(FilesOfAFolder, ALockThatIsALinkOrNoFileIsRefused) {
  const auto lock = root_ / kLockFile, precious = fs::path(folder_ / "precious");
  overwrite(precious, "of root");
  fs::remove(lock);
  fs::create_hard_link(precious, lock);
  ASSERT_TRUE(::geteuid() != 0 || ::chown(root_.c_str(), 12345, 12345) == 0);
  const auto linked = files_.lock();
  ASSERT_FALSE(linked);
  EXPECT_THAT(linked.error().text, testing::HasSubstr(lock.string() + ": is not an ordinary file with one name"));
  struct stat about {};
  ASSERT_EQ(::stat(precious.c_str(), &about), 0);
  EXPECT_EQ(about.st_uid, ::geteuid());
  EXPECT_NE(about.st_mode & 07777U, 0600U);
  fs::remove(lock);
  ASSERT_EQ(::mkfifo(lock.c_str(), 0600), 0);
  EXPECT_EQ(files_.lock().error().code, ErrorCode::kRefused);
  fs::remove(lock);
  EXPECT_TRUE(files_.lock());
  if (::geteuid() != 0) return;
  ASSERT_EQ(::chown(lock.c_str(), 54321, 54321), 0);
  EXPECT_THAT(files_.lock().error().text, testing::HasSubstr("belongs to another user than its folder"));
}

TEST_F(FilesOfAFolder, ALockIsWaitedForUntilALimit) {
  auto held = files_.lock();
  ASSERT_TRUE(held);
  const auto busy = files_.lock(std::chrono::milliseconds(100));
  ASSERT_FALSE(busy);
  EXPECT_EQ(busy.error().code, ErrorCode::kBusy);
  EXPECT_NE(busy.error().text.find((root_ / kLockFile).string()), std::string::npos) << busy.error().text;
  const auto child = ::fork();  // it has the lock too
  if (child == 0) {
    ::usleep(300'000);
    ::_exit(0);
  }
  held = fail(ErrorCode::kNotFound, "given back");
  EXPECT_TRUE(files_.lock(std::chrono::minutes(1)));
  ::waitpid(child, nullptr, 0);
}

TEST_F(FilesOfAFolder, NothingIsLeftBeside) {
  ASSERT_TRUE(files_.write("realm.p7s", "another", 0644));
  for (const auto& entry : fs::recursive_directory_iterator(root_))
    EXPECT_FALSE(entry.path().filename().string().starts_with('.')) << entry.path();
}

TEST_F(FilesOfAFolder, APipeOrAFolderInPlaceOfAFileIsRefused) {
  ASSERT_TRUE(document());
  fs::remove(root_ / "realm.p7s");
  ASSERT_EQ(::mkfifo((root_ / "realm.p7s").c_str(), 0644), 0);
  EXPECT_FALSE(document());
  fs::remove(root_ / "realm.p7s");
  fs::create_directory(root_ / "realm.p7s");
  EXPECT_FALSE(document());
}

TEST_F(FilesOfAFolder, SymbolicLinksAreRefused) {
  for (const auto* name : {"members", "members/hall", kKey}) {
    const auto away = fs::path(folder_ / "moved");
    fs::rename(root_ / name, away);
    fs::create_symlink(away, root_ / name);
    const auto read = files_.read_key(kKey);
    ASSERT_FALSE(read) << name;
    EXPECT_EQ(read.error().code, ErrorCode::kRefused) << read.error().text;
    EXPECT_THAT(read.error().text, testing::HasSubstr("symbolic link"));
    fs::remove(root_ / name);
    fs::rename(away, root_ / name);
  }
  EXPECT_TRUE(files_.read_key(kKey));
}

TEST_F(FilesOfAFolder, NothingIsWrittenThroughASymbolicLink) {
  const auto precious = fs::path(folder_ / "precious");
  overwrite(precious, "mine");
  fs::remove(root_ / "realm.p7s");
  fs::create_symlink(precious, root_ / "realm.p7s");
  ASSERT_TRUE(files_.write("realm.p7s", "text", 0644));
  EXPECT_EQ(content_of(precious), "mine");
  EXPECT_FALSE(fs::is_symlink(root_ / "realm.p7s"));
  fs::rename(root_ / "members", folder_ / "elsewhere");
  fs::create_symlink(folder_ / "elsewhere", root_ / "members");
  EXPECT_FALSE(files_.write(kKey, "text", 0600));
}

TEST_F(FilesOfAFolder, KeysThatOthersMayUseAreRefused) {
  for (const mode_t mode : {0604U, 0602U, 0601U, 0620U, 0644U, 0666U}) {
    ASSERT_EQ(::chmod((root_ / kKey).c_str(), mode), 0);
    const auto read = files_.read_key(kKey);
    ASSERT_FALSE(read) << mode;
    EXPECT_EQ(read.error().code, ErrorCode::kRefused);
    EXPECT_THAT(read.error().text, testing::HasSubstr("chmod 600"));
  }
}

TEST_F(FilesOfAFolder, AKeyIsForTheGroupOfThePeopleOnlyIfThatIsAskedFor) {
  const support::HostGroup people("rubicon");
  if (!people.exists()) GTEST_SKIP() << people.reason();
  const auto key = root_ / kKey;
  ASSERT_EQ(::chown(key.c_str(), static_cast<uid_t>(-1), people.number()), 0);
  ASSERT_EQ(::chmod(key.c_str(), 0640), 0);
  EXPECT_EQ(files_.read_key(kKey, KeyReaders::kOwner).error().code, ErrorCode::kRefused);
  EXPECT_TRUE(files_.read_key(kKey, KeyReaders::kPeople));
  ASSERT_EQ(::chown(key.c_str(), static_cast<uid_t>(-1), people.number() + 1), 0);
  EXPECT_FALSE(files_.read_key(kKey, KeyReaders::kPeople));
}

TEST_F(FilesOfAFolder, OneThatOthersMayChangeIsNotUsed) {
  ASSERT_EQ(::chmod((root_ / "realm.p7s").c_str(), 0666), 0);
  EXPECT_THAT(document().error().text, testing::HasSubstr("realm.p7s: others may change this file"));
  const auto open = fs::path(folder_ / "open");
  fs::create_directory(open);
  ASSERT_EQ(::chmod(open.c_str(), 0777), 0);
  EXPECT_THAT(FolderFiles(open).make_folder("", 0755).error().text,
              testing::HasSubstr("others may change this folder"));
  fs::create_directory(root_ / "ca");
  ASSERT_EQ(::chmod((root_ / "ca").c_str(), 0755), 0);
  ASSERT_TRUE(files_.make_folder("ca", 0700));
  EXPECT_EQ(mode_of(root_ / "ca"), 0700U) << "what was too wide is narrower";
}

}  // namespace
}  // namespace rubicon::trust
