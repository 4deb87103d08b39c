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
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const std::string kLamp = "proxy.dummy-1.living.actuator.lamp-1";
const std::string kLight = "proxy.dummy-1.living.sensor.light-1.value";
const std::string kOther = "proxy.dummy-1.kitchen.sensor.light-1.value";

/// A shell at an island with two rooms, and a robot (70000) that lets others write its `log` and its `best`.
class ShellLinks : public testing::Test {
 protected:
  ShellLinks() {
    judges_.push_back(robot_.add_policy(
        {OwnerId(70000), "log"}, [](const tuples::RemoteSet&) { return tuples::SetDecision::applied(); },
        tuples::PolicyScope::kSetsAndAppends));
    judges_.push_back(robot_.add_policy({OwnerId(70000), "best"},
                                        [](const tuples::RemoteSet&) { return tuples::SetDecision::applied(); }));
    world_.time.run_for(1s);
  }

  json answer(std::string_view command) {
    answers_.clear();
    shell_.line(command);
    world_.time.run_ready();
    EXPECT_THAT(answers_, SizeIs(1)) << command;
    return answers_.empty() ? json() : answers_.back();
  }
  json tuple(const std::string& key) { return answer("get " + key)["tuple"]; }
  std::string code_of(std::string_view command) {
    const auto line = answer(command);
    EXPECT_EQ(line["ok"], false) << command;
    return line["error"]["code"];
  }
  std::string text_of(std::string_view command) { return answer(command)["error"]["text"]; }
  std::string value_of(std::string_view key) {
    return std::string(robot_.get(OwnerId(70000), key).value_or(tuples::TupleView{}).value);
  }

  island::VirtualIsland world_{
      "{living: {sensors: {light-1: {wave: constant, value: 50}}, actuators: {lamp-1: {behaviour: obey}}}, "
      "kitchen: {sensors: {light-1: {wave: constant, value: 80}}}}"};
  std::unique_ptr<tuples::Link> link_ = world_.ecology.join(OwnerId(70000)).value();
  TupleSpace robot_{OwnerId(70000), world_.time, *link_};
  std::vector<tuples::Handle> judges_;
  std::vector<json> answers_, events_;
  Shell shell_{world_.time,
               *world_.space,
               OwnerId(6541),
               "proxy",
               [this](const std::string& line) { answers_.push_back(json::parse(line)); },
               [this](const std::string& line) { events_.push_back(json::parse(line)); },
               [] {}};
};

TEST_F(ShellLinks, ALinkIsATupleOfTheShellThatNamesAnother) {
  const auto linked = answer("link best " + kLamp + ".command");
  EXPECT_EQ(linked, (json{{"ok", true}, {"linked", "65536:best"}, {"target", "6541:" + kLamp + ".command"}}));
  const auto link = tuple("65536:best");
  EXPECT_EQ(link["value"], "6541:" + kLamp + ".command");
  EXPECT_EQ(link["media"], "application/rubicon-reference");
  EXPECT_EQ(answer("unlink best")["unlinked"], "65536:best");
  EXPECT_EQ(code_of("get 65536:best"), "not-found");
  EXPECT_EQ(code_of("unlink best"), "not-found");
  EXPECT_EQ(code_of("unlink 6541:proxy.island"), "refused");
}

TEST_F(ShellLinks, AnArrowGetsAndSetsThroughIt) {
  answer("link lamp " + kLamp + ".command");
  answer("link state " + kLamp + ".value");
  const auto applied = answer("set ->65536:lamp on");
  EXPECT_EQ(applied["verdict"], "applied");
  EXPECT_EQ(applied["key"], kLamp + ".command");
  world_.time.run_for(1s);
  const auto state = tuple("->65536:state");
  EXPECT_EQ(state["value"], "on");
  EXPECT_EQ(state["key"], kLamp + ".value");
  EXPECT_THAT(text_of("set ->65536:lamp purple"), HasSubstr("purple"));
}

TEST_F(ShellLinks, AnArrowToWhatLeadsNowhereSaysWhy) {
  EXPECT_EQ(code_of("get ->65536:none"), "not-found");
  EXPECT_EQ(code_of("get ->proxy.island"), "invalid") << "no meta tuple";
  EXPECT_EQ(code_of("set ->65536:none 1"), "not-found");
  EXPECT_EQ(code_of("append ->65536:none 1"), "not-found");
  answer("link gone proxy.nothing");
  EXPECT_EQ(code_of("get ->65536:gone"), "not-found");
  EXPECT_EQ(code_of("get ->"), "invalid");
  EXPECT_EQ(code_of("get ->->a"), "invalid");
  EXPECT_EQ(code_of("get ->a.*"), "invalid");
  EXPECT_EQ(code_of("ls ->a"), "invalid");
}

TEST_F(ShellLinks, CyclesAndImpossibleNamesAreRefused) {
  EXPECT_EQ(answer("link a 65536:b")["ok"], true);
  EXPECT_EQ(code_of("link b 65536:a"), "refused");
  EXPECT_THAT(text_of("link b 65536:a"), HasSubstr("cycle"));
  for (const auto* line : {"link", "link a", "link a.* b", "link a b.**", "link a b@7", "link ->a b"}) {
    EXPECT_EQ(code_of(line), "invalid") << line;
  }
}

TEST_F(ShellLinks, LinksAreBounded) {
  for (int i = 0; i < 1000; ++i) shell_.line("link l" + std::to_string(i) + " proxy.island");
  world_.time.run_ready();
  EXPECT_EQ(code_of("link one-more proxy.island"), "busy");
  EXPECT_EQ(answer("link l7 proxy.networks")["ok"], true) << "an old one may change";
  EXPECT_EQ(answer("unlink l7")["ok"], true);
  EXPECT_EQ(answer("link one-more proxy.island")["ok"], true);
}

/// With the default engine nobody knows the id of the shell before it runs.
TEST_F(ShellLinks, AnArrowWithoutAnOwnerIsTheShellsOwnLinkElseTheIslands) {
  EXPECT_EQ(answer("link best " + kLamp + ".command")["ok"], true);
  EXPECT_EQ(answer("set ->best on")["key"], kLamp + ".command");
  EXPECT_EQ(answer("link best " + kLight)["ok"], true);
  EXPECT_EQ(tuple("->best")["key"], kLight);
  EXPECT_EQ(answer("subscribe ->best min=1s")["ok"], true);
  world_.time.run_for(5s);
  ASSERT_THAT(events_, testing::Not(IsEmpty()));
  EXPECT_EQ(events_[0], (json{{"through", "->best"}, {"target", "6541:" + kLight}, {"event", "target"}}));
  EXPECT_EQ(answer("unsubscribe ->best")["ok"], true);
  EXPECT_THAT(text_of("get ->proxy.island"), HasSubstr("6541:proxy.island"));
}

TEST_F(ShellLinks, ASubscriptionThroughItFollowsAndMovesTheDemand) {
  answer("link best " + kLight);
  EXPECT_EQ(answer("subscribe ->65536:best min=1s")["ok"], true);
  world_.time.run_for(5s);
  ASSERT_THAT(events_, testing::Not(IsEmpty()));
  EXPECT_EQ(events_[0], (json{{"through", "->65536:best"}, {"target", "6541:" + kLight}, {"event", "target"}}));
  EXPECT_EQ(events_.back()["key"], kLight);
  EXPECT_EQ(events_.back()["value"], "50");
  EXPECT_EQ(events_.back()["through"], "->65536:best");
  EXPECT_EQ(tuple(kOther)["value"], "") << "nobody asked this one yet";
  answer("link best " + kOther);
  world_.time.run_for(5s);
  EXPECT_EQ(events_.back()["key"], kOther);
  EXPECT_EQ(events_.back()["value"], "80");
  const auto sequence = tuple(kLight)["sequence"];
  world_.time.run_for(10s);
  EXPECT_EQ(tuple(kLight)["sequence"], sequence) << "sampling of the old one ended";
  EXPECT_EQ(answer("unsubscribe ->65536:best")["ok"], true);
  events_.clear();
  world_.time.run_for(5s);
  EXPECT_THAT(events_, IsEmpty());
}

TEST_F(ShellLinks, ASubscriptionThroughItTellsWhenItLeadsNowhere) {
  answer("link best proxy.island");
  answer("subscribe ->65536:best passive");
  answer("unlink best");
  ASSERT_THAT(events_, SizeIs(4));
  EXPECT_EQ(events_[2]["event"], "deleted");
  EXPECT_EQ(events_[3]["event"], "unresolved");
  EXPECT_EQ(events_[3]["error"]["code"], "not-found");
  EXPECT_EQ(code_of("subscribe ->65536:*"), "invalid");
}

TEST_F(ShellLinks, AppendAsksTheOwner) {
  ASSERT_TRUE(robot_.set("log", "a"));
  const auto applied = answer("append 70000:log b c");
  EXPECT_EQ(applied["verdict"], "applied");
  EXPECT_EQ(applied["sequence"], 2);
  EXPECT_EQ(value_of("log"), "ab c");
  EXPECT_EQ(code_of("append " + kLamp + ".command on"), "refused");
  EXPECT_EQ(code_of("append proxy.island x"), "refused");
  EXPECT_EQ(code_of("append GATEWAY ff"), "refused");
  EXPECT_EQ(code_of("append 70000:none x"), "not-found");
}

TEST_F(ShellLinks, ANumberBehindTheKeyIsTheExpectedSequence) {
  ASSERT_TRUE(robot_.set("log", "a"));
  EXPECT_EQ(answer("append 70000:log@1 b")["sequence"], 2);
  const auto late = answer("append 70000:log@1 c");
  EXPECT_EQ(late["verdict"], "refused");
  EXPECT_EQ(late["sequence"], 2) << "the present one";
  EXPECT_THAT(late["error"]["text"].get<std::string>(), HasSubstr("expected sequence 1, found sequence 2"));
  EXPECT_EQ(answer("set 70000:log@2 new")["sequence"], 3);
  EXPECT_EQ(value_of("log"), "new");
  EXPECT_EQ(code_of("set 70000:log@0 x"), "refused");
  for (const auto* line : {"set 70000:log@ x", "append 70000:log@-1 x", "set 70000:log@1@2 x", "get 70000:log@1",
                           "append 70000:log@99999999999999999999 x"}) {
    EXPECT_EQ(code_of(line), "invalid") << line;
  }
  EXPECT_EQ(value_of("log"), "new");
}

TEST_F(ShellLinks, ALinkOfAnotherComponentIsSetIfItsOwnerAgrees) {
  const auto applied = answer("link 70000:best " + kLight);
  EXPECT_EQ(applied["verdict"], "applied");
  EXPECT_EQ(value_of("best"), "6541:" + kLight);
  EXPECT_EQ(code_of("link 6541:proxy.island " + kLight), "refused");
  EXPECT_EQ(code_of("get ->70000:best"), "not-found") << "not subscribed to";
  answer("subscribe ->70000:best passive");
  EXPECT_EQ(tuple("->70000:best")["key"], kLight);
}

}  // namespace
}  // namespace rubicon::console
