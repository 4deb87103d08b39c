#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "support/folder.h"
#include "support/process.h"
#include "support/programs.h"
#include "support/trust_realm.h"

namespace rubicon::daemon {

using namespace support;

namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// What the units ask before they hand out the key of an island.
class TrustKey : public testing::Test {
 protected:
  TrustKey() {
    const TrustRealm realm(folder_ / "trust", {OwnerId{1}});
    std::ofstream(folder_ / "home.yaml") << "island: {id: 1, name: home}\ntuples: {trust: ./trust}\nnetworks: {}\n";
  }
  Outcome ask() const { return run_to_end({kDaemon, "trust-key", folder_ / "home.yaml"}); }

  const Folder folder_;
  const fs::path key_ = fs::path(folder_ / "trust") / "members/island-1/key.pem";
};

TEST_F(TrustKey, IsNamed) {
  const auto named = ask();
  EXPECT_EQ(named.code, 0) << named.errors;
  EXPECT_EQ(named.output, key_.string() + "\n");
}

TEST_F(TrustKey, IsNotHandedOutIfOthersMayReadIt) {
  ASSERT_EQ(::chmod(key_.c_str(), 0644), 0);
  const auto refused = ask();
  EXPECT_NE(refused.code, 0);
  EXPECT_EQ(refused.output, "");
  EXPECT_THAT(refused.errors, HasSubstr(key_.string() + ": others may use this key: expected the mode 0600"));
}

TEST_F(TrustKey, IsNotHandedOutIfItIsALink) {
  fs::rename(key_, folder_ / "key.pem");
  fs::create_symlink(folder_ / "key.pem", key_);
  const auto refused = ask();
  EXPECT_NE(refused.code, 0);
  EXPECT_THAT(refused.errors, HasSubstr("symbolic link"));
}

/// Who runs the island has it, and that is not who writes its configuration.
TEST_F(TrustKey, IsNotNeededToCheckAConfiguration) {
  const std::vector<std::string> nobody{"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", kDaemon};
  const auto as_nobody = [&](std::vector<std::string> words) {
    words.insert(words.begin(), nobody.begin(), nobody.end());
    return run_to_end(words);
  };
  if (as_nobody({"--version"}).code != 0) GTEST_SKIP() << "needs root, setpriv, and programs that nobody may run";
  fs::permissions(folder_.path(), fs::perms(0755));
  const std::vector<std::string> check{"check", folder_ / "home.yaml"};
  const auto checked = as_nobody(check);
  EXPECT_EQ(checked.code, 0) << checked.errors;
  EXPECT_THAT(checked.errors,
              testing::AllOf(HasSubstr("warning: "), HasSubstr(key_.string() + ": this user may not read it")));
  const auto certificate = key_.parent_path() / "certificate.pem";
  std::ofstream(certificate) << "damaged";
  const auto damaged = as_nobody(check);
  EXPECT_EQ(damaged.code, 2);
  EXPECT_THAT(damaged.errors, HasSubstr(certificate.string()));
}

}  // namespace
}  // namespace rubicon::daemon
