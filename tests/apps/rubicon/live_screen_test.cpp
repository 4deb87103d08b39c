#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>

#include <algorithm>
#include <csignal>
#include <memory>

#include "apps/rubicon/live_island.h"
#include "support/terminal.h"
#include "transport/descriptor_watch.h"

namespace rubicon::cli {
namespace {

using support::Terminal;
using testing::HasSubstr;
using testing::Not;

/// `rubicon top` on a terminal, beside an island with thirty rooms, and motes whose sink is not there, of which the log
/// complains.
class LiveScreen : public testing::Test {
 protected:
  LiveScreen() {
    if (!alone_.entered()) return;
    std::string text =
        "island: {id: 6541, name: home}\nnetworks:\n"
        "  wsn-1: {type: wsn, source: \"network@127.0.0.1:1\", board: EM1000}\n"
        "  dummy-1:\n    type: dummy\n    simulate:\n";
    for (int i = 0; i < 30; ++i) text += "      room" + std::to_string(i) + ": {actuators: {lamp-1: {}}}\n";
    text +=
        "      attic: {sensors: {temperature-1: {wave: constant, value: 21.5}}, actuators: {switch-1: {behaviour: "
        "ignore}}}\n";
    file_ = folder_.write("screen.yaml", text);
    island_ = started(file_);
    show({});
  }
  void show(std::vector<std::string> options) {
    options.insert(options.begin(), {kProgram, "top"});
    terminal_ = std::make_unique<Terminal>(std::move(options), 24, 80);
  }
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
  }

  /// Title, heads, table, proposal, answer and prompt, and nothing else.
  bool is_whole() const {
    const auto rows = terminal_->rows();
    return rows.front().starts_with("Rubicon island 6541 home") && rows[1].starts_with("DEVICE") &&
           rows[rows.size() - 3].starts_with(" try: ") && rows.back().starts_with(">");
  }

  const PrivateNetwork alone_;
  const Folder folder_;
  std::string file_;
  std::unique_ptr<Process> island_;
  std::unique_ptr<Terminal> terminal_;
};

TEST_F(LiveScreen, FillsTheTerminalScrollsAndFilters) {
  auto& terminal = *terminal_;
  ASSERT_TRUE(terminal.shows("room0")) << terminal.text();
  EXPECT_TRUE(terminal.shows([&] { return is_whole(); })) << terminal.text();
  EXPECT_FALSE(terminal.is_as_before());
  terminal.type("\x1b[F");  // End
  EXPECT_TRUE(terminal.shows("room29")) << terminal.text();
  terminal.type("\x1b[H/room17\r");
  EXPECT_TRUE(terminal.shows([&] {
    return terminal.text().find("room17") != std::string::npos && terminal.text().find("room0 ") == std::string::npos;
  })) << terminal.text();
  terminal.type("\x1b");
  EXPECT_TRUE(terminal.shows("room0"));
}

TEST_F(LiveScreen, ALineIsTypedAndAnsweredAndTheTerminalGivenBack) {
  auto& terminal = *terminal_;
  ASSERT_TRUE(terminal.shows("try: set dummy-1.attic.switch-1 on")) << terminal.text();
  terminal.type("set room0.lamp-1 on\r");
  EXPECT_TRUE(terminal.shows("6541:proxy.dummy-1.room0.actuator.lamp-1.command confirmed after ")) << terminal.text();
  terminal.type("get room0.lamp-1 room1.lamp-1 --any-quality --quiet\r");
  EXPECT_TRUE(terminal.shows("6541:proxy.dummy-1.room0.actuator.lamp-1.value on")) << terminal.text();
  terminal.type("doctr\r");
  EXPECT_TRUE(terminal.shows("unknown command 'doctr'; did you mean 'doctor'?")) << terminal.text();
  for (const auto* line : {"watch", "top", "doctor", "publish a b"}) {
    terminal.type(std::string(line) + "\r");
    EXPECT_TRUE(terminal.shows("this command needs a terminal of its own")) << line << terminal.text();
    terminal.type("get --json a\r");
    EXPECT_TRUE(terminal.shows("--json belongs to")) << terminal.text();
  }
  terminal.type("q");
  EXPECT_EQ(terminal.exit_code(), 0);
  EXPECT_TRUE(terminal.is_as_before());
  EXPECT_THAT(terminal.bytes(), HasSubstr("\x1b[?1049l"));
}

TEST_F(LiveScreen, ACommandThatFailsIsAnsweredInWordsWithItsReason) {
  auto& terminal = *terminal_;
  ASSERT_TRUE(terminal.shows("room0")) << terminal.text();
  terminal.resize(24, 160);
  terminal.type("set attic.switch-1 maybe\r");
  EXPECT_TRUE(terminal.shows("command refused after ")) << terminal.text();
  EXPECT_THAT(terminal.text(), HasSubstr(": switch: 'maybe' is not one of off, on"));
  terminal.type("set attic.switch-1 on\r");
  EXPECT_TRUE(terminal.shows("command timed-out after ")) << terminal.text();
  EXPECT_THAT(terminal.text(), HasSubstr(" s: no report of the device within 5 s"));
  EXPECT_THAT(terminal.text(), Not(HasSubstr("{\""))) << "no JSON";
}

TEST_F(LiveScreen, ASignalEndsACommandThatWaitsAndTheTable) {
  auto& terminal = *terminal_;
  ASSERT_TRUE(terminal.shows("room0")) << terminal.text();
  terminal.type("set attic.switch-1 on\r");
  EXPECT_TRUE(terminal.shows("sent: ")) << terminal.text();  // what it waits for
  terminal.type("\x03");
  EXPECT_EQ(terminal.exit_code(), 0);
  EXPECT_TRUE(terminal.is_as_before());
}

TEST_F(LiveScreen, AnIslandThatLeavesIsAbsentUntilItIsBack) {
  auto& terminal = *terminal_;
  ASSERT_TRUE(terminal.shows("room0")) << terminal.text();
  island_.reset();
  EXPECT_TRUE(terminal.shows("Rubicon island 6541 is absent")) << terminal.text();
  island_ = started(file_);
  EXPECT_TRUE(terminal.shows("Rubicon island 6541 home   31 of 31 devices")) << terminal.text();
}

TEST_F(LiveScreen, AResizeLeavesNothingBehind) {
  auto& terminal = *terminal_;
  ASSERT_TRUE(terminal.shows("room0"));
  for (const auto& [rows, columns] : {std::pair{40, 120}, std::pair{12, 60}, std::pair{24, 80}}) {
    terminal.resize(rows, columns);
    EXPECT_TRUE(terminal.shows([&] { return is_whole(); })) << terminal.text();
    const auto shown = terminal.rows();
    EXPECT_EQ(std::count_if(shown.begin(), shown.end(), [](const auto& row) { return row.starts_with(" try: "); }), 1)
        << terminal.text();
  }
}

TEST_F(LiveScreen, ShowsTheLogOfTheIsland) {
  auto& terminal = *terminal_;
  ASSERT_TRUE(terminal.shows(" warning")) << terminal.text();  // the title counts them
  EXPECT_TRUE(terminal.shows([&] { return is_whole(); })) << terminal.text();
  EXPECT_THAT(terminal.bytes(), Not(HasSubstr("wsn-1: ")));
  terminal.type("!");
  EXPECT_TRUE(terminal.shows("wsn-1: ")) << terminal.text();
}

TEST_F(LiveScreen, WakesSensorsUnlessItIsPassive) {
  terminal_.reset();
  island_.reset();  // what was shown so far may have measured already
  island_ = started(file_);
  show({"--passive"});
  terminal_->type("/attic\r");
  ASSERT_TRUE(terminal_->shows("temperature-1")) << terminal_->text();
  for (const auto* state : {"on", "off", "on"}) {
    terminal_->type(std::string("set room0.lamp-1 ") + state + "\r");
    EXPECT_TRUE(terminal_->shows("confirmed after")) << terminal_->text();
    terminal_->type("get room1.lamp-1 --quiet --all\r");
    EXPECT_TRUE(terminal_->shows("quality    unknown")) << terminal_->text();
  }
  EXPECT_THAT(terminal_->text(), Not(HasSubstr("21.5")));
  show({});
  terminal_->type("/attic\r");
  EXPECT_TRUE(terminal_->shows("21.5")) << terminal_->text();
}

TEST_F(LiveScreen, RatesArePrintedBelowEachOtherWhereTheyAreAskedFor) {
  show({"--rounds", "2", "--interval", "100ms"});
  EXPECT_EQ(terminal_->exit_code(), 0);
  const auto& bytes = terminal_->bytes();
  EXPECT_NE(bytes.find("PER SECOND"), bytes.rfind("PER SECOND")) << bytes;
  EXPECT_THAT(bytes, Not(HasSubstr("\x1b[H")));
}

/// `./run` in a copy of its folder in which nothing has to be built.
class TheDemo : public testing::Test {
 protected:
  TheDemo() {
    namespace fs = std::filesystem;
    const fs::path source(RUBICON_SOURCE_DIR);
    fs::create_directories(root_ / "build/release");
    fs::create_directories(root_ / "scripts");
    fs::create_directory_symlink(RUBICON_BINARY_DIR "/bin", root_ / "build/release/bin");
    fs::create_directory_symlink(source / "examples", root_ / "examples");
    fs::copy_file(source / "run", root_ / "run");
    std::ofstream(root_ / "scripts/common.sh") << "root=" << root_.string() << R"(
say() { printf '[run] %s\n' "$*" >&2; }
apart() { exec setsid "$@"; }
install_missing() { :; }
expect_minutes() { :; }
build() { :; }
)";
  }
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    ASSERT_EQ(::flock(turn_.get(), LOCK_EX), 0);
  }

  /// Command lines of programs that were started there.
  std::string left() const {
    std::string all;
    for (const auto& process : std::filesystem::directory_iterator("/proc")) {
      std::ifstream file(process.path() / "cmdline");
      const std::string line(std::istreambuf_iterator<char>(file), {});
      if (line.find(root_.string() + "/build") != line.npos) all += line.substr(0, 200) + "\n";
    }
    return all;
  }

  const PrivateNetwork alone_;
  const Folder folder_;
  const std::filesystem::path root_ = folder_.file("demo");
  /// One demo at a time writes where it is beside the programs, which all test programs share.
  const transport::OwnDescriptor turn_{::open(RUBICON_BINARY_DIR "/demo.turn", O_RDWR | O_CREAT | O_CLOEXEC, 0600)};
};

TEST_F(TheDemo, IsATableWhoseEndEndsEverything) {
  for (const auto* key : {"q", "\x03"}) {
    Terminal terminal({"bash", (root_ / "run").string()}, 30, 120);
    ASSERT_TRUE(terminal.shows("Rubicon island 6541 home")) << terminal.text();
    ASSERT_TRUE(terminal.shows("dummy-rooms")) << terminal.text();
    EXPECT_THAT(left(), HasSubstr("rubicon-proxy"));
    terminal.type(key);
    EXPECT_EQ(terminal.exit_code(), 0) << terminal.text();
    EXPECT_TRUE(terminal.is_as_before());
    EXPECT_EQ(left(), "");
    const auto after = terminal.bytes().substr(terminal.bytes().rfind("\x1b[?1049l"));
    EXPECT_THAT(after, Not(HasSubstr("warning")));
  }
}

TEST_F(TheDemo, HasWhatAHouseHasAfterAWhile) {
  Process run({"env", "-u", "RUBICON_FOLDER", "bash", (root_ / "run").string(), "--watch", "proxy.networks"});
  ASSERT_TRUE(run.line_with("proxy.networks")) << run.errors();
  const auto in_demo = [](std::vector<std::string> words) {
    words.insert(words.begin(), {"env", "-u", "RUBICON_FOLDER", kProgram});
    return support::run_to_end(std::move(words)).output;
  };
  const auto shows = [&](const std::vector<std::string>& words, const std::string& part) {
    std::string shown;
    for (int i = 0; i < 100 && shown.find(part) == shown.npos; ++i) shown = in_demo(words);
    EXPECT_THAT(shown, HasSubstr(part));
  };
  for (const auto* device : {"dummy-new.guest", "dummy-new.stranger"}) shows({"inbox"}, device);
  shows({"recorder"}, "demo");
  shows({"history", "log-flat.kitchen.temperature-1", "--from", "20h", "--to", "19h", "--csv"},
        "proxy.log-flat.kitchen.sensor.temperature-1.value");
  shows({"devices", "--area", "Living room", "--json"}, "dummy-rooms");
  const auto second = support::run_to_end({"env", "-u", "RUBICON_FOLDER", "bash", (root_ / "run").string()});
  EXPECT_EQ(second.code, 1);
  EXPECT_THAT(second.errors, AllOf(HasSubstr("the demo runs already, and its page is http://127.0.0.1:86"),
                                   HasSubstr("bin/rubicon top"), HasSubstr("--set island.id=6542")));
  run.signal(SIGTERM);
  EXPECT_EQ(run.exit_code(), 0);
  EXPECT_EQ(left(), "");
}

TEST_F(TheDemo, SaysWhyItsIslandDoesNotStart) {
  Terminal terminal({"bash", (root_ / "run").string(), "--set", "island.id=0"}, 30, 120);
  EXPECT_EQ(terminal.exit_code(), 2) << terminal.text();
  EXPECT_THAT(terminal.bytes(), HasSubstr("island.id"));
  EXPECT_EQ(left(), "");
}

TEST_F(TheDemo, WithoutATerminalItIsTheIsland) {
  Process run({"env", "-u", "RUBICON_FOLDER", "bash", (root_ / "run").string(), "--watch", "proxy.networks"});
  EXPECT_TRUE(run.line_with("proxy.networks")) << run.errors();
  run.signal(SIGTERM);
  EXPECT_EQ(run.exit_code(), 0);
  EXPECT_EQ(left(), "");
}

}  // namespace
}  // namespace rubicon::cli
