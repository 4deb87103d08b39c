#include "web/access/token_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"

namespace rubicon::web::access {
namespace {

class NewTokens : public testing::Test {
 protected:
  NewTokens() : path_(testing::TempDir() + "rubicon_web_tokens") { std::filesystem::remove(path_); }
  ~NewTokens() override { std::filesystem::remove(path_); }

  std::string path_;
  transport::Loop loop_;
  transport::LocalTransports files_{loop_};
};

TEST_F(NewTokens, AreAppendedAndOnlyTheirHashIsKept) {
  const auto first = add_token(files_, path_, "viewer", Role::kView);
  const auto second = add_token(files_, path_, "owner", Role::kAdmin);
  ASSERT_TRUE(first && second);
  const auto tokens = read_tokens(files_, path_);
  ASSERT_TRUE(tokens) << tokens.error().text;
  ASSERT_EQ(tokens->size(), 2U);
  EXPECT_EQ(tokens->at(0), (Token{"viewer", Role::kView, sha256(*first)}));
  EXPECT_EQ(tokens->at(1), (Token{"owner", Role::kAdmin, sha256(*second)}));
  struct stat about {};
  ASSERT_EQ(::stat(path_.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0640U);
}

TEST(TokenFile, NamesRolesForRulesBehindTheRole) {
  const auto hash = std::string(64, 'a');
  const auto tokens = parse_tokens("tablet: command, panel,night :" + hash + "\nplain:view:" + hash + "\n");
  ASSERT_TRUE(tokens) << tokens.error().text;
  EXPECT_EQ(tokens->at(0).role, Role::kCommand);
  EXPECT_EQ(tokens->at(0).roles, (std::vector<std::string>{"panel", "night"}));
  EXPECT_TRUE(tokens->at(1).roles.empty());
  for (const auto* roles : {"panel,command", "view,", "view,two words", "view,,night", ",view"})
    EXPECT_FALSE(parse_tokens("tablet:" + std::string(roles) + ":" + hash)) << roles;
  std::string many = "view";
  for (int i = 0; i < 17; ++i) many += ",r";
  EXPECT_FALSE(parse_tokens("tablet:" + many + ":" + hash));
}

TEST(TokenFile, HasNoNameThatMeansOthersInRights) {
  const auto hash = std::string(64, 'a');
  for (const auto* word : {"everybody", "peis", "all"}) {
    const auto tokens = parse_tokens("hall:view:" + hash + "\n" + word + ":view:" + hash + "\n");
    ASSERT_FALSE(tokens) << word;
    EXPECT_EQ(tokens.error().text,
              fmt::format("line 2: '{}' is not a name of a token: it means something else in rights, "
                          "expected another",
                          word));
    const auto roles = parse_tokens(fmt::format("tablet:view,{}:{}\n", word, hash));
    ASSERT_FALSE(roles) << word;
    EXPECT_NE(roles.error().text.find("not `everybody`, `peis` or `all`"), std::string::npos) << roles.error().text;
  }
}

TEST(TokenFile, GivesTheNamesAndRolesThatRulesMayName) {
  const std::string hash(64, 'a');
  const auto tokens = parse_tokens("tablet:command,panel:" + hash + "\nhall:view:" + hash + "\n");
  ASSERT_TRUE(tokens) << tokens.error().text;
  EXPECT_EQ(names_of(*tokens), (std::vector<std::string>{"tablet", "command", "panel", "hall", "view"}));
}

TEST_F(NewTokens, ComeOnALineOfTheirOwn) {
  std::ofstream(path_) << "# no line end";
  ASSERT_TRUE(add_token(files_, path_, "viewer", Role::kView));
  EXPECT_EQ(read_tokens(files_, path_)->size(), 1U);
}

TEST_F(NewTokens, OfANameThatHasOneAreRefused) {
  ASSERT_TRUE(add_token(files_, path_, "viewer", Role::kView));
  const auto again = add_token(files_, path_, "viewer", Role::kAdmin);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::kDuplicate);
  EXPECT_FALSE(add_token(files_, path_, "two words", Role::kView));
  EXPECT_FALSE(add_token(files_, path_, "peis", Role::kView));
}

TEST_F(NewTokens, AreNotAppendedToAnotherFile) {
  std::ofstream(path_) << "island: {id: 1}\n";
  EXPECT_FALSE(add_token(files_, path_, "viewer", Role::kView));
  std::ifstream file(path_);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "island: {id: 1}\n");
}

}  // namespace
}  // namespace rubicon::web::access
