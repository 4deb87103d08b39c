#include "console/shell.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "island/virtual_island.h"

namespace rubicon::console {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const std::string kShellLamp = "proxy.dummy-1.living.actuator.lamp-1";
const std::string kShellLight = "proxy.dummy-1.living.sensor.light-1.value";

class ShellTest : public testing::Test {
 protected:
  ShellTest() { world_.time.run_for(1s); }

  /// What a command answers, once all that is due happened.
  std::vector<json> lines(std::string_view command) {
    answers_.clear();
    shell_.line(command);
    world_.time.run_ready();
    return answers_;
  }
  json answer(std::string_view command) {
    const auto all = lines(command);
    EXPECT_THAT(all, SizeIs(1)) << command;
    return all.empty() ? json() : all.back();
  }
  json tuple(const std::string& key) { return answer("get " + key)["tuple"]; }
  std::string code_of(std::string_view command) {
    const auto line = answer(command);
    EXPECT_EQ(line["ok"], false) << command;
    return line["error"]["code"];
  }

  island::VirtualIsland world_{
      "{living: {name: Living room, sensors: {light-1: {wave: constant, value: 50}}, actuators: {lamp-1: "
      "{behaviour: obey, delay: 200ms}, boiler-1: {behaviour: ignore}}}}"};
  std::vector<json> answers_, events_;
  int quits_ = 0;
  Shell shell_{world_.time,
               *world_.space,
               OwnerId(6541),
               "proxy",
               [this](const std::string& line) { answers_.push_back(json::parse(line)); },
               [this](const std::string& line) { events_.push_back(json::parse(line)); },
               [this] { ++quits_; }};
};

TEST_F(ShellTest, SetAnswersWhatTheOwnerSaysAndTheStatusTellsTheRest) {
  const auto applied = answer("set " + kShellLamp + ".command on");
  EXPECT_EQ(applied["ok"], true);
  EXPECT_EQ(applied["key"], kShellLamp + ".command");
  EXPECT_EQ(applied["verdict"], "applied");
  world_.time.run_for(1s);
  EXPECT_EQ(tuple(kShellLamp + ".value")["value"], "on");
  const auto status = json::parse(tuple(kShellLamp + ".status")["value"].get<std::string>());
  EXPECT_EQ(status["command"]["state"], "confirmed");
  EXPECT_EQ(status["command"]["request"], applied["request"]);
  EXPECT_EQ(status["command"]["creator"], 65536);
}

TEST_F(ShellTest, ARefusedSetHasTheReasonOfTheOwner) {
  const auto refused = answer("set 6541:" + kShellLamp + ".command purple");
  EXPECT_EQ(refused["ok"], false);
  EXPECT_EQ(refused["verdict"], "refused");
  EXPECT_EQ(refused["error"]["code"], "invalid");
  EXPECT_THAT(refused["error"]["text"].get<std::string>(), HasSubstr("purple"));
  EXPECT_EQ(code_of("set " + kShellLamp + ".value on"), "refused");
  EXPECT_EQ(code_of("set proxy.nothing 1"), "not-found");
  EXPECT_EQ(answer("set 7:a.b 1")["verdict"], "no-such-owner");
}

TEST_F(ShellTest, TheRestOfTheLineIsTheValue) {
  EXPECT_THAT(answer("set " + kShellLamp + ".command  on")["error"]["text"].get<std::string>(), HasSubstr("' on'"));
  EXPECT_EQ(answer("set " + kShellLamp + ".command")["ok"], false);
  EXPECT_EQ(answer("set " + kShellLamp + ".command on\r")["ok"], true);
}

TEST_F(ShellTest, AnswersInTheOrderOfTheCommands) {
  shell_.line("set " + kShellLamp + ".command on");
  shell_.line("get proxy.island");
  shell_.line("nonsense");
  shell_.line("set " + kShellLamp + ".command purple");
  EXPECT_THAT(answers_, IsEmpty()) << "the first answer is not there yet";
  world_.time.run_ready();
  ASSERT_THAT(answers_, SizeIs(4));
  EXPECT_EQ(answers_[0]["verdict"], "applied");
  EXPECT_EQ(answers_[1]["tuple"]["key"], "proxy.island");
  EXPECT_EQ(answers_[2]["error"]["code"], "invalid");
  EXPECT_EQ(answers_[3]["verdict"], "refused");
}

TEST_F(ShellTest, GetShowsATupleOrSaysThatThereIsNone) {
  const auto island = answer("get proxy.island");
  EXPECT_EQ(island["ok"], true);
  EXPECT_EQ(island["tuple"]["owner"], 6541);
  EXPECT_EQ(island["tuple"]["media"], "application/json");
  EXPECT_EQ(code_of("get proxy.nothing"), "not-found");
  EXPECT_EQ(code_of("get proxy.*"), "invalid");
  EXPECT_EQ(code_of("get"), "invalid");
  EXPECT_EQ(code_of("get 0:a"), "invalid");
}

TEST_F(ShellTest, ListsOneLineATupleAndTheirCount) {
  const auto all = lines("ls proxy.*.*.actuator.*.value");
  ASSERT_THAT(all, SizeIs(3));
  EXPECT_EQ(all[0]["value"], "");
  EXPECT_EQ(all[2], (json{{"ok", true}, {"count", 2}}));
  EXPECT_EQ(answer("ls nothing.**")["count"], 0);
  EXPECT_EQ(code_of("ls a..b"), "invalid");
}

TEST_F(ShellTest, DevicesAreListedWithNameAndStatus) {
  const auto all = lines("devices");
  ASSERT_THAT(all, SizeIs(2));
  EXPECT_EQ(all[0]["device"], "proxy.dummy-1.living");
  EXPECT_EQ(all[0]["name"], "Living room");
  EXPECT_EQ(all[0]["status"], "reachable");
  EXPECT_GT(all[0]["since"].get<double>(), 1.7e9);
  EXPECT_EQ(all[1], (json{{"ok", true}, {"count", 1}}));
}

TEST_F(ShellTest, ASubscriptionCreatesDemandAndItsEventsComeUntilItEnds) {
  world_.time.run_for(5s);
  EXPECT_EQ(tuple(kShellLight)["value"], "") << "nobody asked the sensor yet";
  EXPECT_EQ(answer("subscribe " + kShellLight + " min=1s")["ok"], true);
  world_.time.run_for(10s);
  EXPECT_GE(events_.size(), 10U);
  EXPECT_EQ(events_.back()["value"], "50");
  EXPECT_EQ(events_.back()["event"], "set");
  EXPECT_EQ(answer("unsubscribe " + kShellLight)["ok"], true);
  events_.clear();
  world_.time.run_for(10s);
  EXPECT_THAT(events_, IsEmpty());
  EXPECT_EQ(code_of("unsubscribe " + kShellLight), "not-found");
}

TEST_F(ShellTest, ALineOfJsonIsARequestAndTheAnswerCarriesItsId) {
  const json passive{{"do", "subscribe"}, {"pattern", "6541:" + kShellLight}};
  EXPECT_EQ(answer(passive.dump()), (json{{"ok", true}, {"subscription", 1}}));
  world_.time.run_for(5s);
  EXPECT_EQ(tuple(kShellLight)["value"], "") << "passive, as on the WebSocket";
  auto active = passive;
  active.update({{"id", 7}, {"active", true}, {"min", "1s"}});
  EXPECT_EQ(answer(active.dump()), (json{{"id", 7}, {"ok", true}, {"subscription", 2}}));
  world_.time.run_for(5s);
  EXPECT_EQ(tuple(kShellLight)["value"], "50");
  EXPECT_EQ(events_.back()["mimetype"], "text/plain") << "events are lines of --watch";
  for (const int number : {1, 2})
    EXPECT_EQ(answer(json{{"do", "unsubscribe"}, {"subscription", number}}.dump()), (json{{"ok", true}}));
  events_.clear();
  world_.time.run_for(5s);
  EXPECT_THAT(events_, IsEmpty());
  EXPECT_EQ(answer(R"({"id":9,"do":"get"})")["id"], 9) << "an error, too";
  EXPECT_EQ(code_of(R"({"do":)"), "invalid");
  EXPECT_EQ(code_of(R"({"id":"x","do":"get","key":"6541:proxy.island"})"), "invalid");
  EXPECT_EQ(answer(R"(  {"do":"get","key":"6541:proxy.island"})")["tuple"]["key"], "proxy.island");
}

TEST_F(ShellTest, APassiveSubscriptionCreatesNoDemand) {
  EXPECT_EQ(answer("subscribe " + kShellLight + " passive max=5s deadband=0.5")["ok"], true);
  world_.time.run_for(10s);
  EXPECT_EQ(tuple(kShellLight)["value"], "");
}

TEST_F(ShellTest, RefusesFlowsThatMakeNoSense) {
  for (const auto* flow : {"min=", "min=5m", "max=-1s", "max=1ms", "deadband=x", "deadband=-1", "deadband=nan",
                           "min=5s,max=6s", "often", "=", "min", "pattern=a"}) {
    EXPECT_EQ(code_of("subscribe a.b " + std::string(flow)), "invalid") << flow;
  }
}

TEST_F(ShellTest, SubscriptionsAreBounded) {
  for (int i = 0; i < 1000; ++i) shell_.line("subscribe a.k" + std::to_string(i) + " passive");
  world_.time.run_ready();
  EXPECT_EQ(code_of("subscribe a.one-more"), "busy");
  EXPECT_EQ(answer("subscribe a.k7 passive")["ok"], true) << "replaces its own";
  EXPECT_EQ(answer("unsubscribe a.k7")["ok"], true);
  EXPECT_EQ(answer("subscribe a.one-more")["ok"], true);
}

TEST_F(ShellTest, StatsCountTuplesAndTheCountersOfNetworks) {
  const auto stats = answer("stats");
  EXPECT_EQ(stats["ok"], true);
  EXPECT_GT(stats["tuples"].get<int>(), 10);
  EXPECT_EQ(stats["networks"]["dummy-1"]["devices"], "1");
}

TEST_F(ShellTest, PostsBytesIntoTheGateway) {
  EXPECT_EQ(code_of("post"), "invalid");
  EXPECT_EQ(code_of("post zz"), "invalid");
  EXPECT_EQ(code_of("post ff"), "invalid") << "no message: the gateway says so";
}

TEST_F(ShellTest, HelpNamesEveryCommand) {
  const auto help = answer("help")["commands"];
  EXPECT_THAT(help, SizeIs(17));
}

TEST_F(ShellTest, BadLinesAreAnsweredAndNothingElse) {
  EXPECT_THAT(lines(""), IsEmpty());
  EXPECT_THAT(lines("  \t "), IsEmpty());
  EXPECT_THAT(lines("# a comment"), IsEmpty());
  for (const std::string_view line : {"Set a b", "\xff\xfe", "g\xc3\xbct", "quit;", "\x1b[A", "ls\tx\ty z"}) {
    EXPECT_EQ(lines(line).size(), 1U) << line;
  }
  EXPECT_EQ(code_of(std::string("get a\0b", 7)), "invalid");
  EXPECT_EQ(code_of("get " + std::string(10'000, 'k')), "not-found");
  EXPECT_EQ(code_of("set " + std::string(10'000, 'k') + " 1"), "not-found");
  EXPECT_EQ(answer("set " + kShellLamp + ".command " + std::string(60'000, '\xff'))["ok"], false);
  EXPECT_EQ(code_of("get a/b"), "not-found");
  EXPECT_EQ(answer("get proxy.island")["ok"], true);
}

TEST_F(ShellTest, ALineThatWasTooLongIsAnsweredInItsTurn) {
  shell_.line("set " + kShellLamp + ".command on");
  shell_.line_too_long();
  world_.time.run_ready();
  ASSERT_THAT(answers_, SizeIs(2));
  EXPECT_EQ(answers_[0]["ok"], true);
  EXPECT_EQ(answers_[1]["error"]["code"], "out-of-range");
}

TEST_F(ShellTest, QuitWaitsForWhatIsUnderWayAndHearsNothingAfterIt) {
  shell_.line("set " + kShellLamp + ".command on");
  shell_.line("quit");
  shell_.line("get proxy.island");
  EXPECT_EQ(quits_, 0);
  world_.time.run_ready();
  EXPECT_EQ(quits_, 1);
  ASSERT_THAT(answers_, SizeIs(2));
  EXPECT_EQ(answers_[1], (json{{"ok", true}}));
}

TEST_F(ShellTest, TheEndOfTheInputWaitsForAnswersUnderWay) {
  bool idle = false;
  shell_.line("set " + kShellLamp + ".command on");
  shell_.when_idle([&idle] { idle = true; });
  EXPECT_FALSE(idle);
  world_.time.run_ready();
  EXPECT_TRUE(idle);
  EXPECT_THAT(answers_, SizeIs(1));
}

TEST_F(ShellTest, AnAnswerThatNeverComesEndsAsExpired) {
  world_.ecology.cut(OwnerId(65536), OwnerId(6541));
  shell_.line("set " + kShellLamp + ".command on");
  world_.time.run_for(6s);
  ASSERT_THAT(answers_, SizeIs(1));
  EXPECT_EQ(answers_[0]["ok"], false);
}

}  // namespace
}  // namespace rubicon::console
