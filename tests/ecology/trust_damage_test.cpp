#include <gmock/gmock.h>
#include <sys/stat.h>

#include <csignal>

#include "ecology/trust_lan.h"
#include "support/host_group.h"

namespace rubicon::ecology {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::vector<std::string> kPapers{"identity-ca.pem",
                                       "permissions-ca.pem",
                                       "governance.p7s",
                                       "revoked.p7s",
                                       "members/island-1/certificate.pem",
                                       "members/island-1/permissions.p7s",
                                       "members/island-1/key.pem"};

/// A folder of certificates with changes by hand.
class DamagedTrust : public TrustOnALan {
 protected:
  static std::string in_folder(const std::string& name) { return "trust/" + name; }
  /// One bit of one byte, which is `part` of the way through the file.
  void flip(const std::string& name, double part) const {
    auto text = text_in(in_folder(name));
    auto at = static_cast<std::size_t>(part * static_cast<double>(text.size()));
    while (at > 0 && text[at] == '\n') --at;
    text[at] = static_cast<char>(text[at] ^ 1);
    write(in_folder(name), text);
  }
  void expect_no_start(const std::string& name, const std::string& reason) const {
    const auto ended = run_island();
    EXPECT_EQ(ended.code, 1) << name << ": " << ended.errors;
    EXPECT_THAT(ended.errors,
                AllOf(HasSubstr(file(in_folder(name)) + ": "), HasSubstr(reason), Not(HasSubstr("is up"))))
        << name;
  }
};

/// Or the byte means nothing, such as one of the text in front of a signed document.
TEST_F(DamagedTrust, OneChangedByteOfAPaperIsNoStartThatNamesTheFile) {
  make_realm();
  for (const auto& name : kPapers) {
    const auto good = text_in(in_folder(name));
    int refused = 0;
    for (const double part : {0.1, 0.3, 0.5, 0.7, 0.9}) {
      flip(name, part);
      const auto ended = run_island();
      write(in_folder(name), good);
      if (ended.code == 0) continue;
      ++refused;
      EXPECT_EQ(ended.code, 1) << name << part << ended.errors;
      EXPECT_THAT(ended.errors, AllOf(HasSubstr(file(in_folder(name)) + ": "), Not(HasSubstr("is up")))) << part;
      EXPECT_THAT(ended.errors, Not(HasSubstr(good.substr(good.size() / 2, 20)))) << "the content is shown";
    }
    EXPECT_GE(refused, 3) << name;
  }
  EXPECT_EQ(run_island().code, 0) << "all is as it was";
}

TEST_F(DamagedTrust, AMissingPaperIsNoStartThatNamesTheFile) {
  make_realm();
  for (const auto& name : kPapers) {
    fs::rename(file(in_folder(name)), file("away"));
    const auto ended = run_island();
    EXPECT_EQ(ended.code, 1) << name << ": " << ended.errors;
    // Without the certificate there is no such member, and without the authority no realm.
    const auto named = name.ends_with("certificate.pem") ? "island 1" : name == kPapers[0] ? "no realm" : name;
    EXPECT_THAT(ended.errors, AllOf(HasSubstr(named), HasSubstr(file("trust")), Not(HasSubstr("is up")))) << name;
    fs::rename(file("away"), file(in_folder(name)));
  }
}

TEST_F(DamagedTrust, AnIslandDoesNotReadWhatOthersOfTheFolderNeed) {
  add_desk("admin");
  for (const auto* name : {"ca/identity.key", "ca/permissions.key", "ca/members", "ca/blocks",
                           "members/local/certificate.pem", "members/local/permissions.p7s", "members/local/key.pem"})
    flip(name, 0.5);
  start_island();
  const auto commanded = person({"set", kLampCommand, "on"});
  EXPECT_EQ(commanded.code, 0) << commanded.errors << island_->errors();
  const auto tool = local({"get", kLampValue});
  EXPECT_NE(tool.code, 0);
  EXPECT_THAT(tool.errors, HasSubstr(file("trust/members/local/")));
  const auto added = authority({"add", "robot", "--here"});
  EXPECT_NE(added.code, 0);
  EXPECT_THAT(added.errors, HasSubstr(file("trust/ca/")));
}

TEST_F(DamagedTrust, PermissionsOfAnotherMemberAreNoStart) {
  make_realm();
  write("trust/members/island-1/permissions.p7s", text_in("trust/members/local/permissions.p7s"));
  expect_no_start("members/island-1/permissions.p7s", "these are the permissions of CN=local");
}

TEST_F(DamagedTrust, EditedGovernanceIsNoStart) {
  make_realm();
  auto text = text_in("trust/governance.p7s");
  const std::string rule = "<discovery_protection_kind>ENCRYPT<";
  const auto at = text.find(rule);
  ASSERT_NE(at, text.npos);
  text.replace(at, rule.size(), "<discovery_protection_kind>NONE<");
  write("trust/governance.p7s", text);
  expect_no_start("governance.p7s", "");
}

TEST_F(DamagedTrust, GovernanceOfAnotherRealmIsNoStart) {
  make_realm();
  ASSERT_EQ(on(0, {"trust", "dds", "init", "--trust", file("other")}).code, 0);
  write("trust/governance.p7s", text_in("other/governance.p7s"));
  expect_no_start("governance.p7s", "");
}

TEST_F(DamagedTrust, AMissingFolderIsNoStart) {
  const auto ended = run_island();
  EXPECT_EQ(ended.code, 1) << ended.errors;
  EXPECT_THAT(ended.errors,
              AllOf(HasSubstr(file("trust")), HasSubstr("rubicon trust dds init"), Not(HasSubstr("is up"))));
}

TEST_F(DamagedTrust, AKeyThatOthersMayReadIsNoStart) {
  make_realm();
  const std::string name = "members/island-1/key.pem";
  ASSERT_EQ(::chmod(file(in_folder(name)).c_str(), 0644), 0);
  expect_no_start(name, "others may use this key: expected the mode 0600");
  fs::rename(file(in_folder(name)), file("key.pem"));
  fs::create_symlink(file("key.pem"), file(in_folder(name)));
  expect_no_start(name, "symbolic link");
}

TEST_F(DamagedTrust, TheKeyOfAnIslandIsNotForThePeopleOfTheHost) {
  const support::HostGroup people("rubicon");
  if (!people.exists()) GTEST_SKIP() << people.reason();
  make_realm();
  const std::string name = "members/island-1/key.pem";
  const auto key = file(in_folder(name));
  ASSERT_EQ(::chown(key.c_str(), 0, people.number()), 0);
  ASSERT_EQ(::chmod(key.c_str(), 0640), 0);
  expect_no_start(name, "a group may read this key: expected the mode 0600");
  struct stat about {};
  ASSERT_EQ(::stat(file("trust/members/local/key.pem").c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 07777U, 0640U);
  EXPECT_EQ(about.st_gid, people.number());
}

TEST_F(DamagedTrust, DamageWhileTheIslandRunsIsSaidAndItGoesOn) {
  add_desk("admin");
  start_island();
  for (const auto& name : kPapers) {
    const auto good = text_in(in_folder(name));
    flip(name, 0.3);
    island_->signal(SIGHUP);
    EXPECT_TRUE(says(*island_, "trust: not renewed: " + file(in_folder(name)))) << name << island_->errors();
    write(in_folder(name), good);
  }
  const auto commanded = person({"set", kLampCommand, "on"});
  EXPECT_EQ(commanded.code, 0) << commanded.errors << island_->errors();
}

}  // namespace
}  // namespace rubicon::ecology
