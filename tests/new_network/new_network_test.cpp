#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "support/process.h"

namespace rubicon::new_network {
namespace {

namespace fs = std::filesystem;
using testing::ContainsRegex;
using testing::HasSubstr;

std::string read_text(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The shell blocks of the section `Steps` of docs/adding-a-network.md, in their order.
std::string steps_of(const std::string& page) {
  const auto begin = page.find("\n## Steps\n");
  if (begin == page.npos) return {};
  const auto section = page.substr(begin, page.find("\n## ", begin + 1) - begin);
  std::string steps;
  for (auto block = section.find("```sh\n"); block != section.npos; block = section.find("```sh\n", block)) {
    block += 6;
    steps += section.substr(block, section.find("```", block) - block);
  }
  return steps;
}

/// A copy of the project beside its build; removed when the test ends.
class NewNetwork : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(root_);
    fs::create_directories(tree_);
    for (const auto* folder : {"apps", "bench", "cmake", "docs", "examples", "include", "src", "tests"})
      fs::copy(fs::path(RUBICON_SOURCE_DIR) / folder, tree_ / folder, fs::copy_options::recursive);
    fs::copy(fs::path(RUBICON_SOURCE_DIR) / "run", tree_ / "run");
  }
  void TearDown() override {
    if (!HasFailure()) fs::remove_all(root_);
  }
  static void run(const std::string& command) {
    const auto ended = support::run_to_end({"/bin/sh", "-ec", command});
    EXPECT_EQ(ended.code, 0) << command << '\n' << ended.output << ended.errors;
  }

  const fs::path root_ = fs::path(RUBICON_BINARY_DIR) / "new_network";
  const fs::path tree_ = root_ / "tree", build_ = root_ / "build";
};

TEST_F(NewNetwork, IsBuiltByTheStepsOfThePageAndPassesTheContract) {
  const auto steps = steps_of(read_text(fs::path(RUBICON_SOURCE_DIR) / "docs/adding-a-network.md"));
  ASSERT_THAT(steps, HasSubstr("cp -r examples/network-template src/networks/mine"));
  run("cd " + tree_.string() + "\n" + steps);
  run("RUBICON_TREE=" + tree_.string() + " " RUBICON_BINARY_DIR "/bin/structure_test --gtest_brief=1");
  run(RUBICON_CMAKE " -G Ninja -S " + (tree_ / "tests/new_network").string() + " -B " + build_.string() +
      " -DTREE=" + tree_.string() +
      " -DBUILD=" RUBICON_BINARY_DIR " -DCMAKE_CXX_COMPILER=" RUBICON_CXX " -DCMAKE_BUILD_TYPE=" RUBICON_BUILD_TYPE
      " -DRUBICON_SANITIZE=" RUBICON_SANITIZE);
  for (const auto* target : {"rubicon_networks_mine", "new_network_contract"})
    run(RUBICON_CMAKE " --build " + build_.string() + " --target " + target);
  const auto contract = build_.string() + "/new_network_contract --gtest_brief=1 --gtest_filter='*/mine'";
  const auto ended = support::run_to_end({"/bin/sh", "-c", contract});
  EXPECT_EQ(ended.code, 0) << ended.output << ended.errors;
  EXPECT_THAT(ended.output, ContainsRegex(R"(PASSED  \] [1-9][0-9]+ tests)"))
      << "did the contract test see the new network?";
}

}  // namespace
}  // namespace rubicon::new_network
