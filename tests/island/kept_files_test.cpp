#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "island/island_state.h"

namespace rubicon::island {
namespace {

namespace fs = std::filesystem;

/// A folder with a configuration, and a process that would give its files to everybody.
struct KeptConfiguration : testing::Test {
  KeptConfiguration() {
    fs::create_directories(folder);
    std::ofstream(folder / "home.yaml") << "island: {id: 1}\n";
    config.directory = folder.string();
    config.state.file = "home.state";
  }
  ~KeptConfiguration() override {
    ::umask(umask_before);
    fs::remove_all(folder);
  }
  std::string kept() const {
    std::ifstream file(folder / "home.state.good.yaml");
    return {std::istreambuf_iterator<char>(file), {}};
  }

  const fs::path folder = fs::path(testing::TempDir()) / ("rubicon_kept_" + std::to_string(::getpid()));
  const mode_t umask_before = ::umask(0);
  island::IslandConfig config;
};

TEST_F(KeptConfiguration, IsReadByTheGroupAtMost) {
  ASSERT_TRUE(keep_good_config(config, (folder / "home.yaml").string()));
  EXPECT_EQ(kept(), "island: {id: 1}\n");
  EXPECT_EQ(fs::status(folder / "home.state.good.yaml").permissions(), fs::perms(0640));
  std::ofstream(folder / "home.yaml") << "island: {id: 2}\n";
  ASSERT_TRUE(keep_good_config(config, (folder / "home.yaml").string()));
  EXPECT_EQ(kept(), "island: {id: 2}\n");
}

TEST_F(KeptConfiguration, IsNotWrittenThroughASymbolicLink) {
  std::ofstream(folder / "theirs") << "precious";
  fs::create_symlink("theirs", folder / "home.state.good.yaml.new");
  fs::create_symlink("theirs", folder / "home.state.good.yaml");
  ASSERT_TRUE(keep_good_config(config, (folder / "home.yaml").string()));
  EXPECT_EQ(kept(), "island: {id: 1}\n");
  EXPECT_EQ(fs::file_size(folder / "theirs"), 8U);
}

}  // namespace
}  // namespace rubicon::island
