#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <iterator>

#include "apps/rubicon/live_island.h"

namespace rubicon::cli {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::StartsWith;

/// An island with recorders, whose own points the commands read and set.
class PointsOfAnIsland : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    configure("5");
    island_ = started(file_);
    ASSERT_TRUE(island_);
  }
  void configure(const std::string& value) {
    file_ = folder_.write("home.yaml",
                          "island: {id: 6541, name: home}\nnetworks:\n  dummy-1: {type: dummy, simulate: {hall: "
                          "{sensors: {temperature-1: {wave: constant, value: " +
                              value + "}}}}}\n  log-table: {type: log, format: csv, file: " + table_ +
                              ", period: 1s, loop: yes, silence: never, map: {room: {columns: {t: {sensor: "
                              "temperature-1}}}}}\nrecorders: {all: {file: " +
                              folder_.file("all.rec") + ", patterns: [\"proxy.**\"]}}\n");
  }

  PrivateNetwork alone_;
  Folder folder_;
  std::string table_ = folder_.write("a.csv", "t\n1\n2\n3\n4\n5\n6\n7\n8\n9\n");
  std::string file_;
  std::unique_ptr<Process> island_;
};

TEST_F(PointsOfAnIsland, SettingsAreShownTriedAndReloaded) {
  EXPECT_THAT(rubicon({"settings"}).output, StartsWith("island: {id: 6541, name: home}\n"));
  EXPECT_EQ(rubicon({"settings", "try"}).output, "nothing changes\n");
  configure("9");
  const auto tried = rubicon({"settings", "try"});
  EXPECT_EQ(tried.code, 0) << tried.errors;
  EXPECT_THAT(tried.output, HasSubstr("network dummy-1: its options change"));
  EXPECT_THAT(rubicon({"settings", "show"}).output, HasSubstr("value: 5"));
  EXPECT_EQ(rubicon({"settings", "reload", "--island", "6541"}).code, 0);
  EXPECT_THAT(rubicon({"settings"}).output, HasSubstr("value: 9"));
  configure("cold");
  const auto refused = rubicon({"settings", "reload"});
  EXPECT_EQ(refused.code, 3) << refused.errors;
  EXPECT_THAT(refused.errors, ContainsRegex("home.yaml:3:[0-9]+: networks.dummy-1"));
  const auto json = lines_of(rubicon({"settings", "try", "--json"})).at(0);
  EXPECT_EQ(json["state"], "refused");
  EXPECT_EQ(json["errors"][0]["line"], 3);
  EXPECT_EQ(rubicon({"settings", "change"}).code, 2);
}

std::string text_of_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST_F(PointsOfAnIsland, ItsFileIsChangedAndTheChangeIsTakenBack) {
  const auto before = text_of_file(file_);
  const auto groups = folder_.write("hall.yaml", "groups: {1/0/1: {dpt: 1.001, kind: actuator}}\n");
  const std::string options = "{type: knx, host: 127.0.0.1}";
  const auto tried = rubicon({"settings", "add", "knx-hall", options, "--groups", groups, "--try"});
  EXPECT_EQ(tried.code, 0) << tried.errors;
  EXPECT_THAT(tried.output,
              StartsWith("network knx-hall: is added\n\nnetworks:\n  knx-hall: {type: knx, host: 127.0.0.1}\n"));
  EXPECT_EQ(text_of_file(file_), before);
  const auto added = rubicon({"settings", "add", "knx-hall", options, "--groups", groups});
  EXPECT_EQ(added.code, 0) << added.errors;
  EXPECT_THAT(text_of_file(file_),
              HasSubstr("  knx-hall: {import: knx-hall.groups.yaml, type: knx, host: 127.0.0.1}\n"));
  EXPECT_EQ(text_of_file(file_ + ".previous"), before);
  EXPECT_THAT(rubicon({"networks"}).output, HasSubstr("knx-hall"));
  const auto again = rubicon({"settings", "add", "knx-hall", options});
  EXPECT_EQ(again.code, 3);
  EXPECT_THAT(again.errors, HasSubstr("has a network knx-hall already"));
  EXPECT_EQ(rubicon({"settings", "import", "knx-hall", groups}).code, 0);
  EXPECT_THAT(text_of_file(file_), HasSubstr("import: knx-hall.groups-2.yaml"));
  EXPECT_EQ(rubicon({"settings", "undo"}).code, 0);
  EXPECT_THAT(text_of_file(file_), HasSubstr("import: knx-hall.groups.yaml"));
  EXPECT_EQ(rubicon({"settings", "import", "knx-hall"}).code, 2);
  const auto large = folder_.write("large.yaml", std::string(900'001, '#'));
  const auto too_large = rubicon({"settings", "import", "knx-hall", large});
  EXPECT_EQ(too_large.code, 2);
  EXPECT_THAT(too_large.errors, HasSubstr(large + ": 900001 bytes, expected at most 900000: put it beside the "
                                                  "configuration and name it there, as in `import: hall.yaml`"));
  EXPECT_EQ(rubicon({"settings", "add", "x", "{type: dummy}", "--groups", folder_.file("none.yaml")}).code, 2);
  EXPECT_EQ(rubicon({"settings", "try", "knx-hall"}).code, 2);
}

TEST_F(PointsOfAnIsland, RecordersAreListedStoppedMarkedAndStarted) {
  EXPECT_THAT(rubicon({"recorder"}).output, ContainsRegex("6541 .home. +all +recording"));
  EXPECT_EQ(rubicon({"recorder", "all", "mark", "lamp changed"}).output, "all is marked\n");
  EXPECT_EQ(rubicon({"recorder", "all", "stop"}).output, "all is stopped\n");
  EXPECT_EQ(lines_of(rubicon({"recorder", "all", "--json"})).at(0)["state"], "stopped");
  const auto late = rubicon({"recorder", "all", "mark"});
  EXPECT_EQ(late.code, 3);
  EXPECT_THAT(late.errors, HasSubstr("recorder all is stopped"));
  EXPECT_THAT(rubicon({"settings"}).output, HasSubstr("all.rec"));
  const auto info = support::run_to_end({kDaemon, "recording", folder_.file("all.rec"), "info"}).output;
  EXPECT_THAT(info, ContainsRegex("marks: 1\n.*: lamp changed\n"));
  EXPECT_THAT(info, HasSubstr("networks: dummy-1, log-table\n"));
  EXPECT_EQ(rubicon({"recorder", "all", "start"}).output, "all records\n");
  EXPECT_EQ(rubicon({"recorder", "none", "stop"}).code, 8);
  EXPECT_EQ(rubicon({"recorder", "none"}).code, 8);
  EXPECT_EQ(rubicon({"recorder", "all", "stop", "now"}).code, 2);
}

TEST_F(PointsOfAnIsland, AReplayIsShownPausedAndSearched) {
  EXPECT_THAT(rubicon({"replay"}).output, ContainsRegex("6541 .home. +log-table +playing +1"));
  EXPECT_EQ(rubicon({"replay", "log-table", "pause"}).output, "log-table: replay-state paused\n");
  EXPECT_EQ(rubicon({"replay", "log-table", "seek", "4.5"}).code, 0);
  EXPECT_EQ(rubicon({"get", "room.temperature-1", "--any-quality"}).output, "5\n");
  EXPECT_EQ(rubicon({"replay", "log-table", "seek", "--", "-2s"}).code, 0);
  EXPECT_EQ(rubicon({"get", "room.temperature-1", "--any-quality"}).output, "3\n");
  EXPECT_EQ(rubicon({"replay", "log-table", "speed", "2"}).code, 0);
  const auto refused = rubicon({"replay", "log-table", "seek", "soon"});
  EXPECT_EQ(refused.code, 3);
  EXPECT_THAT(refused.errors, HasSubstr("'soon', expected seconds"));
  EXPECT_EQ(rubicon({"replay", "log-table", "speed"}).code, 2);
  EXPECT_EQ(rubicon({"replay", "log-table", "pause", "1"}).code, 2);
  EXPECT_EQ(rubicon({"replay", "dummy-1", "pause"}).code, 8);
  EXPECT_EQ(rubicon({"wsn", "monitor"}).code, 8) << "no motes here";
}

TEST_F(PointsOfAnIsland, TheLogIsShownAndFollowed) {
  const auto lines = rubicon({"log"});
  EXPECT_EQ(lines.code, 0) << lines.errors;
  EXPECT_THAT(lines.output, HasSubstr("info    daemon: island 6541 is up"));
  EXPECT_THAT(rubicon({"log", "--level", "error"}).output, testing::Not(HasSubstr("is up")));
  Process follow({kProgram, "log", "--follow", "--json"});
  ASSERT_TRUE(follow.line_with("is up"));
  rubicon({"recorder", "all", "stop"});
  rubicon({"settings", "reload"});
  const auto line = follow.line_with("reloaded");
  ASSERT_TRUE(line) << follow.errors();
  const auto json = nlohmann::json::parse(*line);
  EXPECT_EQ(json["island"], 6541);
  EXPECT_EQ(json["level"], "info");
  EXPECT_EQ(json["subject"], "daemon");
  follow.signal(SIGINT);
  EXPECT_EQ(follow.exit_code(), 0);
}

TEST(PacketsOfMotes, AreShownAsTheyCome) {
  const PrivateNetwork alone;
  if (!alone.entered()) GTEST_SKIP() << alone.reason();
  const Folder folder;
  Process motes({RUBICON_BINARY_DIR "/bin/motes-simulator", "--motes", "1", "--port", "19202", "--wait"});
  const auto island = started(folder.write("motes.yaml",
                                           "island: {id: 6541, name: home}\nnetworks:\n  wsn-1: {type: wsn, source: "
                                           "\"network@127.0.0.1:19202\", board: EM1000}\n"));
  Process monitor({kProgram, "wsn", "monitor", "--network", "wsn-1", "--json"});
  Process watch({kProgram, "watch", "proxy.wsn-1.*.sensor.light-1.value"});
  const auto line = monitor.line_with("\"readings\"");
  ASSERT_TRUE(line) << monitor.errors();
  const auto packet = nlohmann::json::parse(*line);
  EXPECT_EQ(packet["direction"], "in");
  EXPECT_EQ(packet["mote"], 2);
  monitor.signal(SIGINT);
  EXPECT_EQ(monitor.exit_code(), 0);
}

}  // namespace
}  // namespace rubicon::cli
