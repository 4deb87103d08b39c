#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "support/memory/memory_transports.h"
#include "transport/local_transports.h"

namespace rubicon::transport {
namespace {

/// Reads in pieces of three bytes, as streams do.
std::string read_all(FileSource& file) {
  std::string text;
  std::uint8_t piece[3];
  for (;;) {
    const auto count = file.read(piece);
    if (!count || *count == 0) return count ? text : text + "!";
    text.append(reinterpret_cast<const char*>(piece), *count);
  }
}

/// The same file on disk and in memory.
class Files : public ::testing::TestWithParam<bool> {
 protected:
  Files() {
    folder_ = std::filesystem::temp_directory_path() / ("rubicon-files-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_ / "sub");
    std::ofstream(path("letters")) << "abcdefgh";
    memory_.put(path("letters"), "abcdefgh");
    memory_.put(path("sub/x"), "");
  }
  ~Files() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  Transports& transports() { return GetParam() ? static_cast<Transports&>(local_) : memory_; }

  std::filesystem::path folder_;
  LocalTransports local_;
  MemoryTransports memory_;
};

TEST_P(Files, AreReadInPiecesToTheEnd) {
  auto file = transports().open_file(path("letters"));
  ASSERT_TRUE(file);
  EXPECT_EQ((*file)->size(), 8u);
  EXPECT_EQ(read_all(**file), "abcdefgh");
  EXPECT_EQ(read_all(**file), "");
}

TEST_P(Files, AreReadFromWhereOneSeeks) {
  auto file = transports().open_file(path("letters"));
  ASSERT_TRUE(file);
  ASSERT_TRUE((*file)->seek(6));
  EXPECT_EQ(read_all(**file), "gh");
  ASSERT_TRUE((*file)->seek(0));
  EXPECT_EQ(read_all(**file), "abcdefgh");
  ASSERT_TRUE((*file)->seek(100));
  EXPECT_EQ(read_all(**file), "");
}

TEST_P(Files, AMissingOneIsNotFoundAndNamed) {
  auto file = transports().open_file(path("nothing"));
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, ErrorCode::kNotFound);
  EXPECT_NE(file.error().text.find(path("nothing")), std::string::npos);
  EXPECT_NE(file.error().text.find("No such file"), std::string::npos);
}

TEST_P(Files, ADirectoryIsRefused) {
  auto file = transports().open_file(path("sub"));
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, ErrorCode::kIo);
  EXPECT_NE(file.error().text.find("is a directory"), std::string::npos);
}

TEST_P(Files, GrowAtTheirEndAndAreCutOff) {
  auto file = transports().open_append(path("letters"));
  ASSERT_TRUE(file) << file.error().text;
  EXPECT_EQ((*file)->size(), 8u);
  ASSERT_TRUE((*file)->append(base::as_bytes("ij")));
  ASSERT_TRUE((*file)->truncate(9));
  ASSERT_TRUE((*file)->append(base::as_bytes("!")));
  EXPECT_EQ((*file)->size(), 10u);
  EXPECT_EQ(read_all(**transports().open_file(path("letters"))), "abcdefghi!");
}

TEST_P(Files, AreMadeWhereThereIsAFolder) {
  ASSERT_TRUE((*transports().open_append(path("sub/new")))->append(base::as_bytes("x")));
  EXPECT_EQ(read_all(**transports().open_file(path("sub/new"))), "x");
  memory_.lose_folder(path("lost"));
  const auto refused = transports().open_append(path("lost/new"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kNotFound);
}

TEST_P(Files, HaveOneWriterAtATime) {
  auto first = transports().open_append(path("letters"));
  const auto second = transports().open_append(path("letters"));
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kBusy);
  first->reset();
  EXPECT_TRUE(transports().open_append(path("letters")));
}

TEST_P(Files, AreRenamedButNeverOverAnother) {
  ASSERT_TRUE(transports().open_append(path("other")));
  EXPECT_EQ(transports().rename_file(path("letters"), path("other")).error().code, ErrorCode::kDuplicate);
  ASSERT_TRUE(transports().rename_file(path("letters"), path("sub/letters")));
  EXPECT_FALSE(transports().open_file(path("letters")));
  EXPECT_EQ(read_all(**transports().open_file(path("sub/letters"))), "abcdefgh");
  EXPECT_EQ(transports().rename_file(path("letters"), path("again")).error().code, ErrorCode::kNotFound);
}

TEST_P(Files, AreListedAndRemoved) {
  ASSERT_TRUE(transports().open_append(path("b")));
  EXPECT_EQ(transports().list_folder(folder_.string()).value(), (std::vector<std::string>{"b", "letters"}));
  ASSERT_TRUE(transports().remove_file(path("b")));
  EXPECT_EQ(transports().remove_file(path("b")).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(transports().list_folder(folder_.string()).value(), std::vector<std::string>{"letters"});
}

/// Of recordings and packet logs.
TEST(LocalFiles, ThatAreAppendedToAreReadByTheirGroupAtMostAndNoLinks) {
  namespace fs = std::filesystem;
  const auto folder = fs::temp_directory_path() / ("rubicon-modes-" + std::to_string(::getpid()));
  fs::create_directories(folder);
  const auto umask_before = ::umask(0);
  LocalTransports local;
  ASSERT_TRUE(local.open_append((folder / "new").string()));
  EXPECT_EQ(fs::status(folder / "new").permissions(), fs::perms(0640));
  fs::create_symlink("new", folder / "link");
  const auto link = local.open_append((folder / "link").string());
  ASSERT_FALSE(link);
  EXPECT_NE(link.error().text.find((folder / "link").string() + ": is a symbolic link"), std::string::npos);
  ::umask(umask_before);
  fs::remove_all(folder);
}

INSTANTIATE_TEST_SUITE_P(LocalAndMemory, Files, ::testing::Bool(),
                         [](const auto& which) { return which.param ? "Local" : "Memory"; });

TEST(LocalTransports, RefusesAFifoInsteadOfBlocking) {
  const auto path = std::filesystem::temp_directory_path() / ("rubicon-fifo-" + std::to_string(::getpid()));
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  LocalTransports local;
  const auto file = local.open_file(path.string());
  std::filesystem::remove(path);
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().text.find("not a regular file"), std::string::npos);
}

TEST(LocalTransports, AppendsToNoFifoAndNoFolder) {
  const auto path = std::filesystem::temp_directory_path() / ("rubicon-pipe-" + std::to_string(::getpid()));
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  LocalTransports local;
  EXPECT_FALSE(local.open_append(path.string()));
  std::filesystem::remove(path);
  EXPECT_FALSE(local.open_append(std::filesystem::temp_directory_path().string()));
}

TEST(MemoryTransports, ADiskTakesWhatItHasRoomFor) {
  MemoryTransports memory;
  memory.room(3);
  auto file = memory.open_append("a");
  EXPECT_EQ((*file)->append(base::as_bytes("abcd")).error().code, ErrorCode::kIo);
  EXPECT_EQ((*file)->size(), 3u);
  ASSERT_TRUE((*file)->truncate(0));
  EXPECT_TRUE((*file)->append(base::as_bytes("xyz")));
}

TEST(MemoryTransports, FailsWhereATestWants) {
  MemoryTransports memory;
  memory.put("a", "abcdefgh");
  memory.fail_at("a", 4);
  auto file = memory.open_file("a");
  ASSERT_TRUE(file);
  EXPECT_EQ(read_all(**file), "abcd!");
  memory.remove("a");
  EXPECT_EQ(read_all(**file), "!");
}

}  // namespace
}  // namespace rubicon::transport
