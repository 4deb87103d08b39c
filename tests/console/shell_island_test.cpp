#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "console/shell.h"
#include "island/virtual_island.h"

namespace rubicon::console {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::ElementsAre;
using testing::SizeIs;

/// A shell at an island that asks before it lets a device in.
class ShellOfAnIsland : public testing::Test {
 protected:
  ShellOfAnIsland() { world_.time.run_for(2s); }

  std::vector<json> lines(std::string_view command) {
    answers_.clear();
    shell_.line(command);
    world_.time.run_for(1s);
    return answers_;
  }

  island::VirtualIsland world_{"{hall: {name: Hall, sensors: {light-1: {}}}, attic: {sensors: {light-1: {}}}}",
                               "discovery: {new-devices: ask}\n"};
  std::vector<json> answers_;
  Shell shell_{world_.time,
               *world_.space,
               OwnerId(6541),
               "proxy",
               [this](const std::string& line) { answers_.push_back(json::parse(line)); },
               [](const std::string&) {},
               [] {}};
};

TEST_F(ShellOfAnIsland, GetBringsTheTupleOfAnotherIslandThatNobodySubscribedTo) {
  const auto link = world_.ecology.join(OwnerId(7)).value();
  TupleSpace other(OwnerId(7), world_.time, *link);
  ASSERT_TRUE(other.set("proxy.networks", "[]"));
  EXPECT_FALSE(world_.space->get(OwnerId(7), "proxy.networks"));
  const auto there = lines("get 7:proxy.networks").at(0);
  EXPECT_EQ(there["ok"], true);
  EXPECT_EQ(there["tuple"]["value"], "[]");
  EXPECT_FALSE(world_.space->get(OwnerId(7), "proxy.networks"));  // the copy goes with the question
  EXPECT_EQ(lines("get 7:proxy.nothing").at(0)["error"]["text"], "no tuple 7:proxy.nothing");
  EXPECT_EQ(lines("get 8:proxy.networks").at(0)["error"]["text"], "no component 8 is present");
}

TEST_F(ShellOfAnIsland, DevicesHaveTheNamesThatPeopleGiveThem) {
  lines("approve dummy-1.*");
  const auto* key = "proxy.dummy-1.hall.sensor.light-1.value";
  for (const auto* line : {"get hall.light-1", "get dummy-1.hall.light-1", "get HALL.light",
                           R"({"do":"get","key":"Hall.light"})", R"({"do":"get","key":"6541:Hall.light-1"})"}) {
    const auto answer = lines(line).at(0);
    EXPECT_EQ(answer["tuple"]["key"], key) << line << answer;
  }
  EXPECT_EQ(lines("subscribe hall.light passive").at(0)["ok"], true);
  EXPECT_EQ(lines("unsubscribe hall.light").at(0)["ok"], true);
  EXPECT_EQ(lines("get Hall/lihgt").at(0)["ok"], false);
  EXPECT_EQ(lines("set hall.light 7").at(0)["ok"], false);
}

TEST_F(ShellOfAnIsland, AGetOfAnIslandThatLeavesMeanwhileIsAnswered) {
  auto link = world_.ecology.join(OwnerId(7)).value();
  auto other = std::make_unique<TupleSpace>(OwnerId(7), world_.time, *link);
  world_.time.run_for(1s);
  shell_.line("get 7:proxy.networks");
  shell_.line("help");
  other.reset();
  link.reset();
  world_.time.run_for(5s);
  ASSERT_THAT(answers_, SizeIs(2));
  EXPECT_EQ(answers_[0]["ok"], false);
  EXPECT_TRUE(answers_[1].contains("commands"));
}

TEST_F(ShellOfAnIsland, AnUnknownCommandNamesTheNearest) {
  EXPECT_EQ(lines("devcies").at(0)["error"]["text"], "unknown command 'devcies'; did you mean 'devices'?");
  EXPECT_EQ(lines("frobnicate").at(0)["error"]["text"], "unknown command 'frobnicate'; help lists the commands");
}

TEST_F(ShellOfAnIsland, InboxListsWhoWaits) {
  const auto all = lines("inbox");
  ASSERT_THAT(all, SizeIs(3));
  EXPECT_EQ(all[0]["key"], "dummy-1.attic");
  EXPECT_EQ(all[1]["name"], "Hall");
  EXPECT_EQ(all[1]["why"], "discovery.new-devices is ask");
  EXPECT_EQ(all[2]["count"], 2);
  EXPECT_EQ(all[2]["ignored"], 0);
}

TEST_F(ShellOfAnIsland, ApproveAndIgnoreDecide) {
  EXPECT_EQ(lines("approve dummy-1.hall").back()["ok"], true);
  EXPECT_EQ(lines("ignore dummy-1.attic").back()["ok"], true);
  const auto all = lines("inbox");
  ASSERT_THAT(all, SizeIs(1));
  EXPECT_EQ(all[0]["ignored"], 1);
  const auto devices = lines("devices");
  ASSERT_THAT(devices, SizeIs(2));
  EXPECT_EQ(devices[0]["device"], "proxy.dummy-1.hall");
}

TEST_F(ShellOfAnIsland, APatternDecidesAboutAllThatWait) {
  EXPECT_EQ(lines("approve dummy-1.*").back()["ok"], true);
  EXPECT_EQ(lines("devices").back()["count"], 2);
}

TEST_F(ShellOfAnIsland, WhatCannotBeDecidedIsAnswered) {
  EXPECT_EQ(lines("approve").back()["error"]["code"], "invalid");
  EXPECT_EQ(lines("approve dummy-1.cellar").back()["error"]["code"], "not-found");
  EXPECT_EQ(lines("ignore wsn.*").back()["error"]["code"], "not-found");
}

TEST_F(ShellOfAnIsland, ReloadSaysWhatItChanged) {
  std::vector<bool> calls;
  shell_.on_reload([&](bool try_only) -> Result<std::vector<std::string>> {
    calls.push_back(try_only);
    return std::vector<std::string>{"network x: is added"};
  });
  EXPECT_EQ(lines("reload try").back()["changes"], (std::vector<std::string>{"network x: is added"}));
  EXPECT_EQ(lines("reload").back()["ok"], true);
  EXPECT_EQ(lines("reload now").back()["error"]["code"], "invalid");
  EXPECT_THAT(calls, ElementsAre(true, false));
}

TEST_F(ShellOfAnIsland, ARefusedReloadIsAnErrorWithItsText) {
  EXPECT_EQ(lines("reload").back()["error"]["code"], "unsupported");
  shell_.on_reload([](bool) -> Result<std::vector<std::string>> { return fail(ErrorCode::kInvalid, "home.yaml:3:1"); });
  EXPECT_EQ(lines("reload").back()["error"]["text"], "home.yaml:3:1");
}

TEST_F(ShellOfAnIsland, StatsShowTheNumbersOfTheIsland) {
  const auto island = lines("stats").back()["island"];
  EXPECT_EQ(island["inbox-waiting"], "2");
  EXPECT_EQ(island["gateway-malformed"], "0");
  EXPECT_TRUE(island.contains("tuples-dropped"));
}

}  // namespace
}  // namespace rubicon::console
