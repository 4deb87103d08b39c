#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>

#include "support/programs.h"
#include "support/terminal.h"

namespace rubicon::daemon {

using namespace support;

namespace {

using testing::HasSubstr;
using testing::Not;

/// `run` on a terminal: thirty rooms, and motes whose sink is not there, of which the log complains.
class LiveScreen : public testing::Test {
 protected:
  LiveScreen() {
    std::string text =
        "island: {id: 6541, name: home}\ntuples: {engine: memory}\nnetworks:\n"
        "  wsn-1: {type: wsn, source: \"network@127.0.0.1:1\", board: EM1000}\n"
        "  dummy-1:\n    type: dummy\n    simulate:\n";
    for (int i = 0; i < 30; ++i) text += "      room" + std::to_string(i) + ": {actuators: {lamp-1: {}}}\n";
    std::ofstream(file_) << text;
    terminal_ = std::make_unique<Terminal>(std::vector<std::string>{kDaemon, "run", file_}, 24, 80);
  }
  ~LiveScreen() override { std::filesystem::remove(file_); }

  /// Title, heads, table, proposal, answer and prompt, and nothing else.
  bool is_whole() const {
    const auto rows = terminal_->rows();
    return rows.front().starts_with("Rubicon island 6541 home") && rows[1].starts_with("DEVICE") &&
           rows[rows.size() - 3].starts_with(" try: ") && rows.back().starts_with(">");
  }

  const std::string file_ =
      (std::filesystem::temp_directory_path() / ("rubicon_screen_" + std::to_string(::getpid()) + ".yaml")).string();
  std::unique_ptr<Terminal> terminal_;
};

TEST_F(LiveScreen, FillsTheTerminalScrollsAndFilters) {
  auto& terminal = *terminal_;
  ASSERT_TRUE(terminal.shows("room0")) << terminal.text();
  EXPECT_TRUE(is_whole()) << terminal.text();
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
  ASSERT_TRUE(terminal.shows("try: set proxy.dummy-1.room0.actuator.lamp-1.command on"));
  terminal.type("set proxy.dummy-1.room0.actuator.lamp-1.command on\r");
  EXPECT_TRUE(terminal.shows("confirmed")) << terminal.text();
  EXPECT_TRUE(terminal.shows([&] {  // in an answer of two rows
    const auto rows = terminal.rows();
    return (rows[rows.size() - 3] + rows[rows.size() - 2]).find("\"verdict\":\"applied\"") != std::string::npos;
  })) << terminal.text();
  terminal.type("quit\r");
  EXPECT_EQ(terminal.exit_code(), 0);
  EXPECT_TRUE(terminal.is_as_before());
  EXPECT_THAT(terminal.bytes(), HasSubstr("\x1b[?1049l"));
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

TEST_F(LiveScreen, TheLogIsNotWrittenIntoTheTable) {
  auto& terminal = *terminal_;
  ASSERT_TRUE(terminal.shows(" warning")) << terminal.text();  // the title counts them
  EXPECT_TRUE(is_whole()) << terminal.text();
  EXPECT_THAT(terminal.bytes(), Not(HasSubstr("wsn-1: ")));
  terminal.type("!");
  EXPECT_TRUE(terminal.shows("wsn-1: ")) << terminal.text();
  terminal.signal(SIGTERM);
  EXPECT_EQ(terminal.exit_code(), 0);
  const auto left = terminal.bytes().substr(terminal.bytes().rfind("\x1b[?1049l"));
  EXPECT_THAT(left, HasSubstr("wsn-1: "));  // what was worth a warning stands there afterwards
}

}  // namespace
}  // namespace rubicon::daemon
