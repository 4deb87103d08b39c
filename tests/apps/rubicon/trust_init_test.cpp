#include <gmock/gmock.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "apps/rubicon/trust_commands.h"
#include "support/host_group.h"

namespace rubicon::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(TrustCommands, InitMakesARealmForThePeopleAndIslandsOfTheHost) {
  const auto made = trust({"init", "--realm", "Hall"});
  EXPECT_EQ(made.code, 0) << made.errors;
  EXPECT_THAT(made.output, ContainsRegex("realm        Hall [0-9a-f]+\nfingerprint  ([0-9A-F]{4} ){15}[0-9A-F]{4}\n"));
  EXPECT_THAT(made.output, HasSubstr("for island 6541"));
  EXPECT_EQ(member("island-6541", trust())["ids"][0], json({6541, 6541}));
  EXPECT_EQ(member("local", trust())["roles"], json({"admin"}));
  EXPECT_EQ(mode_of(trust() + "/ca"), "700");
  EXPECT_EQ(mode_of(trust() + "/ca/identity.key"), "600");
  EXPECT_EQ(mode_of(trust() + "/members/island-6541/key.pem"), "600");
  EXPECT_EQ(mode_of(trust() + "/members/local/key.pem"), ::getgrnam("rubicon") ? "640" : "600");
  EXPECT_EQ(mode_of(trust() + "/governance.p7s"), "644");
}

TEST_F(TrustCommands, InitAgainChangesNothingButAddsIslandsThatAreNew) {
  init();
  const auto before = text_in(trust() + "/members/island-6541/certificate.pem");
  const auto again = trust({"init"});
  EXPECT_EQ(again.code, 0) << again.errors;
  EXPECT_THAT(again.output, HasSubstr("has this realm already; nothing was changed"));
  folder_.write("lab.yaml", small_island(7, "{engine: dds}"));
  EXPECT_THAT(trust({"init"}).output, HasSubstr("certificates were added for island 7"));
  EXPECT_EQ(member("island-7", trust())["has-key"], true);
  EXPECT_EQ(text_in(trust() + "/members/island-6541/certificate.pem"), before);
}

TEST_F(TrustCommands, InitGoesOnWhenOneMemberCannotBeMade) {
  init();
  ASSERT_EQ(trust({"revoke", "island-6541"}).code, 0);
  folder_.write("lab.yaml", small_island(7, "{engine: dds}"));
  const std::vector<std::string> start{"init", "--for", folder_.file("lab.yaml")};
  const auto again = trust(start);
  EXPECT_EQ(again.code, 0) << "units need it";
  EXPECT_THAT(again.errors, HasSubstr("no certificate for island 6541"));
  const auto by_hand = trust({"init"});
  EXPECT_EQ(by_hand.code, 1);
  EXPECT_EQ(by_hand.errors, again.errors);
  EXPECT_EQ(member("island-7", trust())["has-key"], true);
  // One that is damaged is named, and the islands that have theirs start.
  std::ofstream(trust() + "/members/island-7/certificate.pem") << "damaged";
  const auto damaged = trust(start);
  EXPECT_EQ(damaged.code, 0);
  EXPECT_THAT(damaged.errors, HasSubstr("members/island-7/certificate.pem"));
}

TEST_F(TrustCommands, OneDamagedCertificateStopsNoOtherMember) {
  init();
  added("desk");
  const auto certificate = trust() + "/members/desk/certificate.pem";
  std::ofstream(certificate) << "damaged";
  const auto shown = trust({"show"});
  EXPECT_EQ(shown.code, 0);
  EXPECT_THAT(shown.errors, AllOf(HasSubstr("the certificate of desk cannot be read"), HasSubstr(certificate)));
  EXPECT_THAT(shown.output, AllOf(HasSubstr("local"), HasSubstr("island-6541"), Not(HasSubstr("desk"))));
  const auto listed = lines_of(trust({"show", "--json"})).at(0);
  EXPECT_EQ(listed["members"].size(), 2U);
  EXPECT_EQ(listed["unreadable"][0]["name"], "desk");
  EXPECT_THAT(listed["unreadable"][0]["why"].get<std::string>(), HasSubstr(certificate));
  const auto here = trust({"add", "panel", "--here"});
  EXPECT_EQ(here.code, 0) << here.errors;
  EXPECT_THAT(here.errors, HasSubstr(certificate));
  added("robot");
}

TEST_F(TrustCommands, ADamagedCertificateIsAnErrorWhereItMatters) {
  init();
  added("desk");
  const auto certificate = trust() + "/members/desk/certificate.pem";
  std::ofstream(certificate) << "damaged";
  for (const auto& words : std::vector<std::vector<std::string>>{{"renew"}, {"renew", "desk"}}) {
    const auto renewed = trust(words);
    EXPECT_EQ(renewed.code, 1) << "one of them has no new certificate";
    EXPECT_THAT(renewed.errors, AllOf(HasSubstr("desk cannot be renewed"), HasSubstr(certificate)));
  }
  EXPECT_EQ(trust({"renew", "local"}).code, 0);
  const auto island = trust({"add", "lab", "--island", "7", "--here"});
  EXPECT_NE(island.code, 0);
  EXPECT_THAT(island.errors, AllOf(HasSubstr("it may have the id of island 7"), HasSubstr("revoke desk")));
  EXPECT_EQ(trust({"revoke", "desk"}).code, 0);
  EXPECT_EQ(trust({"renew"}).code, 0);
  EXPECT_EQ(trust({"add", "lab", "--island", "7", "--here"}).code, 0);
}

TEST_F(TrustCommands, InitMakesWhatAnInterruptedOneDidNot) {
  init();
  fs::remove(trust() + "/members/local/certificate.pem");
  fs::remove(trust() + "/members/island-6541/certificate.pem");
  const auto again = trust({"init"});
  EXPECT_EQ(again.code, 0) << again.errors;
  EXPECT_EQ(member("local", trust())["roles"], json({"admin"}));
  EXPECT_EQ(member("island-6541", trust())["has-key"], true);
}

TEST_F(TrustCommands, InitDoesNothingForAnIslandThatNeedsNoRealmOfTheHost) {
  for (const auto* tuples : {"{trust: no}", "{trust: ./own}", "{engine: memory}", "{engine: peis}"}) {
    folder_.write("open.yaml", small_island(7, tuples));
    EXPECT_EQ(trust({"init", "--for", folder_.file("open.yaml")}).code, 0) << tuples;
    EXPECT_EQ(mode_of(trust()), "absent") << tuples;
  }
  folder_.write("both.yaml", small_island(7, "{engine: [dds, peis]}"));
  EXPECT_EQ(trust({"init", "--for", folder_.file("both.yaml")}).code, 0);
  EXPECT_NE(mode_of(trust()), "absent");
}

TEST_F(TrustCommands, ANameThatWasMistypedMakesNoRealm) {
  EXPECT_EQ(trust({"init", "--for", folder_.file("hoem.yaml")}).code, 0);
  EXPECT_EQ(mode_of(trust()), "absent");
}

TEST_F(TrustCommands, TheStartOfAnIslandSaysOnlyWhatChanged) {
  const std::vector<std::string> start{"init", "--for", folder_.file("home.yaml")};
  EXPECT_THAT(trust(start).output, HasSubstr("a new realm"));
  folder_.write("other.yaml", small_island(8, "{trust: no}"));
  const auto again = trust(start);
  EXPECT_EQ(again.output + again.errors, "") << "nothing changed, and island 8 needs no certificate";
  folder_.write("other.yaml", small_island(8, "{engine: dds}"));
  EXPECT_THAT(trust(start).output, HasSubstr("for island 8"));
}

TEST_F(TrustCommands, InitMakesCertificatesForIslandsThatNameThisFolderAndNotForThoseOfAnother) {
  folder_.write("here.yaml", small_island(7, "{trust: ./" + fs::path(trust()).filename().string() + "}"));
  folder_.write("elsewhere.yaml", small_island(8, "{trust: ./elsewhere}"));
  folder_.write("open.yaml", small_island(9, "{trust: no}"));
  init();
  EXPECT_EQ(member("island-7", trust())["has-key"], true);
  EXPECT_TRUE(member("island-8", trust()).is_null());
  EXPECT_TRUE(member("island-9", trust()).is_null());
}

TEST_F(TrustCommands, TheFirstStartOfAnIslandThatNamesThisFolderMakesTheRealm) {
  folder_.write("home.yaml", small_island(6541, "{trust: " + trust() + "}"));
  const auto made = trust({"init", "--for", folder_.file("home.yaml")});
  EXPECT_EQ(made.code, 0) << made.errors;
  EXPECT_EQ(member("island-6541", trust())["has-key"], true);
}

TEST_F(TrustCommands, AnIslandWhoseFileLiesElsewhereGetsItsCertificateBeforeItStarts) {
  fs::create_directory(folder_.file("opt"));
  const std::vector<std::string> start{"init", "--for",
                                       folder_.write("opt/lab.yaml", small_island(7, "{engine: dds}"))};
  EXPECT_THAT(trust(start).output, HasSubstr("for island 6541, 7"));
  EXPECT_EQ(trust(start).output, "");
  folder_.write("opt/lab.yaml", small_island(8, "{engine: dds}"));
  EXPECT_THAT(trust(start).output, HasSubstr("for island 8"));
  EXPECT_EQ(member("island-8", trust())["has-key"], true);
  folder_.write("opt/lab.yaml", small_island(9, "{trust: ./own}"));
  EXPECT_EQ(trust(start).code, 0);
  EXPECT_TRUE(member("island-9", trust()).is_null());
}

TEST_F(TrustCommands, InitByHandGivesTheKeyOfLocalToAGroupThatCameLater) {
  if (::getgrnam("rubicon") != nullptr) GTEST_SKIP() << "this host has the group";
  init();
  const auto key = trust() + "/members/local/key.pem";
  ASSERT_EQ(mode_of(key), "600");
  const auto text = text_in(key);
  const support::HostGroup group("rubicon");
  if (!group.exists()) GTEST_SKIP() << group.reason();
  EXPECT_EQ(trust({"init", "--for", folder_.file("home.yaml")}).code, 0);
  EXPECT_EQ(mode_of(key), "600") << "a unit gives nothing away";
  EXPECT_THAT(trust({"init"}).output, HasSubstr("the key of local is for the group rubicon now"));
  EXPECT_EQ(mode_of(key), "640");
  EXPECT_EQ(text_in(key), text);
  EXPECT_THAT(trust({"init"}).output, HasSubstr("nothing was changed"));
}

/// The authority is there, but hidden: that is no reason to believe that there is none.
TEST_F(TrustCommands, WhoMayNotSeeTheAuthorityIsToldSo) {
  const auto as_nobody = [&](std::vector<std::string> words) {
    const std::vector<std::string> nobody{"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", kProgram};
    words.insert(words.begin(), nobody.begin(), nobody.end());
    return support::run_to_end(words);
  };
  if (as_nobody({"--version"}).code != 0) GTEST_SKIP() << "needs root, setpriv, and programs that nobody may run";
  init();
  for (const auto& words : std::vector<std::vector<std::string>>{{"init"}, {"add", "panel", "--here"}}) {
    auto all = words;
    all.insert(all.begin(), {"trust", "dds"});
    all.insert(all.end(), {"--trust", trust()});
    const auto refused = as_nobody(all);
    EXPECT_EQ(refused.code, 1) << words[0];
    EXPECT_THAT(refused.errors, AllOf(HasSubstr("ca/identity.key: cannot see whether it is there: Permission denied"),
                                      Not(HasSubstr("is not here"))));
  }
}

TEST_F(TrustCommands, InitNamesAFolderThatOthersMayChange) {
  init();
  ASSERT_EQ(::chmod((trust() + "/members").c_str(), 0777), 0);
  const auto again = trust({"init"});
  EXPECT_THAT(again.errors, HasSubstr("others may change this folder"));
}

/// A new realm shuts out all members of the former one.
TEST_F(TrustCommands, AnIslandStartsWithTheRealmThatItHadOrNotAtAll) {
  const std::vector<std::string> start{"init", "--for", folder_.file("home.yaml")};
  const auto first = trust(start);
  EXPECT_EQ(first.code, 0) << first.errors;
  EXPECT_THAT(first.output, HasSubstr(trust() + ": a new realm, with certificates"));
  fs::rename(trust(), folder_.file("lost"));
  const auto refused = trust(start);
  EXPECT_EQ(refused.code, 1) << refused.output;
  EXPECT_THAT(refused.errors, AllOf(HasSubstr(trust() + ": has no realm"), HasSubstr("started with Rubicon "),
                                    HasSubstr(trust() + ".realm"), HasSubstr("from your copy")));
  EXPECT_EQ(mode_of(trust()), "absent");
  fs::rename(folder_.file("lost"), trust());
  EXPECT_EQ(trust(start).code, 0);
  // Who asks for a new realm gets one, and islands start with that.
  fs::remove_all(trust());
  EXPECT_EQ(trust({"init", "--realm", "Second"}).code, 0);
  EXPECT_EQ(trust(start).code, 0);
  fs::remove_all(trust());
  EXPECT_THAT(trust(start).errors, HasSubstr("started with Second "));
}

TEST_F(TrustCommands, AnIslandOfAHostThatJoinedMakesNoRealmOfItsOwnEither) {
  init();
  const auto [file, phrase] = added("lab");
  fs::create_directory(folder_.file("other"));
  folder_.write("other/lab.yaml", small_island(7, "{engine: dds}"));
  const auto other = folder_.file("other/trust");
  ASSERT_EQ(with(other, {"join", file, "--yes"}, phrase + "\n").code, 0);
  const std::vector<std::string> start{"init", "--for", folder_.file("other/lab.yaml")};
  EXPECT_EQ(with(other, start).code, 0);
  fs::remove_all(other);
  EXPECT_THAT(with(other + "/", start).errors, HasSubstr("join that realm again"));
  EXPECT_EQ(with(other, start).code, 1);
  EXPECT_EQ(mode_of(other), "absent");
}

TEST_F(TrustCommands, InitNamesAConfigurationThatItCannotRead) {
  folder_.write("broken.yaml", "island: [\n");
  const auto made = trust({"init"});
  EXPECT_EQ(made.code, 1);
  EXPECT_THAT(made.errors, HasSubstr("no certificate for " + folder_.file("broken.yaml")));
  EXPECT_EQ(trust({"init", "--for", folder_.file("home.yaml")}).code, 0);
}

}  // namespace
}  // namespace rubicon::cli
