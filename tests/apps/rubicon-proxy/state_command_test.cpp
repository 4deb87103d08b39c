#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "state/state_support.h"
#include "support/process.h"
#include "support/programs.h"

namespace rubicon::daemon {

using namespace support;

namespace {

using testing::HasSubstr;

Outcome state(const std::string& file, std::vector<std::string> rest, const std::string& input = {}) {
  std::vector<std::string> arguments{kDaemon, "state", file};
  arguments.insert(arguments.end(), rest.begin(), rest.end());
  return run_to_end(arguments, input);
}

TEST(StateCommand, ShowsExportsImportsAndForgetsFromTheCommandLine) {
  state::Folder folder;
  ASSERT_TRUE(state::opened(folder / "s")->save(state::device_of("wsn-1", "7")));
  const auto exported = state(folder / "s", {"export"});
  EXPECT_EQ(exported.code, 0) << exported.errors;
  const auto imported = state(folder / "copy", {"import"}, exported.output);
  EXPECT_EQ(imported.code, 0) << imported.errors;
  EXPECT_EQ(state(folder / "copy", {"export"}).output, exported.output);
  EXPECT_THAT(state(folder / "copy", {"show"}).output, HasSubstr("wsn-1/7"));
  EXPECT_EQ(state(folder / "copy", {"forget", "wsn-1/7"}).code, 0);
  EXPECT_EQ(state::opened(folder / "copy")->stats().devices, 0U);
  EXPECT_EQ(state(folder / "none", {"show"}).code, 1);
  EXPECT_EQ(state(folder / "s", {}).code, 2);
}

}  // namespace
}  // namespace rubicon::daemon
