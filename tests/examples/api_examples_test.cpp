#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "examples/demo_island.h"

namespace rubicon::examples {
namespace {

using nlohmann::json;

/// The fenced block of docs/api.md in this language.
std::string block_of_api(const std::string& language) {
  std::ifstream stream(RUBICON_SOURCE_DIR "/docs/api.md", std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  const auto begin = text.find("```" + language + "\n");
  if (begin == text.npos) return {};
  const auto code = text.find('\n', begin) + 1;
  return text.substr(code, text.find("```", code) - code);
}

/// What a program of Python's standard library, whose beginning is the example, prints: a JSON value a line.
std::vector<json> printed_by_python(const DemoIsland& demo, const std::string& calls) {
  std::ofstream(demo.folder() / "api.py") << block_of_api("python") << calls;
  const auto outcome = support::run_to_end(demo.command("python3 api.py", 60));
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  std::vector<json> values;
  std::istringstream lines(outcome.output);
  for (std::string line; std::getline(lines, line);) values.push_back(json::parse(line, nullptr, false));
  return values;
}

/// The JavaScript is run in a browser: tests/web/api_examples_test.mjs. The lines with curl are run with all others.
TEST(ApiExamples, ThePythonListsDevicesAndReturnsTheOutcomeOfACommand) {
  const DemoIsland demo;
  if (!demo.reason().empty()) GTEST_SKIP() << demo.reason();
  if (support::run_to_end({"/bin/sh", "-c", "command -v python3"}).code != 0) GTEST_SKIP() << "there is no python3";
  ASSERT_NE(block_of_api("python"), "");
  const auto printed = printed_by_python(demo, R"(
lamp = "proxy.dummy-rooms.living.actuator.lamp-1.command"
print(json.dumps([device["key"] for device in devices(network="dummy-rooms", limit=1)]))
print(json.dumps(command(6541, lamp, "on")))
print(json.dumps(command(6541, lamp, "purple")))
)");
  ASSERT_EQ(printed.size(), 3U);
  EXPECT_THAT(printed[0], testing::Contains("proxy.dummy-rooms.living"));
  EXPECT_GT(printed[0].size(), 1U) << "several pages";
  EXPECT_EQ(printed[1]["state"], "confirmed") << printed[1];
  EXPECT_EQ(printed[2]["state"], "refused");
  EXPECT_EQ(printed[2]["error"]["code"], "invalid") << printed[2];
}

}  // namespace
}  // namespace rubicon::examples
