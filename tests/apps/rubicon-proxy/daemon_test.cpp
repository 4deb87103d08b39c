#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "support/conversation.h"
#include "support/meeting_folder.h"
#include "support/process.h"
#include "support/programs.h"
#include "support/terminal.h"

namespace rubicon::daemon {

using namespace support;

namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

const std::string kHome = RUBICON_SOURCE_DIR "/examples/home.yaml";
/// The islands of tests meet nobody.
const std::string kAlone = "tuples.engine=memory";
const std::string kRoom = "proxy.dummy-1.room";

/// The real program on a small island of its own.
class Daemon : public testing::Test {
 protected:
  Daemon() {
    directory_ = std::filesystem::path(testing::TempDir()) /
                 ("rubicon_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(directory_);
    write("room.yaml",
          "island: {id: 6541, name: test}\n"
          "networks:\n"
          "  dummy-1:\n"
          "    type: dummy\n"
          "    simulate:\n"
          "      room:\n"
          "        name: Room\n"
          "        sensors: {temperature-1: {wave: constant, value: 21.5}}\n"
          "        properties: {rate: 20}\n"
          "        actuators: {lamp-1: {behaviour: obey, delay: 1ms}}\n"
          "tuples: {engine: memory}\n");
  }
  ~Daemon() override { std::filesystem::remove_all(directory_); }

  std::string write(const std::string& name, const std::string& text) {
    std::ofstream(directory_ / name, std::ios::binary) << text;
    return (directory_ / name).string();
  }
  std::string room() const { return (directory_ / "room.yaml").string(); }

  /// Asks until the device has joined.
  static bool joined(Process& shell) {
    for (int i = 0; i < 1000; ++i) {
      shell.write("devices\n");
      const auto line = parsed(shell.line());
      if (line.contains("device")) return parsed(shell.line())["count"] == 1;
      if (line.is_null()) return false;
    }
    return false;
  }

  std::filesystem::path directory_;
};

TEST_F(Daemon, TellsItsVersionAndItsNetworks) {
  const auto version = run_to_end({kDaemon, "--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_EQ(version.output.rfind("rubicon-proxy ", 0), 0U) << version.output;
  const auto networks = run_to_end({kDaemon, "networks"});
  EXPECT_EQ(networks.code, 0);
  EXPECT_THAT(networks.output, HasSubstr("dummy: "));
  EXPECT_THAT(networks.output, HasSubstr("log: "));
  EXPECT_THAT(networks.output, HasSubstr("salad: "));
  EXPECT_THAT(networks.output, HasSubstr("type: dummy"));
}

TEST_F(Daemon, AWrongCallOrConfigurationEndsWithTwoAndSaysWhatIsMeant) {
  EXPECT_EQ(run_to_end({kDaemon}).errors,
            "rubicon-proxy: expected a command; `rubicon-proxy --help` lists what there is\n");
  const auto unknown = run_to_end({kDaemon, "chekc", room()});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_EQ(unknown.errors, "rubicon-proxy: unknown command 'chekc'; did you mean 'check'?\n");
  EXPECT_EQ(run_to_end({kDaemon, "run"}).code, 2);
  EXPECT_EQ(run_to_end({kDaemon, "run", room(), "--log-level", "loud"}).code, 2);
  EXPECT_EQ(run_to_end({kDaemon, "--help"}).code, 0);
  EXPECT_EQ(run_to_end({kDaemon, "run", "/nowhere.yaml"}).code, 2);
  EXPECT_EQ(run_to_end({kDaemon, "check", "/nowhere.yaml"}).code, 2);
  EXPECT_EQ(run_to_end({kDaemon, "run", room(), "--watch", "a..b"}).code, 2);
}

TEST_F(Daemon, EveryExampleIsGood) {
  int examples = 0;
  for (const auto& entry : std::filesystem::directory_iterator(RUBICON_SOURCE_DIR "/examples")) {
    if (entry.path().extension() != ".yaml") continue;
    ++examples;
    const auto checked = run_to_end({kDaemon, "check", "--elsewhere", entry.path().string()});
    EXPECT_EQ(checked.code, 0) << entry.path() << checked.output << checked.errors;
  }
  EXPECT_GE(examples, 4);
}

TEST_F(Daemon, CheckSaysGoodOrAllThatIsWrong) {
  const auto good = run_to_end({kDaemon, "check", kHome});
  EXPECT_EQ(good.code, 0) << good.errors;
  EXPECT_THAT(good.output, HasSubstr("ok: 3 networks ("));
  const auto bad = write(
      "bad.yaml", "island: {id: 0}\nnetworks:\n  dummy-1:\n    type: dummy\n    sede: 1\n  bacnet: {type: bacnet}\n");
  for (const auto* command : {"check", "run"}) {
    const auto outcome = run_to_end({kDaemon, command, bad});
    EXPECT_EQ(outcome.code, 2);
    EXPECT_EQ(outcome.output, "");
    EXPECT_THAT(outcome.errors, HasSubstr(bad + ":1:14: island.id: is '0', expected a whole number from 1"));
    EXPECT_THAT(outcome.errors, HasSubstr(bad + ":5:5: networks.dummy-1: unknown key 'sede'"));
    EXPECT_THAT(outcome.errors,
                HasSubstr(bad + ":6:18: networks.bacnet.type: is 'bacnet', expected one of: dummy, log, salad"));
  }
  const auto set = run_to_end({kDaemon, "check", kHome, "--set", "networks.dummy-rooms.seed=x", "--set", "a.b=1"});
  EXPECT_EQ(set.code, 2);
  EXPECT_THAT(set.errors, HasSubstr("--set 'networks.dummy-rooms.seed=x': networks.dummy-rooms.seed: is 'x'"));
  EXPECT_THAT(set.errors, HasSubstr("--set 'a.b=1': unknown key 'a'"));
}

TEST_F(Daemon, CheckFindsWhatThisHostLacksUnlessItIsMeantForAnother) {
  const auto file = write("far.yaml",
                          "island: {id: 6541}\n"
                          "tuples: {interfaces: [nosuch0]}\n"
                          "state: {file: gone/home.state}\n"
                          "networks:\n"
                          "  log-a: {type: log, file: nowhere.rec}\n"
                          "  log-b: {type: log, format: csv, files: [none-*.csv], period: 1s,\n"
                          "          map: {a: {columns: {b: {sensor: light-1}}}}}\n"
                          "recorders: {all: {file: lost/all.rec, patterns: [\"proxy.**\"]}}\n");
  const auto here = run_to_end({kDaemon, "check", file});
  EXPECT_EQ(here.code, 2);
  EXPECT_EQ(here.output, "");
  for (const auto& line :
       {file + ":2:10: tuples.interfaces: DDS: there is no interface 'nosuch0' on this host",
        file + ":3:9: state.file: there is no folder " + (directory_ / "gone").string(),
        file + ":5:22: networks.log-a.file: " + (directory_ / "nowhere.rec").string() + ": cannot open: No such file",
        file + ":6:35: networks.log-b.files: no file matches " + (directory_ / "none-*.csv").string(),
        file + ":8:19: recorders.all.file: there is no folder " + (directory_ / "lost").string(),
        std::string("as seen on this host; `check --elsewhere`")}) {
    EXPECT_THAT(here.errors, HasSubstr(line));
  }
  const auto elsewhere = run_to_end({kDaemon, "check", "--elsewhere", file});
  EXPECT_EQ(elsewhere.code, 0) << elsewhere.errors;
  EXPECT_THAT(elsewhere.output, HasSubstr("ok: 2 networks (log-a, log-b), 0 devices named"));
  std::filesystem::create_directory(directory_ / "gone");
  EXPECT_THAT(run_to_end({kDaemon, "check", file}).errors, testing::Not(HasSubstr("state.file")));
}

TEST_F(Daemon, CheckWarnsOfNamesThatFitNothing) {
  const auto file = write("names.yaml",
                          "island: {id: 6541}\ntuples: {engine: memory}\nnetworks:\n  - type: dummy\n    simulate:\n"
                          "      2: {sensors: {light-1: {}}, actuators: {switch-1: {}}}\n"
                          "    devices:\n"
                          "      2: {sensors: {lihgt-1: sill}, actuators: {switch-1: lamp, dimmer-1: top}}\n"
                          "      twelve: {id: hall}\n");
  const auto checked = run_to_end({kDaemon, "check", file});
  EXPECT_EQ(checked.code, 0) << "a device may come later: it is a warning";
  EXPECT_THAT(checked.output, HasSubstr("ok: 1 network (dummy-1), 2 devices named"));
  for (const auto* line :
       {":8:21: networks.dummy-1.devices.2.sensors.lihgt-1: the device has no such sensor; did you mean 'light-1'? "
        "There are: light-1\n",
        ":8:65: networks.dummy-1.devices.2.actuators.dimmer-1: the device has no such actuator, there are: switch-1\n",
        ":9:7: networks.dummy-1.devices.twelve: the network has no such device\n"}) {
    EXPECT_THAT(checked.errors, HasSubstr("warning: " + file + line));
  }
  EXPECT_THAT(checked.errors, testing::Not(HasSubstr("switch-1: the device")));
}

TEST_F(Daemon, TuplesOfTheCommandLineAreThereFromTheStart) {
  Process shell({kDaemon, "run", room(), "--shell", "--tuple", "house.motto=a=b c", "--tuple", "empty="});
  shell.write("get house.motto\nget empty\nset house.motto other\nget house.motto\n");
  const auto motto = parsed(shell.line())["tuple"];
  EXPECT_EQ(motto["value"], "a=b c");
  EXPECT_EQ(motto["owner"], 6541);
  EXPECT_EQ(motto["media"], "text/plain");
  EXPECT_EQ(parsed(shell.line())["tuple"]["value"], "");
  EXPECT_EQ(parsed(shell.line_with("verdict"))["verdict"], "applied") << "others may set it, as in the original";
  shell.write("quit\n");
  EXPECT_EQ(shell.exit_code(), 0);
  for (const auto& [tuple, why] : std::map<std::string, std::string>{
           {"novalue", "--tuple 'novalue': expected KEY=VALUE"},
           {"a..b=1", "--tuple 'a..b=1': "},
           {"a.*=1", "--tuple 'a.*=1': "},
           {"=1", "--tuple '=1': "},
           {"proxy.island=1", "--tuple 'proxy.island=1': the island keeps the tuples of proxy itself"},
           {"GATEWAY=1", "--tuple 'GATEWAY=1': the island keeps the tuples of GATEWAY itself"}}) {
    const auto refused = run_to_end({kDaemon, "run", room(), "--tuple", tuple});
    EXPECT_EQ(refused.code, 2) << tuple;
    EXPECT_THAT(refused.errors, HasSubstr(why));
  }
  const auto twice = run_to_end({kDaemon, "run", room(), "--tuple", "a=1", "--tuple", "a=2"});
  EXPECT_EQ(twice.code, 2);
  EXPECT_THAT(twice.errors, HasSubstr("--tuple 'a=2': its key is given twice"));
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_F(Daemon, AConfigurationOfManyLinesCostsLittleMoreThanARangeOnceItWasRead) {
  const std::string sensors =
      "{name: Room, sensors: {temperature-1: {wave: sine, low: 10, high: 20, period: 60s, noise: 0.1}, humidity-1: "
      "{wave: sine, low: 40, high: 60, period: 60s}, co2-1: {wave: sine, low: 500, high: 900, period: 60s}}}\n";
  const std::string head =
      "island: {id: 6541}\ntuples: {engine: memory}\nnetworks:\n  dummy-1:\n    type: dummy\n    simulate:\n";
  std::string lines = head;
  for (int i = 0; i < 2000; ++i) lines += "      room-" + std::to_string(i) + ": " + sensors;
  std::map<std::string, long> resident;
  for (const auto& [name, text] :
       std::map<std::string, std::string>{{"lines", lines}, {"range", head + "      \"room-{0..1999}\": " + sensors}}) {
    Process shell({kDaemon, "run", write(name + ".yaml", text), "--shell", "--log-level", "error"});
    std::string status;
    for (const auto end = Clock::now() + 60s; status.find("reachable") == status.npos && Clock::now() < end;) {
      shell.write("get proxy.dummy-1.room-1999.status\n");
      status = parsed(shell.line()).dump();
    }
    EXPECT_THAT(status, HasSubstr("reachable"));
    resident[name] = shell.resident_kilobytes();
  }
  EXPECT_LT(resident["lines"] - resident["range"], 12 * 1024) << "of 400 kB of text; the tree of it takes 30 MB";
}
#endif

TEST_F(Daemon, TheDemoIslandIsThereAndSmall) {
  const auto start = Clock::now();
  Process shell({kDaemon, "run", kHome, "--shell", "--set", "networks.salad.rubicon_port=0", "--set", kAlone});
  std::set<std::string> devices;
  while (devices.size() < 9 + 55 && Clock::now() < start + 60s) {
    shell.write("devices\n");
    for (auto line = parsed(shell.line()); line.contains("device"); line = parsed(shell.line())) {
      devices.insert(line["device"]);
    }
  }
  EXPECT_EQ(devices.size(), 9U + 55U);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_LT(shell.resident_kilobytes(), 25 * 1024);
#endif
  RecordProperty("milliseconds_to_all_devices", static_cast<int>((Clock::now() - start) / 1ms));
  shell.write("quit\n");
  EXPECT_EQ(shell.exit_code(), 0);
}

TEST_F(Daemon, TheShellSetsGetsAndSubscribes) {
  Process shell({kDaemon, "run", room(), "--shell"});
  ASSERT_TRUE(joined(shell)) << shell.errors();
  shell.write("subscribe " + kRoom + ".sensor.temperature-1.value\n");
  EXPECT_EQ(parsed(shell.line_with("subscription"))["ok"], true);
  const auto event = parsed(shell.line_with("21.5"));
  EXPECT_EQ(event["owner"], 6541);
  EXPECT_EQ(event["event"], "set");
  shell.write("unsubscribe " + kRoom + ".sensor.temperature-1.value\nset " + kRoom + ".actuator.lamp-1.command on\n");
  EXPECT_EQ(parsed(shell.line_with("\"ok\""))["ok"], true);
  EXPECT_EQ(parsed(shell.line_with("verdict"))["verdict"], "applied");
  json value;
  for (int i = 0; i < 1000 && value != "on"; ++i) {
    shell.write("get " + kRoom + ".actuator.lamp-1.value\n");
    value = parsed(shell.line())["tuple"]["value"];
  }
  EXPECT_EQ(value, "on");
  shell.write("set " + kRoom + ".actuator.lamp-1.command purple\nget " + kRoom + ".nothing\n");
  EXPECT_EQ(parsed(shell.line())["error"]["code"], "invalid");
  EXPECT_EQ(parsed(shell.line())["error"]["code"], "not-found");
  shell.close_input();
  EXPECT_EQ(shell.exit_code(), 0) << "the end of the input ends the shell";
}

TEST_F(Daemon, OnATerminalItShowsItsLogAndWhereTheValuesAre) {
  Terminal terminal({kDaemon, "run", room(), "--set", "web={listen: \"127.0.0.1:0\"}"}, 24, 160);
  EXPECT_TRUE(terminal.shows("values: http://127.0.0.1:")) << terminal.text();  // no tool sees an island in memory
  EXPECT_TRUE(terminal.shows("island 6541 is up")) << terminal.text();
  terminal.signal(SIGTERM);
  EXPECT_EQ(terminal.exit_code(), 0);
  const MeetingFolder folder;
  Terminal other({kDaemon, "run", room(), "--set", "tuples={}"}, 24, 160);
  EXPECT_TRUE(other.shows("values: `rubicon top`")) << other.text();
}

TEST_F(Daemon, WatchPrintsALineForEachSetEqualValuesToo) {
  Process watch({kDaemon, "run", room(), "--watch", "proxy.*.*.sensor.*.value"});
  std::uint64_t next = 1;
  for (int i = 0; i < 20; ++i) {
    const auto event = parsed(watch.line());
    ASSERT_TRUE(event.is_object()) << watch.errors();
    EXPECT_EQ(event["key"], kRoom + ".sensor.temperature-1.value");
    EXPECT_EQ(event["seq"], next++);
    EXPECT_EQ(event["value"], i == 0 ? "" : "21.5");
    EXPECT_EQ(event["mimetype"], "text/plain");
    EXPECT_GT(event["write"].get<double>(), 1.6e9);
  }
  watch.signal(SIGTERM);
  EXPECT_EQ(watch.exit_code(), 0);
}

TEST_F(Daemon, ManySetsInOneTurnAreAllWatched) {
  Process both({kDaemon, "run", room(), "--shell", "--watch", "6541:" + kRoom + ".actuator.lamp-1.command"});
  ASSERT_TRUE(parsed(both.line_with("\"seq\":1"))["ok"].is_null()) << both.errors();
  std::string lines;
  for (int i = 0; i < 50; ++i) lines += "set " + kRoom + ".actuator.lamp-1.command on\n";
  both.write(lines);
  int applied = 0;
  std::uint64_t last = 1;
  while (applied < 50 || last < 51) {
    const auto line = parsed(both.line());
    ASSERT_TRUE(line.is_object()) << applied << " " << last;
    if (line.contains("verdict")) {
      ++applied;
      continue;
    }
    EXPECT_EQ(line["seq"], ++last);
  }
  both.close_input();
  both.signal(SIGINT);
  EXPECT_EQ(both.exit_code(), 0);
}

TEST_F(Daemon, TwoWatchesAndAShellKeepRunningAfterTheEndOfTheInput) {
  Process both({kDaemon, "run", room(), "--shell", "--watch", "proxy.*.*.sensor.*.value", "--watch", "proxy.island"});
  both.close_input();
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(both.line()) << both.errors();
  both.signal(SIGTERM);
  EXPECT_EQ(both.exit_code(), 0);
}

TEST_F(Daemon, ASignalEndsIt) {
  for (const int number : {SIGTERM, SIGINT}) {
    Process quiet({kDaemon, "run", room(), "--watch", "**"});
    ASSERT_TRUE(quiet.line()) << quiet.errors();
    quiet.signal(number);
    EXPECT_EQ(quiet.exit_code(), 0);
  }
}

TEST_F(Daemon, AReaderThatStopsReadingDoesNotKeepItFromEnding) {
  Process watch({kDaemon, "run", room(), "--shell", "--watch", "**", "--set",
                 "networks.dummy-1.simulate.room.properties.rate=10"});
  ASSERT_TRUE(watch.line());
  for (int i = 0; i < 2000; ++i) watch.write("ls **\n");  // more answers than a pipe holds
  watch.signal(SIGTERM);
  EXPECT_EQ(watch.exit_code(), 0);
}

TEST_F(Daemon, ASignalEndsItAlsoWhenItWaitsAtItsEndForAReaderThatStoppedReading) {
  Process shell({kDaemon, "run", room(), "--shell"});
  ASSERT_TRUE(joined(shell));
  for (int i = 0; i < 40; ++i) shell.write("ls **\n");  // more than a pipe holds, too little to hold up the shell
  shell.write("quit\n");
  ASSERT_TRUE(shell.has_settled());
  shell.signal(SIGTERM);
  EXPECT_EQ(shell.exit_code(), 0);
}

TEST_F(Daemon, AClosedOutputEndsItQuietly) {
  Process watch({kDaemon, "run", room(), "--watch", "**"});
  ASSERT_TRUE(watch.line());
  watch.close_output();
  EXPECT_EQ(watch.exit_code(), 0) << "its next line finds nobody";
}

TEST_F(Daemon, GarbageOnTheInputIsAnsweredLineByLine) {
  Process shell({kDaemon, "run", room(), "--shell"});
  ASSERT_TRUE(joined(shell));
  const std::string garbage = std::string("\0\x01\xff\xfe\n", 5) + "{}\n" + std::string(200'000, 'x') + "\nget " +
                              std::string(10'000, 'k') + "\nset a\n\n\r\n";
  shell.write(garbage + "get proxy.island\n");
  for (const auto* code : {"invalid", "invalid", "out-of-range", "not-found", "not-found"}) {
    const auto line = parsed(shell.line());
    EXPECT_EQ(line["ok"], false);
    EXPECT_EQ(line["error"]["code"], code) << line;
  }
  EXPECT_EQ(parsed(shell.line())["ok"], true);
  std::string noise;
  for (unsigned i = 0; i < 300'000; ++i) noise += static_cast<char>((i * 2654435761U) >> 24U);
  shell.write(noise + "\nquit\n");
  EXPECT_TRUE(shell.line_with("{\"ok\":true}"));
  EXPECT_EQ(shell.exit_code(), 0);
}

TEST_F(Daemon, AScriptPostsAMessageWrittenByTheDocumentedForm) {
  const auto script = run_to_end({"python3", RUBICON_SOURCE_DIR "/tests/apps/rubicon-proxy/post_message.py", "6541",
                                  "a-type-without-listener", "hello"});
  ASSERT_EQ(script.code, 0) << script.errors;
  Process shell({kDaemon, "run", room(), "--shell"});
  shell.write(script.output);
  const auto answer = parsed(shell.line());
  EXPECT_EQ(answer["ok"], true) << answer;
  EXPECT_EQ(answer["key"], "GATEWAY");
  shell.write("post ff00\n");
  EXPECT_EQ(parsed(shell.line())["error"]["code"], "invalid");
}

TEST_F(Daemon, RunsWithoutAnyStandardStream) {
  const auto outcome = run_to_end({"sh", "-c",
                                   "exec <&- >&- 2>&-; timeout -s TERM 1 '" + kDaemon + "' run '" + room() +
                                       "' --shell --watch '**'; echo $? >'" + room() + ".code'"});
  int code = -1;
  std::ifstream(room() + ".code") >> code;
  EXPECT_TRUE(code == 0 || code == 124) << code;
}

TEST_F(Daemon, AMissingRecordingIsNamedAndTheRestOfTheIslandLives) {
  const auto file =
      write("lost.yaml",
            "island: {id: 6541}\ntuples: {engine: memory}\nnetworks:\n  dummy: {type: dummy, simulate: {a: {sensors: "
            "{temperature-1: {}}}}}\n  log: {type: log, file: nowhere.bin}\n");
  Process shell({kDaemon, "run", file, "--shell"});
  json line;
  for (int i = 0; i < 1000 && line["value"].dump().find("nowhere.bin") == std::string::npos; ++i)
    line = support::ask(shell, "get proxy.log.status");
  EXPECT_THAT(line["value"].dump(), HasSubstr("down"));
  EXPECT_THAT(line["value"].dump(), HasSubstr("nowhere.bin"));
  EXPECT_TRUE(joined(shell));
}

TEST_F(Daemon, RecordsAndShowsWhatIsInTheRecording) {
  const auto file = write("recorded.yaml",
                          "island: {id: 6541}\ntuples: {engine: memory}\nnetworks:\n  dummy: {type: dummy, simulate: "
                          "{a: {name: \"a, b\", sensors: "
                          "{temperature-1: {wave: constant, value: 21.5}}}}}\n"
                          "recorders: {all: {file: home.rec, patterns: [\"proxy.**\"], active: yes}}\n");
  const auto recording = (directory_ / "home.rec").string();
  {
    Process shell({kDaemon, "run", file, "--shell", "--watch", "proxy.dummy.a.sensor.*.value"});
    EXPECT_TRUE(shell.line_with("21.5"));
    shell.close_input();
    shell.signal(SIGTERM);
    EXPECT_EQ(shell.exit_code(), 0);
  }
  const auto info = run_to_end({kDaemon, "recording", recording, "info"});
  EXPECT_EQ(info.code, 0) << info.errors;
  EXPECT_THAT(info.output, HasSubstr("island: 6541, prefix 'proxy'"));
  EXPECT_THAT(info.output, HasSubstr("networks: dummy\n"));
  EXPECT_THAT(info.output, HasSubstr("damage: none"));
  const auto rows = run_to_end({kDaemon, "recording", recording, "export", "--pattern", "proxy.*.*.sensor.*.value"});
  EXPECT_EQ(rows.code, 0);
  EXPECT_THAT(rows.output, HasSubstr(",6541,proxy.dummy.a.sensor.temperature-1.value,21.5,text,text/plain,6541,"));
  const auto lines = run_to_end({kDaemon, "recording", recording, "export", "--jsonl", "--pattern", "**.description"});
  EXPECT_EQ(lines.code, 2) << "a pattern that is none";
  const auto out = (directory_ / "out.jsonl").string();
  EXPECT_EQ(run_to_end({kDaemon, "recording", recording, "export", "--jsonl", "--out", out}).code, 0);
  EXPECT_EQ(run_to_end({kDaemon, "recording", recording, "export", "--jsonl", "--out", out}).code, 1) << "it is there";
  EXPECT_EQ(run_to_end({kDaemon, "recording", file, "info"}).code, 2);
  EXPECT_EQ(run_to_end({kDaemon, "recording", recording + "x", "info"}).code, 2);
}

TEST_F(Daemon, KilledItLosesAtMostASecondOfItsRecording) {
  const auto file =
      write("recorded.yaml",
            "island: {id: 6541}\ntuples: {engine: memory}\nnetworks:\n  dummy: {type: dummy, simulate: {a: {sensors: "
            "{temperature-1: {wave: sine, low: 0, high: 20}}, properties: {rate: 20}}}}\n"
            "recorders: {all: {file: home.rec, patterns: [\"proxy.**\"]}}\n");
  constexpr std::size_t kASecond = 50;  // values, 20 ms each; on a busy machine a second has fewer
  std::vector<double> seen;
  {
    Process watch({kDaemon, "run", file, "--watch", "proxy.dummy.a.sensor.*.value"});
    while (seen.size() < 3 * kASecond) {
      const auto line = parsed(watch.line());
      ASSERT_TRUE(line.is_object()) << watch.errors();
      if (!line["value"].get<std::string>().empty()) seen.push_back(line["write"].get<double>());
    }
    watch.signal(SIGKILL);
    EXPECT_EQ(watch.exit_code(), 128 + SIGKILL);
  }
  const auto rows = run_to_end({kDaemon, "recording", (directory_ / "home.rec").string(), "export", "--jsonl",
                                "--pattern", "proxy.dummy.a.sensor.*.value"});
  EXPECT_EQ(rows.code, 0) << rows.errors;
  std::istringstream text(rows.output);
  double last = 0;
  for (std::string line; std::getline(text, line);) last = json::parse(line)["write"].get<double>();
  const auto lost = std::count_if(seen.begin(), seen.end(), [last](double one) { return one > last; });
  EXPECT_LE(lost, static_cast<std::ptrdiff_t>(kASecond) + 5);
}

}  // namespace
}  // namespace rubicon::daemon
