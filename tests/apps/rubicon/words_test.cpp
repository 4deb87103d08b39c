#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <set>

#include "apps/rubicon/live_island.h"
#include "apps/rubicon/targets/selection.h"

namespace rubicon::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

/// An island with a hall and many rooms, in a network of its own, for all tests.
class Words : public testing::Test {
 protected:
  struct World {
    PrivateNetwork alone;
    Folder folder;
    std::unique_ptr<Process> home;
  };

  static void SetUpTestSuite() {
    world_ = std::make_unique<World>();
    if (!world_->alone.entered()) return;
    std::string text =
        "island: {id: 6541, name: home}\nnetworks:\n  dummy-1:\n    type: dummy\n    simulate:\n"
        "      hall: {name: Front hall, sensors: {temperature-1: {}}, actuators: {switch-1: {}, switch-2: {}}}\n";
    for (int i = 0; i < 25; ++i) text += "      room" + std::to_string(i) + ": {sensors: {motion-1: {}}}\n";
    world_->home = started(world_->folder.write("words.yaml", text), {"--set", "tuples.engine=dds"});
  }
  static void TearDownTestSuite() { world_.reset(); }
  void SetUp() override {
    if (!world_->alone.entered()) GTEST_SKIP() << world_->alone.reason();
  }

  static std::unique_ptr<World> world_;
};
std::unique_ptr<Words::World> Words::world_;

TEST_F(Words, AWrongWordIsAnsweredWithTheNearest) {
  const auto command = rubicon({"wacth", "x"});
  EXPECT_EQ(command.code, 2);
  EXPECT_EQ(command.errors, "rubicon: unknown command 'wacth'; did you mean 'watch'?\n");
  EXPECT_THAT(rubicon({"frobnicate"}).errors, HasSubstr("unknown command 'frobnicate'; `rubicon --help` lists"));
  EXPECT_THAT(rubicon({"knx", "raed"}).errors, HasSubstr("unknown command 'raed'; did you mean 'read'?"));
  EXPECT_THAT(rubicon({"watch", "--pasive"}).errors, HasSubstr("unknown option '--pasive'; did you mean '--passive'?"));
  EXPECT_THAT(rubicon({"send", "7", "chat", "hello"}).errors,
              HasSubstr("unexpected word 'hello'; `rubicon send --help` lists what there is"));
  EXPECT_THAT(rubicon({"get", "hall.switch"}).errors, HasSubstr("'hall.switch' is ambiguous; name one of:\n"));
  EXPECT_THAT(rubicon({"set", "hal.switch-1", "on"}).errors, HasSubstr("; did you mean 'hall.switch-1'"));
  EXPECT_THAT(rubicon({"get", "proxy.netwroks"}).errors, HasSubstr("did you mean 'proxy.networks'?"));
  EXPECT_THAT(rubicon({"devices", "--type", "temprature"}).errors, HasSubstr("did you mean 'temperature'?"));
  EXPECT_THAT(rubicon({"describe", "Front hal"}).errors, HasSubstr("did you mean 'Front hall'?"));
  EXPECT_EQ(rubicon({"types", "temprature"}).code, 8);
}

TEST_F(Words, WatchSaysWhyItSawNothing) {
  const auto nothing = rubicon({"watch", "--for", "1s", "nothing.there-1"});
  EXPECT_EQ(nothing.code, 8);
  EXPECT_THAT(nothing.errors, HasSubstr("nothing fits nothing.there-1 yet (looked in folder "));
}

TEST_F(Words, AStarWithinAPartWakesOnlyWhatFits) {
  Process watch({kProgram, "watch", "room1?.mot*-1"});
  std::string seen;
  while (seen.find("room10.") == seen.npos || seen.find("room19.") == seen.npos) {
    const auto line = watch.line();
    ASSERT_TRUE(line) << seen << watch.errors();
    seen += *line + "\n";
  }
  watch.signal(SIGINT);
  while (const auto line = watch.line()) seen += *line + "\n";
  EXPECT_EQ(watch.exit_code(), 0) << watch.errors();
  for (const auto* room : {"room1.", "room20.", "room2."}) EXPECT_THAT(seen, Not(HasSubstr(room)));
  for (const auto& point : lines_of(rubicon({"ls", "room*.motion-1", "--json"}))) {
    const auto key = point["key"].get<std::string>();
    if (key.find(".room1") != key.npos && key.find(".room1.") == key.npos) continue;
    EXPECT_EQ(point["value"], "") << point;
    EXPECT_EQ(point["heard"], 0) << point;
  }
  EXPECT_EQ(lines_of(rubicon({"ls", "room2*.motion-?", "--json"})).size(), 6U);
  EXPECT_EQ(lines_of(rubicon({"ls", "proxy.dummy-1.room1?.sensor.motion-*.value", "--json"})).size(), 10U);
  EXPECT_THAT(rubicon({"get", "room2*.motion-1"}).errors, HasSubstr("is a pattern, expected one tuple; `rubicon ls`"));
}

TEST_F(Words, AStarWithinAPartWakesThousands) {
  constexpr std::size_t kRooms = 3000, kMaxLineCount = 200 * kRooms;
  const auto file = world_->folder.write(
      "many.yaml",
      "island: {id: 6542, name: hotel}\ntuples: {space: hotel}\nnetworks:\n  dummy-many:\n    type: dummy\n"
      "    simulate: {\"suite-{1..3000}\": {sensors: {temperature-1: {}}}}\n");
  const auto hotel = started(file);
  Process watch({kProgram, "watch", "proxy.*.*.sensor.temp*-1.value", "--space", "hotel", "--json"});
  std::set<std::string> woken;
  for (std::size_t i = 0; i < kMaxLineCount && woken.size() < kRooms; ++i) {
    const auto line = json::parse(watch.line().value_or(""), nullptr, false);
    if (!line.is_object()) break;
    if (line["value"] != "") woken.insert(line["key"].get<std::string>());
  }
  EXPECT_EQ(woken.size(), kRooms);
  watch.signal(SIGTERM);
  while (watch.line()) continue;  // it ends when it has written what it has to say
  EXPECT_THAT(watch.exit_code(), testing::AnyOf(0, 128 + SIGTERM)) << "where it has no time to say good-bye";
}

TEST(WokenTuples, BeyondABoundAreToldOfAndNotWoken) {
  std::vector<std::string> woken;
  Wakers wakers(
      [&woken](const Pattern& exact) {
        woken.push_back(exact.key);
        return Handle();
      },
      2);
  testing::internal::CaptureStderr();
  for (const auto* key : {"a", "a", "b"}) wakers.wake(OwnerId(5), key);
  EXPECT_FALSE(wakers.full());
  for (const auto* key : {"c", "d", "a"}) wakers.wake(OwnerId(5), key);
  EXPECT_TRUE(wakers.full());
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "rubicon: more than 2 tuples match: the others are shown, but not woken\n");
  wakers.forget(OwnerId(5), "a");
  wakers.wake(OwnerId(5), "c");
  EXPECT_THAT(woken, testing::ElementsAre("a", "b", "c"));
}

TEST_F(Words, ListsTypesWithoutAnyIsland) {
  const auto types = support::run_to_end({"env", "RUBICON_DOMAIN=9", kProgram, "types", "temperature"});
  EXPECT_EQ(types.code, 0) << types.errors;
  EXPECT_THAT(types.output,
              testing::ContainsRegex("\ntemperature +[0-9]+ +°C +real +-273.15\\.\\.[0-9]+ +temperature\n"));
  const auto line = lines_of(rubicon({"types", "co2", "--json"})).at(0);
  EXPECT_EQ(line["unit"], "[ppm]");
  EXPECT_EQ(line["number"], 0x040d);
  for (const auto* command : {" types", " completion bash", " manual"}) {
    const auto full = support::run_to_end({"sh", "-c", kProgram + command + " >/dev/full"});
    EXPECT_EQ(full.code, 1) << command;
    EXPECT_THAT(full.errors, HasSubstr("rubicon: standard output: "));
  }
}

TEST_F(Words, ReceivesWhatOthersSend) {
  Process chat({kProgram, "receive", "--type", "chat", "--name", "kitchen", "--count", "2", "--json"});
  const auto send = [](const std::string& type, const std::string& text) {
    return rubicon({"send", "kitchen", "--type", type, text}).code;
  };
  const auto is_early = [](int code) { return code == 8 || code == 3; };  // it is not there, or does not listen yet
  for (int i = 0; i < 200 && is_early(send("chat", "first")); ++i) continue;
  EXPECT_NE(send("other", "not this"), 0);
  EXPECT_EQ(send("chat", "second"), 0);
  const auto first = json::parse(chat.line().value_or(""), nullptr, false);
  ASSERT_TRUE(first.is_object()) << chat.errors();
  EXPECT_EQ(first["text"], "first");
  EXPECT_EQ(first["type"], "chat");
  EXPECT_EQ(json::parse(chat.line().value_or(""), nullptr, false)["text"], "second");
  EXPECT_EQ(chat.exit_code(), 0) << chat.errors();
  EXPECT_THAT(chat.errors(), HasSubstr("for messages of type chat"));
  EXPECT_EQ(rubicon({"receive", "--for", "100ms"}).code, 8);
}

TEST_F(Words, WhoSendsTheLastMessageHasItsAnswer) {
  Process chat({kProgram, "receive", "--name", "cellar", "--count", "1"});
  Outcome sent{8, "", ""};
  for (int i = 0; i < 200 && (sent.code == 8 || sent.code == 3); ++i) sent = rubicon({"send", "cellar", "the last"});
  EXPECT_EQ(sent.code, 0) << sent.errors;
  EXPECT_EQ(chat.exit_code(), 0) << chat.errors();
}

TEST_F(Words, PublishesATupleWhileItRuns) {
  Process robot({kProgram, "publish", "robot.goal", "kitchen", "--id", "70001", "--open"});
  EXPECT_EQ(robot.line(), "kitchen") << robot.errors();
  EXPECT_EQ(rubicon({"get", "robot.goal"}).output, "kitchen\n");
  EXPECT_EQ(rubicon({"set", "70001:robot.goal", "hall"}).code, 0);
  EXPECT_EQ(robot.line(), "hall");
  EXPECT_EQ(rubicon({"append", "70001:robot.goal", "way"}).code, 0);
  EXPECT_EQ(robot.line(), "hallway");
  EXPECT_EQ(rubicon({"delete", "70001:robot.goal"}).code, 0);
  EXPECT_EQ(robot.exit_code(), 0) << robot.errors();
  EXPECT_EQ(rubicon({"publish", "robot goal", "x"}).code, 2);
  EXPECT_EQ(rubicon({"publish", "robot.goal", "x", "--id", "7"}).code, 2);
  EXPECT_EQ(rubicon({"publish", "robot.goal", "x", "--for", "100ms"}).code, 0);
}

TEST_F(Words, CompletesTheWordsOfAValue) {
  EXPECT_EQ(completed({"set", "hall.switch-1", ""}).output, "off\non\n");
  EXPECT_EQ(completed({"set", "proxy.dummy-1.hall.actuator.switch-1.command", "of"}).output, "off\n");
}

}  // namespace
}  // namespace rubicon::cli
