#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "apps/rubicon/live_island.h"

namespace rubicon::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string file_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// `rubicon web enable` for the file of an island.
class WebEnable : public testing::Test {
 protected:
  Outcome enable(const std::string& name, std::vector<std::string> more = {}) const {
    std::vector<std::string> words{"web", "enable", folder_.file(name)};
    words.insert(words.end(), more.begin(), more.end());
    return rubicon(std::move(words));
  }
  /// The line that begins with a word.
  static std::string line(const Outcome& outcome, const std::string& word) {
    std::istringstream lines(outcome.output);
    for (std::string one; std::getline(lines, one);) {
      if (one.starts_with(word)) return one;
    }
    return "(none) " + outcome.output + outcome.errors;
  }
  Outcome check(const std::string& name) const { return support::run_to_end({kDaemon, "check", folder_.file(name)}); }

  const Folder folder_;
};

TEST_F(WebEnable, WritesTheSectionAndATokenAndTellsBoth) {
  const auto before = small_island(6541);
  folder_.write("home.yaml", before);
  ::chmod(folder_.file("home.yaml").c_str(), 0604);
  const auto done = enable("home.yaml");
  ASSERT_EQ(done.code, 0) << done.errors;
  EXPECT_EQ(line(done, "open"), "open   http://127.0.0.1:8642");
  const auto token = line(done, "token").substr(7, 32);
  EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), token.npos) << done.output;
  EXPECT_THAT(file_text(folder_.file("home.yaml")),
              AllOf(testing::StartsWith(before), HasSubstr("\nweb: "), HasSubstr("tokens: {file: home.tokens}")));
  EXPECT_EQ(file_text(folder_.file("home.yaml.previous")), before);
  EXPECT_FALSE(std::filesystem::exists(folder_.file("home.yaml.new")));
  EXPECT_THAT(file_text(folder_.file("home.tokens")),
              AllOf(testing::StartsWith("admin:admin:"), Not(HasSubstr(token))));
  struct stat about {};
  ASSERT_EQ(::stat(folder_.file("home.yaml").c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0604U);
  EXPECT_EQ(check("home.yaml").code, 0);
}

TEST_F(WebEnable, ChangesNothingTheSecondTime) {
  folder_.write("home.yaml", small_island(6541));
  ASSERT_EQ(enable("home.yaml").code, 0);
  const auto file = file_text(folder_.file("home.yaml")), tokens = file_text(folder_.file("home.tokens"));
  std::filesystem::remove(folder_.file("home.yaml.previous"));
  const auto again = enable("home.yaml");
  EXPECT_EQ(again.code, 0) << again.errors;
  EXPECT_EQ(line(again, "open"), "open   http://127.0.0.1:8642");
  EXPECT_THAT(line(again, "token"), HasSubstr("admin has one already"));
  EXPECT_EQ(file_text(folder_.file("home.yaml")), file);
  EXPECT_EQ(file_text(folder_.file("home.tokens")), tokens);
  EXPECT_FALSE(std::filesystem::exists(folder_.file("home.yaml.previous")));
  EXPECT_EQ(enable("home.yaml", {"--name", "tablet"}).code, 0);
  EXPECT_THAT(file_text(folder_.file("home.tokens")), HasSubstr("tablet:admin:"));
}

TEST_F(WebEnable, PutsTokensIntoASectionThatIsThere) {
  const std::vector<std::pair<std::string, std::string>> table{
      {"web: {}\n", "web: {tokens: {file: home.tokens}}\n"},
      {"web: {listen: \"127.0.0.1:8700\"}   # mine\n",
       "web: {tokens: {file: home.tokens}, listen: \"127.0.0.1:8700\"}   # mine\n"},
      {"web:\n    listen: \"127.0.0.1:8700\"\n    compress: yes\n",
       "web:\n    tokens: {file: home.tokens}\n    listen: \"127.0.0.1:8700\"\n    compress: yes\n"},
      {"web:   # the page\n  listen: \"127.0.0.1:8700\"\n",
       "web:   # the page\n  tokens: {file: home.tokens}\n  listen: \"127.0.0.1:8700\"\n"},
      {"web:", "web:\n  tokens: {file: home.tokens}"},
  };
  for (const auto& [section, expected] : table) {
    std::filesystem::remove(folder_.file("home.tokens"));
    folder_.write("home.yaml", small_island(6541) + section);
    const auto done = enable("home.yaml");
    EXPECT_EQ(done.code, 0) << section << done.errors;
    EXPECT_EQ(file_text(folder_.file("home.yaml")), small_island(6541) + expected);
    EXPECT_EQ(check("home.yaml").code, 0) << section;
  }
  EXPECT_EQ(line(enable("home.yaml", {"--name", "x"}), "open"), "open   http://127.0.0.1:8642");
}

TEST_F(WebEnable, LeavesAFileThatIsWrongAsItIs) {
  const auto wrong = small_island(6541) + "rights: [{who: nobody}]\n";
  folder_.write("home.yaml", wrong);
  const auto done = enable("home.yaml");
  EXPECT_EQ(done.code, 2);
  EXPECT_THAT(done.errors, AllOf(HasSubstr("rights"), HasSubstr("stays as it was")));
  EXPECT_EQ(file_text(folder_.file("home.yaml")), wrong);
  EXPECT_FALSE(std::filesystem::exists(folder_.file("home.yaml.new")));
  EXPECT_FALSE(std::filesystem::exists(folder_.file("home.tokens")));
}

TEST_F(WebEnable, SaysWhatToDoWhereItMayNotOrCannot) {
  EXPECT_THAT(enable("none.yaml").errors, HasSubstr("there is no file"));
  folder_.write("home.yaml",
                small_island(6541) + "web: {tokens: {file: /run/credentials/rubicon-proxy@home.service/web.tokens}}\n");
  EXPECT_THAT(enable("home.yaml").errors, HasSubstr("LoadCredential"));
  folder_.write("home.yaml", small_island(6541));
  // As another user, in a folder of root.
  const auto as_nobody = support::run_to_end({"setpriv", "--reuid", "65534", "--regid", "65534", "--clear-groups",
                                              kProgram, "web", "enable", folder_.file("home.yaml")});
  if (as_nobody.errors.find("setpriv") == 0) GTEST_SKIP() << "cannot be another user here";
  EXPECT_EQ(as_nobody.code, 1);
  EXPECT_THAT(as_nobody.errors, AllOf(HasSubstr("home.yaml"), HasSubstr("as root: sudo rubicon web enable")));
  EXPECT_EQ(file_text(folder_.file("home.yaml")), small_island(6541));
}

TEST_F(WebEnable, AnIslandSaysHowAMissingTokenIsMade) {
  const PrivateNetwork alone;
  if (!alone.entered()) GTEST_SKIP() << alone.reason();
  folder_.write("home.yaml", small_island(6541) + "web: {listen: \"127.0.0.1:0\", tokens: {file: home.tokens}}\n");
  Process island({kDaemon, "run", folder_.file("home.yaml"), "--shell"});
  island.write("stats\n");
  EXPECT_TRUE(island.line_with("\"ok\""));
  island.signal(SIGTERM);
  EXPECT_EQ(island.exit_code(), 0);
  EXPECT_THAT(island.errors(),
              HasSubstr("`rubicon web enable` makes it, with a token; the island runs without its page"));
}

}  // namespace
}  // namespace rubicon::cli
