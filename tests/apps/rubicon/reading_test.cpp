#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <map>
#include <thread>

#include "apps/rubicon/live_island.h"
#include "base/text.h"
#include "rubicon/client.hpp"

namespace rubicon::cli {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

/// One island, for all tests, with what can be read well and what cannot: a line that is down, a device that is silent,
/// a name that turns the direction of text, devices that wait.
class Reading : public testing::Test {
 protected:
  struct World {
    PrivateNetwork alone;
    Folder folder;
    std::unique_ptr<Process> home;
  };

  static std::string home_text() {
    return R"(island: {id: 6541, name: home}
state: {file: home.state}
discovery: {rules: [{network: dummy-new, new-devices: ask}]}
recorders: {all: {file: all.rec, patterns: ["proxy.networks"]}}
networks:
  dummy-rooms:
    type: dummy
    silence: 3s
    simulate:
      living-10: {keepalive: 500ms, name: "Living \u202emoor", sensors: {temperature-1: {wave: constant, value: 21.5}, light-1: {}, motion-1: {}, humidity-1: {}}, actuators: {lamp-1: {value: off}, lamp-2: {}, blindPosition-1: {}, dimmer-1: {behaviour: silent}}}
      living-9: {keepalive: 500ms, name: Dining room, sensors: {temperature-1: {}}}
  dummy-sleepy:
    type: dummy
    silence: 2s
    simulate: {attic: {keepalive: 1h, sensors: {temperature-1: {}}}}
  dummy-away:
    type: dummy
    silence: never
    line: {down-at: 100ms}
    simulate: {barn: {actuators: {lock-1: {value: off}}}}
  dummy-new:
    type: dummy
    simulate: {guest: {}}
)";
  }
  static void SetUpTestSuite() {
    world_ = std::make_unique<World>();
    if (!world_->alone.entered()) return;
    world_->home = started(world_->folder.write("home.yaml", home_text()), {"--set", "tuples.engine=dds"});
    // From here on the line is down and the device of the attic is silent.
    Process attic({kProgram, "watch", "6541:proxy.dummy-sleepy.attic.status", "--passive"});
    ASSERT_TRUE(attic.line_with("unreachable"));
    Process away({kProgram, "watch", "6541:proxy.dummy-away.status", "--passive"});
    ASSERT_TRUE(away.line_with("down"));
  }
  static void TearDownTestSuite() { world_.reset(); }
  void SetUp() override {
    if (!world_->alone.entered()) GTEST_SKIP() << world_->alone.reason();
  }
  /// What a terminal of 80 columns shows.
  static std::string on_screen(const std::string& arguments) {
    const auto command = "stty cols 80 rows 24; exec " + kProgram + " " + arguments;
    auto text = support::run_to_end({"env", "NO_COLOR=1", "script", "-qec", command, "/dev/null"}).output;
    std::erase(text, '\r');
    return text;
  }
  static std::size_t longest_line(const std::string& text) {
    std::istringstream lines(text);
    std::size_t longest = 0;
    for (std::string line; std::getline(lines, line);) longest = std::max(longest, base::characters(line));
    return longest;
  }
  static std::unique_ptr<World> world_;
};
std::unique_ptr<Reading::World> Reading::world_;

TEST_F(Reading, TheValueOfADeadSensorDoesNotPassForAFreshOne) {
  const auto dead = rubicon({"get", "attic.temperature-1"});
  EXPECT_EQ(dead.code, 10);
  EXPECT_THAT(dead.errors,
              HasSubstr("6541:proxy.dummy-sleepy.attic.sensor.temperature-1 is device-offline: silent for"));
  EXPECT_THAT(dead.errors, HasSubstr("last heard"));
  const auto down = rubicon({"get", "barn.lock-1"});
  EXPECT_EQ(down.code, 10);
  EXPECT_EQ(down.output, "unlocked\n");
  EXPECT_THAT(down.errors, HasSubstr("is network-down: "));
}

TEST_F(Reading, AGoodValueStandsAlone) {
  const auto good = rubicon({"get", "--fresh", "living-10.temperature-1", "--patience", "20s"});
  EXPECT_EQ(good.code, 0) << good.errors;
  EXPECT_EQ(good.output, "21.5\n");
  EXPECT_EQ(good.errors, "");
  const auto tuple = rubicon({"get", "6541:proxy.networks"});
  EXPECT_EQ(tuple.code, 0) << "a tuple that is no point has no quality";
  EXPECT_EQ(tuple.errors, "");
}

TEST_F(Reading, ScriptsMayTakeEachValue) {
  const auto any = rubicon({"get", "--any-quality", "--quiet", "barn.lock-1"});
  EXPECT_EQ(any.code, 0);
  EXPECT_EQ(any.output, "unlocked\n");
  EXPECT_EQ(any.errors, "");
  EXPECT_EQ(rubicon({"get", "--quiet", "barn.lock-1"}).code, 10);
  EXPECT_THAT(rubicon({"get", "--any-quality", "barn.lock-1"}).errors, HasSubstr("network-down"));
}

TEST_F(Reading, OneFormCarriesQualityAndLineEverywhere) {
  for (const auto& words : {std::vector<std::string>{"get", "--json", "--any-quality", "barn.lock-1"},
                            {"ls", "--json", "barn.lock-1"},
                            {"ls", "--json", "proxy.dummy-away.**"},
                            {"ls", "--json", "proxy.dummy-away.barn.**"},
                            {"watch", "--json", "barn.lock-1", "--passive", "--count", "1"}}) {
    const auto lines = lines_of(rubicon(words));
    const auto line = std::find_if(lines.begin(), lines.end(), [](const json& one) {
      return one.value("key", "") == "proxy.dummy-away.barn.actuator.lock-1.value";
    });
    ASSERT_NE(line, lines.end()) << words[0];
    EXPECT_EQ((*line)["quality"], "network-down");
    EXPECT_NE((*line)["reason"], "");
    EXPECT_TRUE((*line)["heard"].is_number());
    EXPECT_EQ((*line)["line"], "down");
    EXPECT_TRUE(line->contains("creator"));
  }
  const auto all = rubicon({"get", "--all", "--any-quality", "barn.lock-1"});
  EXPECT_THAT(all.output, HasSubstr("quality    network-down: "));
  EXPECT_THAT(all.output, HasSubstr("\nheard      "));
  EXPECT_THAT(all.output, HasSubstr("\nline       down: "));
}

TEST_F(Reading, WatchShowsAChangeOfQualityThoughTheValueStays) {
  Process watch({kProgram, "watch", "living-9.temperature-1", "--passive", "--json"});
  const auto first = json::parse(watch.line().value_or(""), nullptr, false);
  ASSERT_TRUE(first.is_object()) << watch.errors();
  EXPECT_EQ(first["event"], "set");
  {
    Process waker({kProgram, "watch", "living-9.temperature-1", "--count", "3"});
    waker.exit_code();
  }
  // It is not sampled any more: it becomes stale, the value stays.
  const auto stale = json::parse(watch.line_with("\"stale\"").value_or(""), nullptr, false);
  ASSERT_TRUE(stale.is_object()) << watch.errors();
  EXPECT_EQ(stale["event"], "quality");
  EXPECT_THAT(stale["reason"].get<std::string>(), HasSubstr("not heard for"));
}

TEST_F(Reading, NetworksSayWhyALineIsDown) {
  const auto table = rubicon({"networks"});
  EXPECT_EQ(table.code, 0) << table.errors;
  EXPECT_THAT(table.output, ContainsRegex("6541:dummy-away +dummy +down "));
  EXPECT_THAT(table.output, ContainsRegex("6541:dummy-rooms +dummy +up .* 2/2"));
  const auto lines = lines_of(rubicon({"networks", "--json", "--island", "6541", "--for", "1s"}));
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_EQ(lines[0]["network"], "dummy-away");
  EXPECT_EQ(lines[0]["line"], "down");
  EXPECT_NE(lines[0]["reason"], "");
  EXPECT_GT(lines[0]["attempts"].get<int>(), 0);
  EXPECT_GT(lines[0]["next_attempt"].get<double>(), 1.6e9);
  EXPECT_EQ(lines[0]["devices"], 1);
  EXPECT_TRUE(lines[0]["counters"].contains("bad-values"));
  EXPECT_EQ(rubicon({"networks", "--island", "7"}).code, 8);
  const auto one = rubicon({"networks", "6541:dummy-away", "--json"});  // as the table writes it
  EXPECT_EQ(lines_of(one).size(), 1U) << one.errors;
  EXPECT_EQ(rubicon({"networks", "7:dummy-away"}).code, 8);
}

TEST_F(Reading, APatternOfAPointFitsAnyDevice) {
  const auto lines = lines_of(rubicon({"watch", "humid*", "--passive", "--count", "1", "--json"}));
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0]["key"], "proxy.dummy-rooms.living-10.sensor.humidity-1.value");
  EXPECT_EQ(rubicon({"watch", "humidi*", "nothing*", "--passive", "--count", "1"}).code, 0);
}

TEST_F(Reading, DevicesAndDescriptionsShowTheLineAndTheReason) {
  const auto line = lines_of(rubicon({"devices", "--json", "--name", "barn"})).at(0);
  EXPECT_EQ(line["line"], "down");
  EXPECT_NE(line["line_reason"], "");
  EXPECT_THAT(rubicon({"devices"}).output, ContainsRegex("barn +unreachable: line down: "));
  EXPECT_THAT(rubicon({"devices"}).output, ContainsRegex("attic +unreachable: silent for"));
  EXPECT_THAT(rubicon({"describe", "barn"}).output, ContainsRegex("line +down for "));
  EXPECT_THAT(rubicon({"describe", "living-9"}).output, ContainsRegex("line +up for "));
  EXPECT_THAT(rubicon({"tree"}).output, HasSubstr("dummy-away  line down: "));
}

TEST_F(Reading, AlertsSayWhatNeedsAPersonAndWhatToDo) {
  std::map<std::string, nlohmann::json> by_key;
  for (int i = 0; i < 100 && !by_key.contains("proxy.dummy-sleepy.attic"); ++i) {
    by_key.clear();
    for (const auto& line : lines_of(rubicon({"alerts", "--json"}))) by_key[line["about"]] = line;
  }
  const auto& silent = by_key["proxy.dummy-sleepy.attic"];
  EXPECT_EQ(silent["kind"], "device-silent");
  EXPECT_EQ(silent["severity"], "warning");
  EXPECT_EQ(silent["island"], 6541);
  EXPECT_FALSE(by_key.contains("proxy.dummy-rooms.living-10"));
  const auto table = rubicon({"alerts", "--island", "6541"});
  EXPECT_EQ(table.code, 0) << table.errors;
  EXPECT_THAT(table.output, HasSubstr("dummy-sleepy.attic is not reachable: silent"));
  EXPECT_THAT(table.output, HasSubstr("check its power or battery"));
  EXPECT_EQ(rubicon({"alerts", "--island", "6542"}).code, 8);
}

TEST_F(Reading, TheInboxNamesItsIsland) {
  EXPECT_THAT(rubicon({"inbox"}).output, ContainsRegex("6541 .home. +dummy-new.guest"));
  EXPECT_EQ(lines_of(rubicon({"inbox", "--json"})).at(0)["island"], 6541);
}

TEST_F(Reading, AnEntryOfTheInboxThatIsNoJsonHidesNoOther) {
  Process broken({kProgram, "publish", "proxy.inbox.dummy-new.broken", "no json", "--id", "70001", "--open"});
  ASSERT_EQ(broken.line(), "no json") << broken.errors();
  const auto inbox = rubicon({"inbox", "--json"});
  EXPECT_EQ(inbox.code, 0) << inbox.errors;
  EXPECT_THAT(inbox.output, HasSubstr("dummy-new.guest"));
  EXPECT_THAT(inbox.output, HasSubstr(R"({"island":70001})"));
}

TEST_F(Reading, ListsReachableDevicesFirstInNaturalOrder) {
  std::vector<std::string> order;
  for (const auto& line : lines_of(rubicon({"devices", "--json"}))) order.push_back(line["id"]);
  EXPECT_EQ(order, (std::vector<std::string>{"living-9", "living-10", "barn", "attic"}));
}

TEST_F(Reading, AScreenOfEightyColumnsShowsValuesAndNoColumnIsLost) {
  const auto ls = on_screen("ls");
  EXPECT_THAT(ls, HasSubstr("…"));
  EXPECT_THAT(ls, ContainsRegex("living-10.actuator.lamp-1.value +off +"));
  for (const std::string command : {"ls", "devices", "describe living-10", "networks", "islands", "islands --all",
                                    "inbox", "top --rounds 1 --interval 200ms", "ls 'proxy.*.*.description'"}) {
    const auto text = on_screen(command);
    EXPECT_GT(text.size(), 40U) << command;
    EXPECT_LE(longest_line(text), 80U) << command << '\n' << text;
  }
  const auto devices = on_screen("devices");
  for (const auto* word : {"ACTUATORS", "dimmer-1", "blindPosition-1", "humidity-1", "unreachable"})
    EXPECT_THAT(devices, HasSubstr(word)) << devices;
  EXPECT_THAT(on_screen("describe living-10"), HasSubstr("COMMAND"));
}

/// As on a machine that gives a program no processor for a while, at whatever moment.
TEST_F(Reading, AProgramThatIsStoppedForAWhileFindsWhatIsThere) {
  for (const auto moment : {20ms, 60ms, 150ms}) {  // one at a time: each has a second of its own to find the island
    Process stopped({kProgram, "recorder"});
    std::this_thread::sleep_for(moment);
    stopped.signal(SIGSTOP);
    std::this_thread::sleep_for(2s);  // longer than a tool waits for the first component
    stopped.signal(SIGCONT);
    EXPECT_EQ(stopped.exit_code(), 0) << stopped.errors();
  }
}

TEST_F(Reading, WhoDoesNotAnswerIsNamed) {
  client::Options options;
  options.id = OwnerId(70001);
  auto mute = Client::open(options);
  ASSERT_TRUE(mute) << mute.error().text;
  ASSERT_TRUE((*mute)->tuples().set("a", "x"));
  (*mute)->run_until([] { return false; }, 100ms);  // from here on its loop stands still
  const auto ls = rubicon({"ls", "--patience", "6s", "proxy.dummy-rooms.status"});
  EXPECT_EQ(ls.code, 0);
  EXPECT_THAT(ls.output, HasSubstr("proxy.dummy-rooms.status"));
  EXPECT_THAT(ls.errors, HasSubstr("pid " + std::to_string(::getpid()) + " of uid " + std::to_string(::getuid()) +
                                   " has not answered within 6 s: the result lacks its tuples"));
  EXPECT_THAT(rubicon({"ls", "6541:proxy.dummy-rooms.status"}).errors, Not(HasSubstr("answered")));
}

TEST_F(Reading, APipeShowsEverythingAsItIs) {
  for (const auto* command : {"ls", "devices"}) EXPECT_THAT(rubicon({command}).output, Not(HasSubstr("…"))) << command;
  EXPECT_THAT(rubicon({"devices"}).output, HasSubstr("temperature-1 light-1 motion-1 humidity-1"));
}

TEST_F(Reading, NoNameTurnsTheDirectionOfText) {
  for (const std::string command : {"devices", "tree", "describe living-10", "ls 'proxy.*.*.description'"})
    EXPECT_THAT(on_screen(command), Not(HasSubstr("\u202e"))) << command;
  EXPECT_THAT(on_screen("describe living-10"), HasSubstr("Living ?moor"));
}

TEST_F(Reading, TheDoctorFindsTheLineTheDeviceAndTheInbox) {
  const auto told = rubicon({"doctor"});
  EXPECT_EQ(told.code, 1) << told.output;
  EXPECT_THAT(told.output, ContainsRegex("problem +line +network dummy-away of island 6541 home: down for .*: "));
  EXPECT_THAT(told.output, HasSubstr("attempts so far"));
  EXPECT_THAT(told.output, ContainsRegex("note +devices +network dummy-sleepy of island 6541 home: 1 of 1 devices"));
  EXPECT_THAT(told.output, ContainsRegex("note +inbox +1 device waits"));
  EXPECT_THAT(told.output, ContainsRegex("good +clock +the clock of island 6541 home"));
  EXPECT_THAT(told.output, ContainsRegex("disk +island 6541 home: [0-9]+ MB free for its state file"));
  EXPECT_THAT(told.output, ContainsRegex("disk +island 6541 home: [0-9]+ MB free for recorder-all"));
  EXPECT_THAT(told.output, ContainsRegex("whoever may enter .* may read and command island 6541"));
  EXPECT_THAT(told.output, Not(HasSubstr("nothing is wrong")));
}

}  // namespace
}  // namespace rubicon::cli
