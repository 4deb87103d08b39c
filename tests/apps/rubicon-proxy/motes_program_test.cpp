#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "support/conversation.h"
#include "support/process.h"
#include "support/programs.h"

namespace rubicon::daemon {

using namespace support;

namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

/// The program motes-simulator by itself.
class MotesProgram : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              ("rubicon_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return path(name);
  }
  std::string content(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  static Outcome motes(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), kMotes);
    return run_to_end(std::move(arguments));
  }
  static std::size_t count(const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (auto at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++found;
    return found;
  }

  std::filesystem::path folder_;
};

TEST_F(MotesProgram, SaysWhatIsWrongWithItsArguments) {
  EXPECT_EQ(motes({"--help"}).code, 0);
  EXPECT_EQ(motes({"--version"}).code, 0);
  for (const auto& bad : std::vector<std::vector<std::string>>{{"--nonsense"},
                                                               {"--motes", "many"},
                                                               {"--loss", "2"},
                                                               {"--board", "tree"},
                                                               {"--delay", "soon"},
                                                               {"--motes", "1000", "--sinks", "1000"},
                                                               {"--port", "65535", "--sinks", "2"},
                                                               {"--listen", "here"},
                                                               {"--for", "1s"},
                                                               {"--fast", "--for", "long"},
                                                               {"--fast", "--report", "2min"},
                                                               {"--fast", "--wait"},
                                                               {"--fast", "--pty", path("pty")},
                                                               {"--pty", path("pty"), "--wait"},
                                                               {"--script", path("nowhere")}}) {
    const auto run = motes(bad);
    EXPECT_EQ(run.code, 2) << bad[0] << " " << bad[1 % bad.size()];
    EXPECT_NE(run.errors, "") << bad[0];
  }
}

TEST_F(MotesProgram, ChecksItsScriptAgainstItsWorld) {
  for (const auto& [script, said] : std::vector<std::pair<std::string, std::string>>{
           {"# one\nat 1s explode 2\n", "script: line 2: "},
           {"at 1s kill 6\nat 1s kill 7\n", "script: line 2: there is no mote 7, expected one of 2 to 6"},
           {"at 1s sink-reboot 2\n", "script: line 1: there is no sink 2, expected 1 to 1"},
           {"at 1s repeat\nat 2s kill 2\n", "script: line 2: is never reached"}}) {
    const auto run = motes({"--script", write("script", script), "--port", "0"});
    EXPECT_EQ(run.code, 2) << script;
    EXPECT_THAT(run.errors, HasSubstr(said));
  }
}

TEST_F(MotesProgram, RecordsAndTellsAsFastAsItCanTheSameEachTime) {
  for (const std::string run : {"1", "2"}) {
    const auto done =
        motes({"--fast", "--for", "1min", "--motes", "3", "--script", write("script", "at 30s reboot 3\n"), "--record",
               path("log" + run), "--events", path("events" + run)});
    EXPECT_EQ(done.code, 0) << done.errors;
    EXPECT_EQ(done.output, "");
  }
  const auto log = content("log1");
  EXPECT_GT(log.size(), 20000u) << "three reports a second";
  EXPECT_EQ(log, content("log2"));
  const auto events = content("events1");
  EXPECT_EQ(events, content("events2"));
  EXPECT_EQ(count(events, "\"boot\""), 4u);
  EXPECT_EQ(count(events, "\"listed\""), 4u);
  for (std::istringstream lines(events); lines.good();) {
    std::string line;
    if (!std::getline(lines, line)) break;
    EXPECT_TRUE(json::parse(line, nullptr, false).is_object()) << line;
  }
  EXPECT_EQ(motes({"--fast", "--for", "1s", "--record", path("log1")}).code, 0);
  EXPECT_GT(content("log1").size(), log.size()) << "put behind it";
  const auto other = motes({"--fast", "--for", "1s", "--record", path("events1")});
  EXPECT_EQ(other.code, 2) << "no LOG file";
  EXPECT_EQ(content("events1"), events);
}

TEST_F(MotesProgram, ListensTellsAndEndsWellWithASignal) {
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
    Process world({kMotes, "--port", "0", "--sinks", "2", "--motes", "1", "--events", "-", "--record", path("log")});
    EXPECT_TRUE(world.line_with("sink 1: network@127.0.0.1:")) << world.errors();
    EXPECT_TRUE(world.line_with("sink 2: network@127.0.0.1:")) << world.errors();
    EXPECT_TRUE(world.line_with("\"listed\",\"sink\":2,\"mote\":3")) << world.errors();
    world.signal(signal);
    EXPECT_EQ(world.exit_code(), 0) << signal << world.errors();
  }
  EXPECT_GT(content("log").size(), 100u);
}

TEST_F(MotesProgram, FailsWhereAPortIsTaken) {
  Process first({kMotes, "--port", "0", "--motes", "0"});
  const auto line = first.line();
  ASSERT_TRUE(line) << first.errors();
  const auto port = line->substr(line->rfind(':') + 1);
  const auto second = motes({"--port", port});
  EXPECT_EQ(second.code, 1);
  EXPECT_THAT(second.errors, AllOf(HasSubstr(port), HasSubstr("in use")));
}

TEST_F(MotesProgram, MakesAPseudoTerminalAndTakesItAway) {
  Process world({kMotes, "--pty", path("sink"), "--sinks", "2", "--motes", "0"});
  EXPECT_TRUE(world.line_with("sink 1: serial@" + path("sink") + ":115200")) << world.errors();
  EXPECT_TRUE(world.line_with("sink 2: serial@" + path("sink-2") + ":115200")) << world.errors();
  EXPECT_TRUE(std::filesystem::is_character_file(path("sink-2")));
  world.signal(SIGTERM);
  EXPECT_EQ(world.exit_code(), 0);
  EXPECT_FALSE(std::filesystem::exists(std::filesystem::symlink_status(path("sink"))));
}

TEST_F(MotesProgram, FailsWhenEventsOrRecordsWereLost) {
  if (std::filesystem::exists("/dev/full")) {
    EXPECT_EQ(run_to_end({"sh", "-c", kMotes + " --fast --for 5s --events - > /dev/full"}).code, 1);
  }
  // As on a full disk: no byte can be written to a file.
  const auto full = [](const std::string& call) {
    return std::vector<std::string>{"sh", "-c", "trap '' XFSZ; ulimit -f 0; exec " + kMotes + " " + call};
  };
  for (const std::string flag : {"--events", "--record"}) {
    const auto fast = run_to_end(full("--fast --for 5s " + flag + " " + path("full")));
    EXPECT_EQ(fast.code, 1) << flag;
    EXPECT_EQ(count(fast.errors, "\n"), 1U) << "said once: " << fast.errors;
  }
  // Its first event comes before its port is told.
  Process live(full("--port 0 --events " + path("full") + " --script " + write("script", "at 0s reboot 2\n")));
  ASSERT_TRUE(live.line_with("sink 1")) << live.errors();
  live.signal(SIGTERM);
  EXPECT_EQ(live.exit_code(), 1);
  EXPECT_THAT(live.errors(), HasSubstr(path("full")));
}

TEST_F(MotesProgram, ShowsTheBugOfRepliesToAllWhereThatIsSwitchedOn) {
  const std::vector<std::string> call{"--fast",         "--for", "10s",      "--motes", "30",
                                      "--boot-spacing", "0ms",   "--events", "-"};
  const auto one = motes(call);
  auto with = call;
  with.push_back("--reply-to-all");
  const auto all = motes(with);
  EXPECT_EQ(one.code + all.code, 0);
  EXPECT_GT(count(one.output, "\"listed\""), 0u);
  EXPECT_LT(count(all.output, "\"listed\""), count(one.output, "\"listed\""));
}

}  // namespace
}  // namespace rubicon::daemon
