#include "networks/knx/secure/passwords.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "support/folder.h"
#include "transport/local_transports.h"

namespace rubicon::networks::knx::secure {
namespace {

using std::filesystem::perms;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kVariable = "RUBICON_TEST_KNX_PASSWORD";

class PasswordFile : public ::testing::Test {
 protected:
  ~PasswordFile() override { ::unsetenv(kVariable); }

  Result<Secret> read(const std::string& content, perms mode = perms::owner_read | perms::owner_write) {
    std::ofstream(path_) << content;
    std::filesystem::permissions(path_, mode);
    return read_password_file(files_, path_);
  }

  support::Folder folder_;
  std::string path_ = folder_ / "password";
  transport::LocalTransports files_;
};

TEST_F(PasswordFile, HasOneLine) {
  EXPECT_EQ(read("s3cret")->text(), "s3cret");
  EXPECT_EQ(read("with blank \n")->text(), "with blank ");
  EXPECT_EQ(read("dos\r\n")->text(), "dos");
  EXPECT_EQ(read("\xef\xbb\xbfnotepad\r\n")->text(), "notepad") << "the mark of UTF-8 on Windows";
  EXPECT_EQ(read("\xef\xbb\xbf" + std::string(1024, 'x') + "\r\n")->size(), 1024U);
  EXPECT_EQ(read(std::string(1024, 'x') + "\r\n")->size(), 1024U);
}

TEST_F(PasswordFile, OtherwiseItIsRefusedWithoutTheContent) {
  for (const auto& content : {std::string(), std::string("\n"), std::string("\xef\xbb\xbf\n"),
                              std::string("s3cret\nmore"), std::string(1025, 's')}) {
    const auto password = read(content);
    ASSERT_FALSE(password);
    EXPECT_THAT(password.error().text, AllOf(HasSubstr("expected one line"), Not(HasSubstr("s3cret"))));
  }
  EXPECT_EQ(read_password_file(files_, folder_ / "none").error().code, ErrorCode::kNotFound);
}

TEST_F(PasswordFile, OfAWrongPasswordTheSourceIsNamedAndBlanksButNothingOfIt) {
  const auto source = [](const char* text, const char* path) {
    return password_source(Secret::of_text(text), path, kVariable);
  };
  EXPECT_EQ(source("s3cret", "hall.password"), " (the password is from hall.password)");
  EXPECT_EQ(source("s3cret ", "hall.password"),
            " (the password is from hall.password, and begins or ends with a blank)");
  EXPECT_EQ(source("\ts3cret", ""),
            " (the password is from the environment variable RUBICON_TEST_KNX_PASSWORD, and begins or ends with a "
            "blank)");
}

TEST_F(PasswordFile, ThatOthersCanReadIsRefusedWithTheCommandThatHelps) {
  for (const auto open : {perms::others_read, perms::group_write, perms::others_write}) {
    const auto password = read("s3cret", perms::owner_read | perms::owner_write | open);
    ASSERT_FALSE(password);
    EXPECT_EQ(password.error().code, ErrorCode::kRefused);
    EXPECT_THAT(password.error().text, AllOf(HasSubstr("run chmod 600 " + path_), Not(HasSubstr("s3cret"))));
  }
}

TEST_F(PasswordFile, OfRootMayBeReadByItsGroupAsCredentialsOfSystemdAre) {
  const bool accepted = bool(read("s3cret", perms::owner_read | perms::group_read));
  EXPECT_EQ(accepted, ::geteuid() == 0) << "of another user the group may not";
}

TEST_F(PasswordFile, OfAnotherUserIsRefusedAlsoForRoot) {
  constexpr uid_t kNobody = 65534;
  ASSERT_TRUE(read("s3cret"));
  if (::chown(path_.c_str(), kNobody, kNobody) != 0) GTEST_SKIP() << "only root can give a file away";
  EXPECT_EQ(read_password_file(files_, path_).error().code, ErrorCode::kRefused);
}

TEST_F(PasswordFile, GoesBeforeTheEnvironment) {
  EXPECT_FALSE(find_password(files_, "", kVariable)->has_value());
  ::setenv(kVariable, "from outside", 1);
  EXPECT_EQ((*find_password(files_, "", kVariable))->text(), "from outside");
  ASSERT_TRUE(read("from the file"));
  EXPECT_EQ((*find_password(files_, path_, kVariable))->text(), "from the file");
  EXPECT_FALSE(find_password(files_, folder_ / "none", kVariable)) << "a file that is named must be there";
  ::setenv(kVariable, "two\nlines", 1);
  EXPECT_THAT(find_password(files_, "", kVariable).error().text, HasSubstr(kVariable));
}

}  // namespace
}  // namespace rubicon::networks::knx::secure
