#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "apps/rubicon/live_island.h"

namespace rubicon::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Two islands of one host whose networks have the same ids.
class Choice : public testing::Test {
 protected:
  struct World {
    PrivateNetwork alone;
    Folder folder;
    std::unique_ptr<Process> home, shed;
  };
  static std::string text(const std::string& island, const std::string& device) {
    return "island: " + island +
           "\ndiscovery: {rules: [{network: dummy-new, new-devices: ask}]}\nnetworks:\n"
           "  dummy-1:\n    type: dummy\n    simulate:\n      hall:\n"
           "        sensors: {temperature-1: {wave: constant, value: 21.5}, light-1: {}}\n"
           "        actuators: {lamp-1: {}, lamp-2: {}}\n      attic: {sensors: {motion-1: {}}}\n"
           "  dummy-new: {type: dummy, simulate: {" +
           device + ": {}}}\n";
  }
  static void SetUpTestSuite() {
    world = new World;
    if (!world->alone.entered()) return;
    world->home = started(world->folder.write("home.yaml", text("{id: 6541, name: home}", "guest")));
    world->shed = started(world->folder.write("shed.yaml", text("{id: 7, name: shed}", "tramp")));
  }
  static void TearDownTestSuite() { delete world; }
  void SetUp() override {
    if (!world->alone.entered()) GTEST_SKIP() << world->alone.reason();
    ASSERT_TRUE(world->home && world->shed);
  }
  inline static World* world = nullptr;
};

std::set<int> islands_in(const std::vector<nlohmann::json>& lines) {
  std::set<int> islands;
  for (const auto& line : lines) islands.insert(line.value("island", line.value("owner", 0)));
  return islands;
}

TEST_F(Choice, AnIslandIsChosenByItsIdOrItsName) {
  using Words = std::vector<std::string>;
  for (const auto& command : {Words{"devices"}, Words{"tree"}, Words{"networks"}, Words{"settings"}, Words{"inbox"},
                              Words{"log", "--level", "debug"}}) {
    for (const auto* island : {"6541", "home"}) {
      auto words = command;
      words.insert(words.end(), {"--json", "--island", island});
      const auto outcome = rubicon(words);
      EXPECT_EQ(outcome.code, 0) << command[0] << ' ' << outcome.errors;
      const auto found = islands_in(lines_of(outcome));
      if (command[0] != "log") {
        EXPECT_EQ(found, std::set<int>{6541}) << command[0] << ' ' << island;
      }
    }
  }
}

TEST_F(Choice, AnIslandThatIsNotThereIsSaidWithTheNearestName) {
  const auto wrong = rubicon({"networks", "--island", "shet"});
  EXPECT_EQ(wrong.code, 8);
  EXPECT_THAT(wrong.errors, HasSubstr("no island 'shet'"));
  EXPECT_THAT(wrong.errors, HasSubstr("did you mean 'shed'?"));
  for (const auto* never : {"0", "70000", ""}) {
    const auto outcome = rubicon({"networks", "--island", never});
    EXPECT_EQ(outcome.code, 2) << never;
    EXPECT_THAT(outcome.errors, HasSubstr("expected the id (1 to 65532) or the name of an island"));
  }
}

TEST_F(Choice, TheNameOfAnIslandStandsInFrontOfATuple) {
  const auto one = rubicon({"get", "--json", "home:hall.temperature-1"});
  EXPECT_EQ(lines_of(one).at(0)["owner"], 6541) << one.errors;
  EXPECT_EQ(islands_in(lines_of(rubicon({"ls", "--json", "shed:hall.*"}))), std::set<int>{7});
  EXPECT_EQ(islands_in(lines_of(rubicon({"watch", "--json", "--count", "1", "shed:hall.temperature-1"}))),
            std::set<int>{7});
  EXPECT_THAT(rubicon({"describe", "shed:hall"}).output, HasSubstr("7:proxy.dummy-1.hall"));
  EXPECT_EQ(rubicon({"set", "home:hall.lamp-1", "on"}).code, 0);
}

TEST_F(Choice, ANetworkIsNamedAsTheListWritesIt) {
  for (const auto* network : {"7:dummy-1", "shed:dummy-1"}) {
    EXPECT_EQ(islands_in(lines_of(rubicon({"networks", "--json", network}))), std::set<int>{7}) << network;
    EXPECT_EQ(islands_in(lines_of(rubicon({"devices", "--json", "--network", network}))), std::set<int>{7}) << network;
    const auto reopened = rubicon({"networks", network, "reopen"});
    EXPECT_EQ(reopened.code, 3);
    EXPECT_THAT(reopened.errors, HasSubstr("the line is up"));
  }
  EXPECT_THAT(rubicon({"replay", "shed:dummy-1"}).errors, HasSubstr("no recording in network 'dummy-1'"));
  EXPECT_THAT(rubicon({"wsn", "monitor", "--network", "home:wsn-9"}).errors, HasSubstr("no network wsn-9"));
  const auto both = rubicon({"networks", "7:dummy-1", "--island", "home"});
  EXPECT_EQ(both.code, 2);
  EXPECT_THAT(both.errors, HasSubstr("'7:dummy-1' is a network of island 7, but --island is 'home'"));
}

TEST_F(Choice, APatternOfTheInboxMeansTheIslandWithDevicesThatFit) {
  const auto approved = rubicon({"inbox", "approve", "dummy-new.tr*"});
  EXPECT_EQ(approved.code, 0) << approved.errors;
  EXPECT_EQ(islands_in(lines_of(rubicon({"devices", "--json", "--name", "tramp"}))), std::set<int>{7});
  const auto none = rubicon({"inbox", "approve", "dummy-new.zz*"});
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.errors, HasSubstr("choose one with --island"));
}

TEST_F(Choice, APointThatCanOnlyBeReadNamesThoseThatCanBeSet) {
  const auto sensor = rubicon({"set", "7:hall.light-1", "5"});
  EXPECT_EQ(sensor.code, 8);
  EXPECT_THAT(sensor.errors, HasSubstr("7:proxy.dummy-1.hall.sensor.light-1 can only be read; of hall can be set: "
                                       "'hall.lamp-1', 'hall.lamp-2'"));
  EXPECT_THAT(sensor.errors, Not(HasSubstr("'hall.light-1'")));
  EXPECT_THAT(rubicon({"set", "7:dummy-1.attic.motion-1", "on"}).errors, HasSubstr("7:proxy.dummy-1.attic.sensor"));
  const auto near = rubicon({"set", "hall.lihgt-1", "5"});
  EXPECT_THAT(near.errors, Not(HasSubstr("light-1"))) << "it could not be set";
  EXPECT_THAT(rubicon({"set", "hall.lamp-3", "on"}).errors, HasSubstr("did you mean 'hall.lamp-1'"));
}

TEST_F(Choice, NothingIsOfferedForAWordThatIsRight) {
  const auto nobody = rubicon({"devices", "--type", "temperature", "--area", "Moon"});
  EXPECT_EQ(nobody.code, 8);
  EXPECT_THAT(nobody.errors, Not(HasSubstr("did you mean")));
  EXPECT_THAT(rubicon({"devices", "--network", "dumy-1"}).errors, HasSubstr("did you mean 'dummy-1'?"));
  EXPECT_THAT(rubicon({"networks", "dumy-1"}).errors, HasSubstr("did you mean 'dummy-1'?"));
}

TEST_F(Choice, JsonHasTheUnit) {
  EXPECT_EQ(lines_of(rubicon({"get", "--json", "7:hall.temperature-1"})).at(0)["unit"], "Cel");
  EXPECT_EQ(lines_of(rubicon({"ls", "--json", "7:hall.temperature-1"})).at(0)["unit"], "Cel");
  EXPECT_EQ(lines_of(rubicon({"watch", "--json", "--count", "1", "7:hall.temperature-1"})).at(0)["unit"], "Cel");
  EXPECT_FALSE(lines_of(rubicon({"get", "--json", "7:proxy.networks"})).at(0).contains("unit"));
}

/// D1.4 lets a component set any part of a tuple of another one.
TEST_F(Choice, SetsMediaTypeUserTimeAndExpiry) {
  Process robot({kProgram, "publish", "robot.goal", "none", "--id", "70001", "--open"});
  ASSERT_EQ(robot.line(), "none") << robot.errors();
  const auto set = rubicon({"set", "70001:robot.goal", "--hex", "00ff41", "--media-type", "application/x-goal",
                            "--user-time", "2026-01-31T12:00:00Z", "--lifetime", "1h"});
  EXPECT_EQ(set.code, 0) << set.errors;
  const auto goal = lines_of(rubicon({"get", "--json", "70001:robot.goal"})).at(0);
  EXPECT_EQ(goal["mimetype"], "application/x-goal");
  EXPECT_EQ(goal["user"], 1769860800);
  EXPECT_NEAR(goal["expire"].get<double>() - goal["write"].get<double>(), 3600, 0.01);
  EXPECT_EQ(rubicon({"set", "70001:robot.goal", "xyz", "--hex"}).code, 2);
  EXPECT_EQ(rubicon({"set", "70001:robot.goal", "a", "--user-time", "noon"}).code, 2);
}

TEST_F(Choice, AMessageIsSetInTheGatewayTuple) {
  const std::string message = "a2617601646b696e64666f7061717565";  // {"v": 1, "kind": "opaque"}
  const auto taken =
      rubicon({"set", "7:GATEWAY", message, "--hex", "--media-type", "application/rubicon+cbor", "--json"});
  EXPECT_EQ(lines_of(taken).at(0)["state"], "applied") << taken.output << taken.errors;
  const auto plain = rubicon({"set", "7:GATEWAY", message, "--hex"});
  EXPECT_EQ(plain.code, 3);
}

}  // namespace
}  // namespace rubicon::cli
