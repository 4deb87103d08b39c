#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "apps/rubicon/live_island.h"

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

}  // namespace
}  // namespace rubicon::cli
