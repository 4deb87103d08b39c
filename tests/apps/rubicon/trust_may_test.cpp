#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/rubicon/live_island.h"

namespace rubicon::cli {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kLock = "proxy.dummy-1.den.actuator.lock-1.command";
constexpr const char* kLamp = "proxy.dummy-1.den.actuator.lamp-1.command";

/// A host with the rules of one island, which does not run.
class TrustMay : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    configuration_ =
        folder_.write("home.yaml", small_island(6541, "{engine: dds}") +
                                       "rights:\n"
                                       "  - {who: admin, may: all}\n"
                                       "  - {who: robot, may: set, keys: [\"proxy.*.*.actuator.*.command\"], "
                                       "not: [\"proxy.*.*.actuator.lock-*.command\"]}\n"
                                       "  - {who: robot, may: send, keys: [dummy-1.den, \"island:7\"]}\n"
                                       "  - {who: panel, may: approve, keys: [\"proxy.inbox.**\"]}\n"
                                       "  - {who: lan, may: read, keys: [\"proxy.**\"]}\n");
  }
  std::string realm() const { return folder_.file("realm"); }
  Outcome may(std::vector<std::string> words, const std::vector<std::string>& more = {}) const {
    words.insert(words.begin(), {"trust", "may"});
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.begin(), {"env", "RUBICON_REALM=" + realm(), kProgram});
    words.insert(words.end(), {"--config", configuration_});
    return support::run_to_end(std::move(words));
  }

  PrivateNetwork alone_;
  Folder folder_;
  std::string configuration_;
};

TEST_F(TrustMay, AnswersFromTheFileOfAnIslandWithTheRuleThatDecides) {
  const auto yes = may({"robot", "set", kLamp});
  EXPECT_EQ(yes.code, 0) << yes.errors;
  EXPECT_EQ(yes.output, "yes: rule 2 (" + configuration_ + ":7:5) allows it\n");
  const auto no = may({"robot", "set", kLock});
  EXPECT_EQ(no.code, 3) << no.errors;
  EXPECT_EQ(no.output, "no: rule 2 (" + configuration_ + ":7:5) denies it\n");
  const auto none = may({"robot", "read", kLamp});
  EXPECT_EQ(none.code, 3) << none.errors;
  EXPECT_EQ(none.output, "no: no rule allows it\n");
}

TEST_F(TrustMay, AnswersInJson) {
  const auto no = may({"robot", "set", kLock, "--json"});
  EXPECT_EQ(no.code, 3) << no.errors;
  EXPECT_EQ(lines_of(no).at(0), (json{{"name", "robot"},
                                      {"right", "set"},
                                      {"key", kLock},
                                      {"may", false},
                                      {"rule", 2},
                                      {"why", "rule 2 (" + configuration_ + ":7:5) denies it"}}));
  const auto none = lines_of(may({"robot", "read", kLamp, "--json"})).at(0);
  EXPECT_EQ(none["may"], false);
  EXPECT_FALSE(none.contains("rule")) << none;
}

TEST_F(TrustMay, AnswersForTheInboxAndForMessages) {
  EXPECT_EQ(may({"panel", "approve", "proxy.inbox.hall.command"}).code, 0);
  EXPECT_EQ(may({"panel", "set", "proxy.inbox.hall.command"}).code, 0) << "a set of the inbox approves";
  EXPECT_EQ(may({"robot", "send", "dummy-1.den"}).code, 0);
  EXPECT_EQ(may({"robot", "send", "island:7"}).code, 0);
  EXPECT_EQ(may({"robot", "send", "island:8"}).code, 3);
  EXPECT_EQ(may({"robot", "send", "own"}).code, 3);
}

TEST_F(TrustMay, TakesTheRolesOfTheRealmOrOfTheCommandLine) {
  const auto unknown = may({"desk", "read", kLamp});
  EXPECT_EQ(unknown.code, 3);
  EXPECT_THAT(unknown.errors, HasSubstr("desk: not a member of the realm in " + realm()));
  EXPECT_EQ(may({"desk", "read", kLamp, "--role", "admin"}).code, 0);
  EXPECT_THAT(may({"user:ann", "read", kLamp}).errors, IsEmpty()) << "of the host";
  ASSERT_EQ(rubicon({"trust", "init", "--broker", "b.test", "--realm", realm()}).code, 0);
  ASSERT_EQ(rubicon({"trust", "add", "desk", "--role", "admin", "--realm", realm(), "--out", folder_.file("b"),
                     "--phrase-file", folder_.file("p")})
                .code,
            0);
  const auto desk = may({"desk", "read", kLamp});
  EXPECT_EQ(desk.code, 0) << "the realm says that it is an admin";
  EXPECT_THAT(desk.errors, IsEmpty());
}

TEST_F(TrustMay, WhoIsMetByDdsHasOneName) {
  const auto lan = may({"lan", "read", kLamp});
  EXPECT_EQ(lan.code, 0) << lan.output;
  EXPECT_THAT(lan.errors, IsEmpty());
  EXPECT_EQ(may({"lan", "set", kLamp}).code, 3);
}

TEST_F(TrustMay, WhatIsNoQuestionIsAnError) {
  const auto right = may({"robot", "open", kLamp});
  EXPECT_EQ(right.code, 2);
  EXPECT_THAT(right.errors, HasSubstr("'open' is not a right, expected read, demand, set, approve or send"));
  for (const auto* key : {"6541:proxy.networks", "proxy..networks", "proxy.**", "island:7"}) {
    const auto wrong = may({"robot", "read", key});
    EXPECT_EQ(wrong.code, 2) << key << wrong.output;
    EXPECT_THAT(wrong.errors, HasSubstr("key '" + std::string(key) + "'"));
  }
  const auto island = may({"robot", "send", "island:home"});
  EXPECT_EQ(island.code, 2);
  EXPECT_THAT(island.errors, HasSubstr("'island:home'"));
  const auto absent = rubicon({"trust", "may", "robot", "read", kLamp, "--config", folder_.file("absent.yaml")});
  EXPECT_EQ(absent.code, 2);
  EXPECT_THAT(absent.errors, HasSubstr("absent.yaml"));
  folder_.write("home.yaml", small_island(6541, "{engine: dds}") + "rights:\n  - {who: robot, may: open}\n");
  const auto broken = may({"robot", "read", kLamp});
  EXPECT_EQ(broken.code, 2);
  EXPECT_THAT(broken.errors, HasSubstr(configuration_ + ":6:")) << "the place of the rule";
}

}  // namespace
}  // namespace rubicon::cli
