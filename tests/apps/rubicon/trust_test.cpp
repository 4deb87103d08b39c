#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <fstream>

#include "apps/rubicon/trust/phrase.h"
#include "apps/rubicon/trust_commands.h"
#include "support/host_group.h"
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
using ::testing::Not;

TEST_F(TrustCommands, WhoHoldsTheFolderIsNamedByItsLock) {
  init();
  const auto lock = trust() + "/lock";
  EXPECT_EQ(mode_of(lock), "600");
  const auto held = ::open(lock.c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_EQ(::flock(held, LOCK_EX | LOCK_NB), 0);
  folder_.write("lab.yaml", small_island(7, "{engine: dds}"));
  const auto busy = trust({"init"});
  EXPECT_THAT(busy.errors, AllOf(HasSubstr("no certificate for island 7"), HasSubstr(lock)));
  ::close(held);
  EXPECT_EQ(trust({"init"}).errors, "");
}

TEST_F(TrustCommands, AProgramThatReadsKeysWritesNoCoreFile) {
  init();
  const auto [file, phrase] = added("desk");
  support::Process joins({kProgram, "trust", "dds", "join", file, "--yes", "--trust", folder_.file("other")});
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

TEST_F(TrustCommands, AKeyIsForThePeopleOfTheHostOnlyWithThatOption) {
  const support::HostGroup group("rubicon");
  if (!group.exists()) GTEST_SKIP() << group.reason();
  init();
  EXPECT_EQ(trust({"add", "panel", "--here"}).code, 0);
  EXPECT_EQ(trust({"add", "people", "--here", "--people"}).code, 0);
  EXPECT_EQ(mode_of(trust() + "/members/panel/key.pem"), "600");
  EXPECT_EQ(mode_of(trust() + "/members/people/key.pem"), "640");
  EXPECT_EQ(trust({"add", "desk", "--people"}).code, 2) << "its key goes to another host";
  EXPECT_EQ(trust({"add", "lab", "--island", "7", "--here", "--people"}).code, 2);
  const auto [file, phrase] = added("desk");
  const auto other = folder_.file("other");
  ASSERT_EQ(with(other, {"join", file, "--yes"}, phrase + "\n").code, 0);
  EXPECT_EQ(mode_of(other + "/members/desk/key.pem"), "600");
  ASSERT_EQ(with(other, {"join", file, "--yes", "--people"}, phrase + "\n").code, 0);
  EXPECT_EQ(mode_of(other + "/members/desk/key.pem"), "640");
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
  Terminal terminal({kProgram, "trust", "dds", "join", file, "--trust", other}, 30, 120);
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
  Terminal terminal({kProgram, "trust", "dds", "add", "desk", "--out", folder_.file("desk.trust"), "--trust", trust()},
                    30, 120);
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
  EXPECT_THAT(asked.errors, ContainsRegex("member       robot\nkey fingerprint ([0-9A-F]{4} ){15}[0-9A-F]{4}\n"));
  const auto key = asked.errors.substr(asked.errors.find("key fingerprint"));
  EXPECT_THAT(answered.errors, AllOf(HasSubstr("member       robot, roles fetch, ids "), HasSubstr(key)));
  const auto joined = with(other, {"join", "-", "--yes"}, answered.output);
  EXPECT_EQ(joined.code, 0) << joined.errors;
  EXPECT_EQ(member("robot", other)["roles"], json({"fetch"}));
}

TEST_F(TrustCommands, WhoIsSignedIntoAFileIsShown) {
  init();
  const auto asked = with(folder_.file("robot"), {"request", "robot"});
  const auto key = asked.errors.substr(asked.errors.find("key fingerprint"));
  const auto answered = trust({"sign", "-", "--out", folder_.file("robot.trust")}, asked.output);
  EXPECT_EQ(answered.errors, "");
  EXPECT_THAT(answered.output, AllOf(HasSubstr("member       robot, roles none, ids "), HasSubstr(key)));
  const auto other = with(folder_.file("crane"), {"request", "crane"});
  const auto line = trust({"sign", "-", "--out", folder_.file("crane.trust"), "--json"}, other.output);
  EXPECT_THAT(other.errors, HasSubstr(lines_of(line).at(0)["key-fingerprint"].get<std::string>()));
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

TEST_F(TrustCommands, AMemberOfThisHostIsRevokedOnlyIfItIsMeant) {
  init();
  added("desk");
  const std::vector<std::string> words{kProgram, "trust", "dds", "revoke", "local", "--trust", trust()};
  Terminal asked(words, 30, 120);
  ASSERT_TRUE(asked.shows("revoke it for good? [y/N]")) << asked.text();
  EXPECT_THAT(asked.text(), HasSubstr("local's key is on this host"));
  asked.type("no\n");
  EXPECT_EQ(asked.exit_code(), 1);
  EXPECT_THAT(trust({"show"}).output, Not(HasSubstr("revoked")));
  Terminal meant(words, 30, 120);
  ASSERT_TRUE(meant.shows("[y/N]")) << meant.text();
  meant.type(" Yes \n");
  ASSERT_TRUE(meant.shows("local is revoked; ")) << meant.text();
  EXPECT_EQ(meant.exit_code(), 0);
  auto sure = words;
  sure[4] = "island-6541";
  sure.emplace_back("--yes");
  Terminal skipped(sure, 30, 120);
  EXPECT_TRUE(skipped.shows("island-6541 is revoked; ")) << skipped.text();
  Terminal elsewhere({kProgram, "trust", "dds", "revoke", "desk", "--trust", trust()}, 30, 120);
  EXPECT_TRUE(elsewhere.shows("desk is revoked; ")) << elsewhere.text();
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

TEST_F(TrustCommands, AMemberWithoutAKeyHereIsExportedWithoutAPhrase) {
  init();
  added("desk");
  const auto file = folder_.file("again.trust");
  const auto exported = trust({"export", "desk", "--out", file});
  EXPECT_EQ(exported.code, 0) << exported.errors;
  EXPECT_THAT(exported.output, Not(HasSubstr("phrase")));
  EXPECT_THAT(text_in(file), Not(HasSubstr("PRIVATE KEY")));
  EXPECT_EQ(trust({"export", "local", "--out", folder_.file("local.trust")}).code, 2) << "its phrase needs a terminal";
  EXPECT_EQ(trust({"export", "nobody", "--out", folder_.file("nobody.trust")}).code, 1);
  EXPECT_EQ(mode_of(folder_.file("nobody.trust")), "absent");
}

TEST_F(TrustCommands, AnOlderFileIsTakenOnlyByRequest) {
  init();
  const auto [file, phrase] = added("desk");
  const auto other = folder_.file("other");
  ASSERT_EQ(with(other, {"join", file, "--yes"}, phrase + "\n").code, 0);
  const auto first = member("desk", other)["serial"];
  // Of a member of another host it writes a file here.
  fs::create_directory(folder_.file("renewed"));
  const auto renewed = support::run_to_end({"env", "-C", folder_.file("renewed"), kProgram, "trust", "dds", "renew",
                                            "desk", "--days", "900", "--trust", trust()});
  ASSERT_EQ(renewed.code, 0) << renewed.errors;
  ASSERT_EQ(with(other, {"join", folder_.file("renewed/desk.trust"), "--yes"}).code, 0);
  const auto second = member("desk", other)["serial"];
  ASSERT_NE(second, first);
  const auto refused = with(other, {"join", file, "--yes"}, phrase + "\n");
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.errors, AllOf(HasSubstr("expected a newer one"), HasSubstr("rubicon trust dds join --older")));
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
