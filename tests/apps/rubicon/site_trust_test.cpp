#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <sys/stat.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

#include "apps/rubicon/live_island.h"
#include "support/host_group.h"
#include "support/mosquitto.h"
#include "support/process.h"
#include "support/terminal.h"

namespace rubicon::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using support::Process;
using support::Terminal;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

std::string mode_of(const std::string& path) {
  struct stat about {};
  if (::stat(path.c_str(), &about) != 0) return "absent";
  return fmt::format("{:o}", about.st_mode & 07777U);
}

std::string text_in(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

/// Whether a program says so on standard error within a minute.
bool says(Process& program, const std::string& text) {
  for (int i = 0; i < 6000 && program.errors().find(text) == std::string::npos; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return program.errors().find(text) != std::string::npos;
}

/// A host with the authority of a realm of brokers.
class SiteCommands : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
  }
  std::string realm() const { return folder_.file("realm"); }
  static Outcome in(const std::string& realm, std::vector<std::string> words, const std::string& input = {}) {
    words.insert(words.begin(), "trust");
    words.insert(words.end(), {"--realm", realm});
    return rubicon(std::move(words), input);
  }
  Outcome site(std::vector<std::string> words) const { return in(realm(), std::move(words)); }
  void init() const {
    const auto made = site({"init", "--broker", "broker.test"});
    ASSERT_EQ(made.code, 0) << made.errors;
  }
  /// Bundle and phrase of a new member, both files.
  std::pair<std::string, std::string> added(const std::string& name, std::vector<std::string> more = {}) const {
    const auto file = folder_.file(name + ".trust"), phrase = folder_.file(name + ".phrase");
    std::vector<std::string> words{"add", name, "--out", file, "--phrase-file", phrase};
    words.insert(words.end(), more.begin(), more.end());
    const auto outcome = site(words);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return {file, phrase};
  }

  PrivateNetwork alone_;
  Folder folder_;
};

TEST_F(SiteCommands, AMemberIsCarriedToAnotherHostAndToldWhatToConfigure) {
  init();
  const auto [file, phrase] = added("hall", {"--island", "6541"});
  EXPECT_EQ(mode_of(file), "600");
  const auto there = folder_.file("there");
  const auto joined = in(there, {"join", file, "--yes", "--phrase-file", phrase});
  EXPECT_EQ(joined.code, 0) << joined.errors;
  EXPECT_THAT(joined.output,
              AllOf(HasSubstr("member       hall, island 6541, until "),
                    HasSubstr("\n  tuples:\n    mqtt: {broker: {host: broker.test, port: 8883, tls: {ca: " + there +
                              "/ca.pem, certificate: " + there + "/members/hall/certificate.pem, key: " + there +
                              "/members/hall/key.pem}}}\n")));
  EXPECT_EQ(mode_of(there + "/members/hall/key.pem"), "600");
  const auto fingerprint = [](const std::string& text) {
    return text.substr(text.find("fingerprint"), 13 + 16 * 5 - 1);
  };
  EXPECT_EQ(fingerprint(joined.output), fingerprint(site({"show"}).output));
  EXPECT_THAT(in(there, {"join", file, "--phrase-file", phrase}).errors, HasSubstr("expected --yes"));
}

TEST_F(SiteCommands, TheRealmIsShownWithoutSecrets) {
  init();
  const auto phrase = text_in(added("hall", {"--island", "7", "--role", "ops"}).second);
  added("desk");
  ASSERT_EQ(site({"revoke", "desk"}).code, 0);
  const auto shown = site({"list"});
  EXPECT_THAT(shown.output, AllOf(ContainsRegex("hall +ops +7 +20.* elsewhere +good"), ContainsRegex("desk .*revoked"),
                                  HasSubstr("with the authority: members are added here")));
  const auto line = lines_of(site({"show", "--json"})).at(0);
  EXPECT_EQ(line["members"][0]["islands"], json({7}));
  EXPECT_EQ(line["revoked"], json({"desk"}));
  EXPECT_EQ(line["hosts"], json({"broker.test"}));
  EXPECT_THAT(shown.output + line.dump(), AllOf(Not(HasSubstr("PRIVATE")), Not(HasSubstr(phrase.substr(0, 29)))));
}

TEST_F(SiteCommands, ThePhraseIsShownOnATerminalOnlyAndConfirmedThere) {
  init();
  const auto file = folder_.file("desk.trust");
  const auto hidden = site({"add", "desk", "--out", file});
  EXPECT_EQ(hidden.code, 2);
  EXPECT_THAT(hidden.errors, HasSubstr("expected --phrase-file FILE"));
  EXPECT_THAT(site({"show"}).output, Not(HasSubstr("desk"))) << "nothing was made";
  Terminal terminal({kProgram, "trust", "add", "desk", "--out", file, "--realm", realm()}, 30, 120);
  ASSERT_TRUE(terminal.shows("phrase  ")) << terminal.text();
  EXPECT_EQ(terminal.exit_code(), 0);
  Terminal join({kProgram, "trust", "join", file, "--realm", folder_.file("there")}, 30, 120);
  ASSERT_TRUE(join.shows("[y/N]")) << join.text();
  join.type("n\n");
  EXPECT_EQ(join.exit_code(), 1);
  EXPECT_EQ(mode_of(folder_.file("there")), "absent");
}

TEST_F(SiteCommands, AKeyOfAServiceIsForItsUser) {
  const support::HostGroup group("rubicon");
  if (!group.exists()) GTEST_SKIP() << group.reason();
  init();
  ASSERT_EQ(site({"add", "hall", "--here"}).code, 0);
  ASSERT_EQ(site({"add", "people", "--here", "--people"}).code, 0);
  EXPECT_EQ(mode_of(realm() + "/members/hall/key.pem"), "600");
  EXPECT_EQ(mode_of(realm() + "/members/people/key.pem"), "640");
  EXPECT_EQ(site({"add", "desk", "--people"}).code, 2) << "its key goes to another host";
}

TEST_F(SiteCommands, WhatIsWrongIsNamed) {
  EXPECT_THAT(site({"show"}).errors, HasSubstr(realm()));
  init();
  EXPECT_EQ(site({"init"}).code, 1);
  for (const auto& [name, why] : std::vector<std::pair<std::string, std::string>>{
           {"hall/c1", "another level"}, {"peis", "means something else"}, {"-probe-", "members try"}}) {
    const auto refused = rubicon({"trust", "add", "--realm", realm(), "--out", folder_.file("x"), "--", name});
    EXPECT_EQ(refused.code, 2) << name;
    EXPECT_THAT(refused.errors, HasSubstr(why));
  }
  EXPECT_EQ(site({"change", "hall"}).code, 2);
  EXPECT_EQ(site({"revoke", "hall"}).code, 1);
  EXPECT_EQ(site({"renew", "hall", "--out", folder_.file("y")}).code, 1);
  EXPECT_EQ(mode_of(folder_.file("y")), "absent");
  EXPECT_EQ(site({"broker", "mosquitto", "--out", folder_.file("b"), "--broker", "http://x"}).code, 2);
}

TEST_F(SiteCommands, WhoMeansTheCertificatesOfEarlierReleasesIsToldSo) {
  const auto named = rubicon({"trust", "init", "--realm", "Hall"});
  EXPECT_EQ(named.code, 2);
  EXPECT_THAT(named.errors, HasSubstr("`init --name Hall` names a realm"));
  const auto unit = rubicon({"trust", "init", "--for", "home.yaml"});
  EXPECT_EQ(unit.code, 2);
  EXPECT_THAT(unit.errors, HasSubstr("this release does not have: rubicon-trust@.service"));
  EXPECT_THAT(rubicon({"trust", "--help"}).output, Not(HasSubstr("Was for")));
}

TEST_F(SiteCommands, RolesOfTheRealmCountForTheQuestionWhatSomebodyMay) {
  init();
  added("hall", {"--role", "ops"});
  const auto file =
      folder_.write("home.yaml", "island: {id: 1}\nrights:\n  - {who: ops, may: set, keys: [proxy.**]}\n");
  const auto may = [&](const std::string& name) {
    return support::run_to_end({"env", "RUBICON_REALM=" + realm(), kProgram, "trust", "may", name, "set",
                                "proxy.a.b.actuator.lamp-1.command", "--config", file})
        .code;
  };
  EXPECT_EQ(may("hall"), 0);
  EXPECT_EQ(may("desk"), 3);
}

TEST_F(SiteCommands, ABrokerKeepsItsPortAndTakesTheNextFreeOne) {
  init();
  const auto port = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"broker", "mosquitto", "--json"});
    const auto outcome = site(words);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return lines_of(outcome).at(0)["port"].get<int>();
  };
  const auto first = folder_.file("first"), second = folder_.file("second");
  EXPECT_EQ(port({"--out", first}), 8883);
  folder_.write("first/conf.d/log.conf", "log_type information\n");
  if (const auto missing = support::Mosquitto::missing(); !missing.empty()) GTEST_SKIP() << missing;
  Process runs({"mosquitto", "-c", first + "/mosquitto.conf"});
  ASSERT_TRUE(says(runs, "running")) << runs.errors();
  EXPECT_EQ(port({"--out", second}), 8884);
  EXPECT_EQ(port({"--out", first}), 8883) << "its own port is no reason to move";
  EXPECT_EQ(port({"--out", first, "--port", "9000"}), 9000);
  EXPECT_EQ(port({"--out", first}), 9000);
  EXPECT_EQ(port({"--out", folder_.file("third"), "--broker", "broker.test:9001"}), 9001);
  const auto shown = site({"show"}).output;
  EXPECT_THAT(shown, AllOf(HasSubstr(first + ", port 9000"), HasSubstr(second + ", port 8884")));
}

TEST_F(SiteCommands, RevokingSaysHowTheBrokerLearnsItOrTellsIt) {
  if (const auto missing = support::Mosquitto::missing(); !missing.empty()) GTEST_SKIP() << missing;
  init();
  const auto broker = folder_.file("broker");
  ASSERT_EQ(site({"broker", "mosquitto", "--out", broker}).code, 0);
  folder_.write("broker/conf.d/log.conf", "log_type information\n");
  added("hall");
  added("desk");
  const auto told = site({"revoke", "hall"});
  EXPECT_EQ(told.code, 0) << told.errors;
  EXPECT_THAT(told.output, HasSubstr("now: kill -HUP <process of mosquitto -c " + broker + "/mosquitto.conf>"));
  EXPECT_THAT(text_in(broker + "/acl"), HasSubstr("\nuser hall\ntopic deny #\n"));
  Process runs({"mosquitto", "-c", broker + "/mosquitto.conf"});
  ASSERT_TRUE(says(runs, "running")) << runs.errors();
  const auto reloaded = site({"revoke", "desk", "--reload", std::to_string(runs.pid())});
  EXPECT_EQ(reloaded.code, 0) << reloaded.errors;
  EXPECT_TRUE(says(runs, "Reloading config")) << runs.errors();
  EXPECT_EQ(site({"revoke", "desk", "--reload", "999999999"}).code, 1);
  fs::remove_all(broker);
  const auto lost = site({"revoke", "desk"});
  EXPECT_EQ(lost.code, 1);
  EXPECT_THAT(lost.errors, AllOf(HasSubstr("the files of the broker were not written"), HasSubstr(broker)));
}

}  // namespace
}  // namespace rubicon::cli
