#include <fcntl.h>
#include <gmock/gmock.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "apps/rubicon/live_island.h"
#include "apps/rubicon/trust/phrase.h"
#include "support/own_memory.h"
#include "support/process.h"
#include "support/terminal.h"

namespace rubicon::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using support::Terminal;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::string text_in(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

std::string mode_of(const std::string& path) {
  struct stat about {};
  if (::stat(path.c_str(), &about) != 0) return "absent";
  std::ostringstream text;
  text << std::oct << (about.st_mode & 07777U);
  return text.str();
}

/// A host with the authority and one island, and the folder of a person on another one.
class TrustCommands : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    folder_.write("home.yaml", small_island(6541));
  }
  std::string trust() const { return folder_.file("trust"); }
  Outcome trust(std::vector<std::string> words, const std::string& input = {}) const {
    return with(trust(), std::move(words), input);
  }
  static Outcome with(const std::string& folder, std::vector<std::string> words, const std::string& input = {}) {
    words.insert(words.begin(), "trust");
    words.insert(words.end(), {"--trust", folder});
    return rubicon(std::move(words), input);
  }
  void init() const { ASSERT_EQ(trust({"init"}).code, 0); }
  /// A bundle of a new member, and its phrase.
  std::pair<std::string, std::string> added(const std::string& name) const {
    const auto file = folder_.file(name + ".trust"), phrase = folder_.file(name + ".phrase");
    const auto outcome = trust({"add", name, "--out", file, "--phrase-file", phrase});
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    auto text = text_in(phrase);
    EXPECT_EQ(outcome.output.find(text.substr(0, text.find('\n'))), std::string::npos) << "the phrase is shown";
    return {file, text.substr(0, text.find('\n'))};
  }
  json member(const std::string& name, const std::string& folder) const {
    const auto shown = lines_of(with(folder, {"show", "--json"}));
    if (shown.empty()) return {};
    for (const auto& one : shown.front()["members"]) {
      if (one["name"] == name) return one;
    }
    return {};
  }

  PrivateNetwork alone_;
  Folder folder_;
};

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
  folder_.write("lab.yaml", small_island(7));
  EXPECT_THAT(trust({"init"}).output, HasSubstr("certificates were added for island 7"));
  EXPECT_EQ(member("island-7", trust())["has-key"], true);
  EXPECT_EQ(text_in(trust() + "/members/island-6541/certificate.pem"), before);
}

TEST_F(TrustCommands, InitGoesOnWhenOneMemberCannotBeMade) {
  init();
  ASSERT_EQ(trust({"revoke", "island-6541"}).code, 0);
  folder_.write("lab.yaml", small_island(7));
  const auto again = trust({"init"});
  EXPECT_EQ(again.code, 0) << "units need it";
  EXPECT_THAT(again.errors, HasSubstr("no certificate for island 6541"));
  EXPECT_EQ(member("island-7", trust())["has-key"], true);
  // One that is damaged is named, and the islands that have theirs start.
  std::ofstream(trust() + "/members/island-7/certificate.pem") << "damaged";
  const auto damaged = trust({"init"});
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

TEST_F(TrustCommands, WhoHoldsTheFolderIsNamedByItsLock) {
  init();
  const auto lock = trust() + "/lock";
  EXPECT_EQ(mode_of(lock), "600");
  const auto held = ::open(lock.c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_EQ(::flock(held, LOCK_EX | LOCK_NB), 0);
  folder_.write("lab.yaml", small_island(7));
  const auto busy = trust({"init"});
  EXPECT_THAT(busy.errors, AllOf(HasSubstr("no certificate for island 7"), HasSubstr(lock)));
  ::close(held);
  EXPECT_EQ(trust({"init"}).errors, "");
}

TEST_F(TrustCommands, AProgramThatReadsKeysWritesNoCoreFile) {
  init();
  const auto [file, phrase] = added("desk");
  support::Process joins({kProgram, "trust", "join", file, "--yes", "--trust", folder_.file("other")});
  ASSERT_TRUE(joins.line_with("member"));  // it waits for the phrase
  EXPECT_THAT(text_in("/proc/" + std::to_string(joins.pid()) + "/limits"), ContainsRegex("Max core file size +0 +0 "));
  joins.write(phrase + "\n");
  EXPECT_EQ(joins.exit_code(), 0) << joins.errors();
}

TEST_F(TrustCommands, PhrasesThatAreReadDoNotStayInMemory) {
  std::string phrase = "abcd-efgh-ijkm-npqr-stuv-wxyz";
  const auto masked = support::masked_end(phrase);
  const auto file = folder_.write("phrase", "");
  const auto descriptor = ::open(file.c_str(), O_WRONLY | O_CLOEXEC);
  ASSERT_EQ(::write(descriptor, phrase.data(), phrase.size()), static_cast<ssize_t>(phrase.size()));
  ::close(descriptor);
  rubicon::trust::SecretText(std::move(phrase));
  ASSERT_EQ(support::count_in_heap(masked), 0U);
  {
    const auto read = trust::read_phrase({file}, "phrase: ");
    ASSERT_TRUE(read);
    EXPECT_GE(support::count_in_heap(masked), 1U);
  }
  EXPECT_EQ(support::count_in_heap(masked), 0U);
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
  folder_.write("other.yaml", small_island(8));
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
  folder_.write("other/lab.yaml", small_island(7));
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
  EXPECT_EQ(made.code, 0);
  EXPECT_THAT(made.errors, HasSubstr("no certificate for " + folder_.file("broken.yaml")));
}

TEST_F(TrustCommands, AMemberIsCarriedToAnotherHost) {
  init();
  const auto [file, phrase] = added("desk");
  EXPECT_EQ(mode_of(file), "600");
  EXPECT_THAT(text_in(file), Not(HasSubstr("BEGIN PRIVATE KEY")));
  const auto other = folder_.file("other");
  const auto joined = with(other, {"join", file, "--yes"}, phrase + "\n");
  EXPECT_EQ(joined.code, 0) << joined.errors;
  const auto shown = trust({"show"});
  const auto fingerprint = shown.output.substr(shown.output.find("fingerprint"), 13 + 16 * 5 - 1);
  EXPECT_THAT(joined.output, HasSubstr(fingerprint));
  EXPECT_EQ(member("desk", other)["has-key"], true);
  EXPECT_EQ(mode_of(other + "/members/desk/key.pem"), "600");
  EXPECT_THAT(joined.output + joined.errors, Not(HasSubstr(phrase)));
}

TEST_F(TrustCommands, AWrongPhraseOpensNothing) {
  init();
  const auto file = added("desk").first;
  const auto other = folder_.file("other");
  const auto refused = with(other, {"join", file, "--yes"}, "AAAA-AAAA-AAAA-AAAA\n");
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("pass phrase"));
  EXPECT_EQ(mode_of(other + "/members/desk/key.pem"), "absent");
  EXPECT_EQ(with(other, {"join", file, "--yes"}, "\n").code, 2);
}

TEST_F(TrustCommands, JoiningNeedsAConfirmedFingerprint) {
  init();
  const auto [file, phrase] = added("desk");
  const auto other = folder_.file("other");
  EXPECT_THAT(with(other, {"join", file}, phrase + "\n").errors, HasSubstr("expected --yes"));
  Terminal terminal({kProgram, "trust", "join", file, "--trust", other}, 30, 120);
  ASSERT_TRUE(terminal.shows("[y/N]")) << terminal.text();
  EXPECT_THAT(terminal.text(), HasSubstr("fingerprint  "));
  terminal.type("y\n");
  ASSERT_TRUE(terminal.shows("phrase:")) << terminal.text();
  terminal.type(phrase + "\n");
  ASSERT_TRUE(terminal.shows("joined ")) << terminal.text();
  EXPECT_EQ(terminal.exit_code(), 0);
  EXPECT_THAT(terminal.bytes(), Not(HasSubstr(phrase))) << "it is not shown while it is typed";
  EXPECT_TRUE(terminal.is_as_before());
}

TEST_F(TrustCommands, ThePhraseIsShownOnATerminalOnly) {
  init();
  const auto hidden = trust({"add", "desk", "--out", folder_.file("desk.trust")});
  EXPECT_EQ(hidden.code, 2);
  EXPECT_THAT(hidden.errors, HasSubstr("expected --phrase-file FILE"));
  EXPECT_TRUE(member("desk", trust()).is_null()) << "nothing was made";
  Terminal terminal({kProgram, "trust", "add", "desk", "--out", folder_.file("desk.trust"), "--trust", trust()}, 30,
                    120);
  ASSERT_TRUE(terminal.shows("phrase  ")) << terminal.text();
  EXPECT_EQ(terminal.exit_code(), 0);
}

TEST_F(TrustCommands, WhatCannotBeHandedOutIsNotMade) {
  init();
  const auto file = folder_.file("desk.trust"), phrase = folder_.file("desk.phrase");
  const auto nowhere = folder_.file("none/desk.trust");
  EXPECT_NE(trust({"add", "desk", "--out", nowhere, "--phrase-file", phrase}).code, 0);
  EXPECT_NE(trust({"add", "desk", "--out", file, "--phrase-file", folder_.file("none/phrase")}).code, 0);
  EXPECT_NE(trust({"add", "desk", "--out", file, "--phrase-file", file}).code, 0);
  const auto json = trust({"add", "desk", "--out", file, "--json"});
  EXPECT_EQ(json.code, 2);
  EXPECT_THAT(json.errors, HasSubstr("expected --phrase-file FILE"));
  EXPECT_TRUE(member("desk", trust()).is_null()) << "nothing was made";
  EXPECT_EQ(mode_of(file), "absent");
  EXPECT_EQ(mode_of(phrase), "absent");
  added("desk");
}

TEST_F(TrustCommands, ARequestKeepsTheKeyOnItsHost) {
  init();
  const auto other = folder_.file("robot");
  const auto asked = with(other, {"request", "robot"});
  ASSERT_EQ(asked.code, 0) << asked.errors;
  const auto answered = trust({"sign", "-", "--role", "fetch"}, asked.output);
  ASSERT_EQ(answered.code, 0) << answered.errors;
  EXPECT_THAT(answered.output, Not(HasSubstr("PRIVATE KEY")));
  const auto joined = with(other, {"join", "-", "--yes"}, answered.output);
  EXPECT_EQ(joined.code, 0) << joined.errors;
  EXPECT_EQ(member("robot", other)["roles"], json({"fetch"}));
}

TEST_F(TrustCommands, ARevokedMemberStaysSoAndItsNameIsTaken) {
  init();
  added("desk");
  const auto revoked = trust({"revoke", "desk"});
  EXPECT_EQ(revoked.code, 0) << revoked.errors;
  EXPECT_THAT(trust({"show"}).output, ContainsRegex("desk .*revoked"));
  EXPECT_EQ(trust({"renew", "desk"}).code, 1);
  EXPECT_EQ(trust({"add", "desk", "--out", folder_.file("2"), "--phrase-file", folder_.file("3")}).code, 1);
  EXPECT_EQ(trust({"revoke", "nobody-of-that-name"}).code, 1);
}

TEST_F(TrustCommands, RenewingGivesNewCertificatesToThoseOfThisHost) {
  init();
  const auto before = member("island-6541", trust());
  const auto renewed = trust({"renew", "island-6541", "--days", "800"});
  EXPECT_EQ(renewed.code, 0) << renewed.errors;
  const auto after = member("island-6541", trust());
  EXPECT_NE(after["serial"], before["serial"]);
  EXPECT_EQ(after["ids"], before["ids"]);
  EXPECT_EQ(after["days-left"], 799);
}

TEST_F(TrustCommands, AnExportedMemberJoinsAgain) {
  init();
  const auto file = folder_.file("local.trust"), phrase = folder_.file("local.phrase");
  ASSERT_EQ(trust({"export", "local", "--out", file, "--phrase-file", phrase}).code, 0);
  const auto joined = with(folder_.file("other"), {"join", file, "--yes", "--phrase-file", phrase});
  EXPECT_EQ(joined.code, 0) << joined.errors;
}

TEST_F(TrustCommands, AnOlderFileIsTakenOnlyByRequest) {
  init();
  const auto [file, phrase] = added("desk");
  const auto other = folder_.file("other");
  ASSERT_EQ(with(other, {"join", file, "--yes"}, phrase + "\n").code, 0);
  const auto first = member("desk", other)["serial"];
  // Of a member of another host it writes a file here.
  fs::create_directory(folder_.file("renewed"));
  const auto renewed = support::run_to_end(
      {"env", "-C", folder_.file("renewed"), kProgram, "trust", "renew", "desk", "--days", "900", "--trust", trust()});
  ASSERT_EQ(renewed.code, 0) << renewed.errors;
  ASSERT_EQ(with(other, {"join", folder_.file("renewed/desk.trust"), "--yes"}).code, 0);
  const auto second = member("desk", other)["serial"];
  ASSERT_NE(second, first);
  const auto refused = with(other, {"join", file, "--yes"}, phrase + "\n");
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.errors, AllOf(HasSubstr("expected a newer one"), HasSubstr("rubicon trust join --older")));
  EXPECT_EQ(member("desk", other)["serial"], second);
  const auto taken = with(other, {"join", file, "--yes", "--older"}, phrase + "\n");
  EXPECT_EQ(taken.code, 0) << taken.errors;
  EXPECT_EQ(member("desk", other)["serial"], first);
}

TEST_F(TrustCommands, NothingSecretIsShown) {
  init();
  const auto phrase = added("desk").second;
  for (const auto& words : {std::vector<std::string>{"show"}, {"show", "--json"}, {"init", "--json"}}) {
    const auto shown = trust(words);
    EXPECT_THAT(shown.output + shown.errors, AllOf(Not(HasSubstr("PRIVATE")), Not(HasSubstr(phrase))));
  }
}

TEST_F(TrustCommands, WhatIsWrongIsNamed) {
  EXPECT_THAT(trust({"show"}).errors, HasSubstr(trust()));
  EXPECT_EQ(trust({"show"}).code, 1);
  init();
  EXPECT_EQ(trust({"add", "two words"}).code, 2);
  EXPECT_EQ(trust({"add", "everybody"}).code, 2);
  EXPECT_EQ(trust({"add", "desk", "--days", "0"}).code, 2);
  EXPECT_THAT(trust({"join", folder_.file("home.yaml"), "--yes"}).errors, HasSubstr("home.yaml"));
  EXPECT_THAT(trust({"renew", "desk"}).errors, HasSubstr("no member desk"));
}

}  // namespace
}  // namespace rubicon::cli
