#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>

#include "base/text.h"
#include "support/http_text.h"
#include "support/process.h"
#include "support/programs.h"

namespace rubicon::daemon {

using namespace support;

namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;

/// The island program with a page on a free port.
class IslandPage : public testing::Test {
 protected:
  IslandPage() {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~IslandPage() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return (folder_ / name).string();
  }
  std::string island(const std::string& web) {
    return write("room.yaml", "island: {id: 6541, name: test}\ntuples: {engine: memory}\n" +
                                  (web.empty() ? std::string() : "web: " + web + "\n"));
  }
  /// What follows `open ` in the log, the last time; 0 if it does not come.
  static int port_in(Process& program, std::size_t times = 1) {
    for (int i = 0; i < 6000; ++i) {
      const auto errors = program.errors();
      std::size_t at = 0;
      std::size_t found = 0;
      for (auto next = errors.find("web: open http"); next != errors.npos;
           next = errors.find("web: open http", next + 1)) {
        at = errors.find_last_of(':', errors.find('\n', next));
        ++found;
      }
      if (found >= times)
        return base::parse_number<int>(errors.substr(at + 1, errors.find('\n', at) - at - 1)).value_or(0);
      std::ignore = program.has_settled();
    }
    return 0;
  }
  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("rubicon_island_page_" + std::to_string(::getpid()));
};

const std::string kFreePort = "{listen: \"127.0.0.1:0\"}";

TEST_F(IslandPage, ShowsThePageAndAnswersTheApi) {
  Process program({kDaemon, "run", island(kFreePort)});
  const auto port = port_in(program);
  ASSERT_GT(port, 0) << program.errors();
  EXPECT_THAT(http_text(port, "GET /"), HasSubstr("Content-Type: text/html"));
  EXPECT_THAT(http_text(port, "GET /api/v1"), HasSubstr("\"name\":\"test\""));
  program.signal(SIGTERM);
  EXPECT_EQ(program.exit_code(), 0);
}

TEST_F(IslandPage, WithoutTheSectionNothingListens) {
  Process program({kDaemon, "run", island(""), "--shell"});
  program.write("quit\n");
  EXPECT_EQ(program.exit_code(), 0);
  EXPECT_THAT(program.errors(), Not(HasSubstr("web:")));
}

TEST_F(IslandPage, APortThatIsInUseIsOneWarningAndTheIslandGoesOn) {
  Process first({kDaemon, "run", island(kFreePort)});
  const auto port = port_in(first);
  ASSERT_GT(port, 0);
  Process second({kDaemon, "run", island("{listen: \"127.0.0.1:" + std::to_string(port) + "\"}"), "--shell"});
  second.write("get proxy.networks\n");
  EXPECT_TRUE(second.line());
  second.write("quit\n");
  EXPECT_EQ(second.exit_code(), 0);
  const auto errors = second.errors();
  const auto said = errors.find("Address already in use; the island runs without its page");
  ASSERT_NE(said, errors.npos) << errors;
  EXPECT_EQ(errors.find("warning", errors.find("warning") + 1), errors.npos) << "one warning: " << errors;
}

TEST_F(IslandPage, AReloadOpensClosesAndMovesIt) {
  Process program({kDaemon, "run", island("")});
  const auto up = [&] { return program.errors().find("is up") != std::string::npos; };
  for (int i = 0; i < 6000 && !up(); ++i) std::ignore = program.has_settled();
  island(kFreePort);
  program.signal(SIGHUP);
  const auto port = port_in(program);
  ASSERT_GT(port, 0) << program.errors();
  EXPECT_THAT(http_text(port, "GET /healthz"), HasSubstr("200 OK"));
  island("{listen: \"127.0.0.1:0\", compress: yes}");
  program.signal(SIGHUP);
  const auto other = port_in(program, 2);
  EXPECT_THAT(http_text(other, "GET /healthz"), HasSubstr("200 OK"));
  if (other != port) {
    EXPECT_EQ(http_text(port, "GET /healthz"), "");
  }
}

TEST_F(IslandPage, AReloadReadsTheTokensAgain) {
  write("web.tokens", "");
  Process program({kDaemon, "run", island("{listen: \"127.0.0.1:0\", tokens: {file: web.tokens}}")});
  const auto port = port_in(program);
  ASSERT_GT(port, 0) << program.errors();
  EXPECT_THAT(http_text(port, "GET /metrics"), HasSubstr("401"));
  // printf secret | sha256sum
  write("web.tokens", "viewer:view:2bb80d537b1da3e38bd30361aa855686bde0eacd7162fef6a25fe97bf527a25b\n");
  program.signal(SIGHUP);
  for (int i = 0; i < 6000 && program.errors().find("reloaded") == std::string::npos; ++i)
    std::ignore = program.has_settled();
  EXPECT_THAT(http_text(port, "GET /metrics", "Authorization: Bearer secret\r\n"), Not(HasSubstr("401")))
      << program.errors();
  EXPECT_THAT(http_text(port, "GET /metrics"), HasSubstr("401"));
}

TEST_F(IslandPage, KeepsAndAnswersWhatTheValuesWere) {
  const auto file = island(kFreePort +
                           "\nhistory: {file: home.history, minimum: 100ms}\nnetworks: {dummy-1: {type: dummy, "
                           "simulate: {den: {sensors: {light-1: {}}}}}}");
  const std::string question = "GET /api/v1/history?key=6541:proxy.dummy-1.den.property.rate.value";
  std::string answer;
  {
    Process program({kDaemon, "run", file});
    const auto port = port_in(program);
    ASSERT_GT(port, 0) << program.errors();
    // Five questions a second are allowed.
    const auto has_values = [&] {
      answer = http_text(port, question);
      return answer.find("\"t\":[1") != std::string::npos;
    };
    bool found = false;
    for (int i = 0; i < 30000 && !found; ++i) {
      std::ignore = program.has_settled();
      found = has_values();
    }
    EXPECT_TRUE(found) << answer;
    EXPECT_THAT(http_text(port, "GET /api/v1/tuples/6541/proxy.history.status"), HasSubstr("recording"));
    EXPECT_THAT(http_text(port, "GET /metrics"), HasSubstr("rubicon_history_recording 1\n"));
    program.signal(SIGTERM);
    EXPECT_EQ(program.exit_code(), 0);
  }
  // What was written is there after a restart.
  Process again({kDaemon, "run", file});
  const auto port = port_in(again);
  ASSERT_GT(port, 0) << again.errors();
  const auto lists_it = [&] {
    answer = http_text(port, "GET /api/v1/history/series?pattern=6541:proxy.**");
    return answer.find("\"kind\":\"number\"") != std::string::npos;
  };
  for (int i = 0; i < 6000 && !lists_it(); ++i) std::ignore = again.has_settled();
  EXPECT_THAT(answer, HasSubstr("6541:proxy.dummy-1.den.property.rate.value"));
  again.signal(SIGTERM);
  EXPECT_EQ(again.exit_code(), 0);
  EXPECT_TRUE(std::filesystem::is_regular_file(folder_ / "home.history"));
}

TEST_F(IslandPage, ShowsThatItsHistoryIsNotWritten) {
  std::filesystem::create_directory(folder_ / "home.history");
  Process program({kDaemon, "run", island(kFreePort + "\nhistory: {file: home.history}")});
  const auto port = port_in(program);
  ASSERT_GT(port, 0) << program.errors();
  std::string answer;
  const auto fails = [&] {
    answer = http_text(port, "GET /api/v1/tuples/6541/proxy.history.status");
    return answer.find("failing") != std::string::npos;
  };
  for (int i = 0; i < 6000 && !fails(); ++i) std::ignore = program.has_settled();
  EXPECT_THAT(answer, HasSubstr("not a regular file"));
  program.signal(SIGTERM);
  EXPECT_EQ(program.exit_code(), 0);
}

TEST_F(IslandPage, CheckNamesWhatTheFilesLack) {
  write("web.tokens", "somebody\n");
  const auto path = island(
      "{listen: \"0.0.0.0:0\", tls: {certificate: web.pem, key: web.key}, tokens: {file: web.tokens}, files: page}");
  const auto checked = run_to_end({kDaemon, "check", path});
  EXPECT_EQ(checked.code, 2);
  EXPECT_THAT(checked.errors, HasSubstr("room.yaml:3:"));
  EXPECT_THAT(checked.errors, HasSubstr("web.tls: certificate "));
  EXPECT_THAT(checked.errors, HasSubstr("web.tokens: "));
  EXPECT_THAT(checked.errors, HasSubstr("line 1: expected name:role:hash"));
  EXPECT_THAT(checked.errors, HasSubstr("web.files: there is no folder"));
  EXPECT_EQ(run_to_end({kDaemon, "check", path, "--elsewhere"}).code, 0);
}

TEST_F(IslandPage, WhatOthersReachNeedsTlsAndTokens) {
  const auto checked = run_to_end({kDaemon, "run", island("{listen: \"0.0.0.0:8642\"}")});
  EXPECT_EQ(checked.code, 2);
  EXPECT_THAT(checked.errors, HasSubstr("room.yaml:3:15: web.listen: 0.0.0.0 can be reached by other hosts"));
}

}  // namespace
}  // namespace rubicon::daemon
