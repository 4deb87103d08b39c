#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "apps/rubicon/live_island.h"
#include "base/text.h"
#include "support/http_text.h"

namespace rubicon::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(WebCommand, RefusesAHistoryThatCannotBe) {
  const auto refusal = [](const std::string& option, const std::string& value) {
    const auto ended = rubicon({"web", "--history", "x.history", option, value});
    EXPECT_EQ(ended.code, 2) << option << " " << value;
    return ended.errors;
  };
  EXPECT_THAT(refusal("--raw", "10m"), HasSubstr("expected at least 1h, or never"));
  EXPECT_THAT(refusal("--size", "3"), HasSubstr("expected a size of at least 1MB"));
  EXPECT_THAT(refusal("--exclude", "a..b"), HasSubstr("empty part"));
  EXPECT_THAT(rubicon({"web", "--exclude", "*:**"}).errors, HasSubstr("--exclude requires --history"));
}

TEST(WebCommand, KeepsNothingThatIsExcluded) {
  const PrivateNetwork alone;
  if (!alone.entered()) GTEST_SKIP() << alone.reason();
  const Folder folder;
  const auto file = folder.file("all.history");
  const auto island = started(folder.write(
      "home.yaml",
      "island: {id: 6541, name: home}\ntuples: {engine: dds}\nnetworks:\n  dummy-1: {type: dummy, simulate: "
      "{den: {sensors: {light-1: {}}}, bath: {sensors: {light-1: {}}}}}\n"));
  Process page({kProgram, "web", "--listen", "127.0.0.1:0", "--history", file, "--exclude", "*:proxy.*.bath.**",
                "--raw", "never", "--compress"});
  ASSERT_TRUE(page.line_with("open http://127.0.0.1:")) << page.errors();
  const auto list = [&] { return rubicon({"history", file, "query"}).output; };
  for (int i = 0; i < 200 && list().find(".den.") == std::string::npos; ++i) std::ignore = page.has_settled();
  EXPECT_THAT(list(), HasSubstr(".den."));
  EXPECT_THAT(list(), Not(HasSubstr(".bath.")));
  page.signal(SIGHUP);
  page.signal(SIGHUP);
  page.signal(SIGTERM);
  EXPECT_EQ(page.exit_code(), 0) << page.errors();
}

std::string text_of(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(TokenCommand, PrintsTheTokenOnceAndKeepsItsHash) {
  const Folder folder;
  const auto file = folder.file("web.tokens");
  const auto made = rubicon({"token", "tablet", "--role", "command", "--file", file});
  ASSERT_EQ(made.code, 0) << made.errors;
  const auto token = made.output.substr(0, made.output.find('\n'));
  EXPECT_GE(token.size(), 22U) << "128 random bits";
  EXPECT_THAT(text_of(file), testing::ContainsRegex("^tablet:command:[0-9a-f]+\n$"));
  EXPECT_THAT(text_of(file), Not(HasSubstr(token)));
  EXPECT_EQ(std::filesystem::status(file).permissions() & std::filesystem::perms::others_all,
            std::filesystem::perms::none);
  const auto other = rubicon({"token", "panel", "--file", file, "--json"});
  EXPECT_THAT(other.output, testing::AllOf(HasSubstr(R"("name":"panel")"), HasSubstr(R"("role":"view")")));
  EXPECT_THAT(text_of(file), testing::AllOf(HasSubstr("tablet:command:"), HasSubstr("\npanel:view:")));
}

TEST(TokenCommand, RefusesWhatIsNoTokenAndAFileThatCannotBe) {
  const Folder folder;
  const auto file = folder.file("web.tokens");
  ASSERT_EQ(rubicon({"token", "tablet", "--file", file}).code, 0);
  const auto before = text_of(file);
  const auto twice = rubicon({"token", "tablet", "--role", "admin", "--file", file});
  EXPECT_NE(twice.code, 0);
  EXPECT_THAT(twice.errors, HasSubstr("tablet"));
  EXPECT_NE(rubicon({"token", "a:b", "--file", file}).code, 0);
  EXPECT_EQ(rubicon({"token", "x", "--role", "root", "--file", file}).code, 2);
  EXPECT_EQ(text_of(file), before);
  EXPECT_NE(rubicon({"token", "x", "--file", folder.file("none/web.tokens")}).code, 0);
}

/// `rubicon web` in a network without islands.
class WebProgramTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
  }
  std::string token(const std::string& name, const std::string& role) const {
    const auto made = rubicon({"token", name, "--role", role, "--file", tokens_});
    return made.output.substr(0, made.output.find('\n'));
  }
  /// The port that it says it listens on.
  static int port_of(Process& page) {
    const auto line = page.line_with("open http://127.0.0.1:").value_or("");
    return base::parse_number<int>(line.substr(line.rfind(':') + 1)).value_or(0);
  }
  static std::string status(int port, const std::string& request, const std::string& token = {}) {
    const auto fields = token.empty() ? "" : "Authorization: Bearer " + token + "\r\n";
    return support::http_text(port, request, fields + "Accept-Encoding: gzip\r\n").substr(0, 12);
  }

  PrivateNetwork alone_;
  Folder folder_;
  std::string tokens_ = folder_.file("web.tokens");
};

TEST_F(WebProgramTest, ServesThePageAndItsApiUntilItIsEnded) {
  for (const int signal : {SIGTERM, SIGINT}) {
    Process page({kProgram, "web", "--listen", "127.0.0.1:0"});
    const auto port = port_of(page);
    ASSERT_NE(port, 0) << page.errors();
    EXPECT_EQ(status(port, "GET /"), "HTTP/1.1 200");
    EXPECT_EQ(status(port, "GET /healthz"), "HTTP/1.1 200");
    EXPECT_THAT(support::http_text(port, "GET /api/v1"), HasSubstr(R"("name":"rubicon web")"));
    EXPECT_THAT(support::http_text(port, "GET /api/v1/islands"), HasSubstr(R"("islands":[])"));
    page.signal(signal);
    EXPECT_EQ(page.exit_code(), 0) << page.errors();
    EXPECT_EQ(support::http_text(port, "GET /healthz"), "");
  }
}

TEST_F(WebProgramTest, ReadsItsTokensAgainAtSighup) {
  const auto first = token("first", "view");
  Process page({kProgram, "web", "--listen", "127.0.0.1:0", "--tokens", tokens_});
  const auto port = port_of(page);
  ASSERT_NE(port, 0) << page.errors();
  EXPECT_EQ(status(port, "GET /api/v1"), "HTTP/1.1 401");
  EXPECT_EQ(status(port, "GET /api/v1", first), "HTTP/1.1 200");
  const auto second = token("second", "admin");
  EXPECT_EQ(status(port, "GET /api/v1", second), "HTTP/1.1 401");
  page.signal(SIGHUP);
  for (int i = 0; i < 1000 && status(port, "GET /api/v1", second) != "HTTP/1.1 200"; ++i)
    std::ignore = page.has_settled();
  EXPECT_EQ(status(port, "GET /api/v1", second), "HTTP/1.1 200");
  EXPECT_EQ(status(port, "GET /api/v1", first), "HTTP/1.1 200");
  folder_.write("web.tokens", "nonsense\n");
  page.signal(SIGHUP);
  for (int i = 0; i < 1000 && page.errors().empty(); ++i) std::ignore = page.has_settled();
  EXPECT_THAT(page.errors(), HasSubstr("line 1: expected name:role:hash"));
  EXPECT_EQ(status(port, "GET /api/v1", first), "HTTP/1.1 200") << "those before stay";
  page.signal(SIGTERM);
  EXPECT_EQ(page.exit_code(), 0);
}

TEST_F(WebProgramTest, SaysWhyItCannotServe) {
  Process page({kProgram, "web", "--listen", "127.0.0.1:0"});
  const auto port = port_of(page);
  ASSERT_NE(port, 0) << page.errors();
  const auto taken = rubicon({"web", "--listen", "127.0.0.1:" + std::to_string(port)});
  EXPECT_EQ(taken.code, 1) << taken.errors;
  EXPECT_THAT(taken.errors, HasSubstr(std::to_string(port)));
  EXPECT_EQ(rubicon({"web", "--listen", "hall"}).code, 2);
  const auto open = rubicon({"web", "--listen", "0.0.0.0:0"});
  EXPECT_EQ(open.code, 2);
  EXPECT_THAT(open.errors, HasSubstr("tokens"));
  EXPECT_NE(rubicon({"web", "--listen", "127.0.0.1:0", "--tokens", folder_.file("none")}).code, 0);
}

}  // namespace
}  // namespace rubicon::cli
