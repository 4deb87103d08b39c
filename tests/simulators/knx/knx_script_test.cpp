#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "apps/simulators/knx/script.h"

namespace rubicon::knx_simulator {
namespace {

using namespace std::chrono_literals;
using namespace networks::knx::wire;
using ::testing::HasSubstr;
using ::testing::SizeIs;

std::string error_of(std::string_view text) {
  const auto script = parse_script(text);
  return script ? "none" : script.error().text;
}

TEST(KnxScript, ReadsGroupsAndSteps) {
  const auto script = parse_script(
      "# a bus\n"
      "group 1/0/1 1.001 off state 1/0/2\n"
      "\n"
      "at 2s write 1/2/7 21.5  # warmer\n"
      "group 1/2/7 9.001 21 every 5s noise 0.2 wave 20 22 over 2min write-only\n"
      "at 1s ramp 1/2/7 20 24 over 1min\n");
  ASSERT_TRUE(script) << script.error().text;
  ASSERT_THAT(script->groups, SizeIs(3));
  EXPECT_EQ(to_string(*script->groups[0].state), "1/0/2");
  const auto& sensor = script->groups[1];
  EXPECT_EQ(to_string(sensor.type->id), "9.001");
  EXPECT_EQ(sensor.every, 5s);
  EXPECT_EQ(sensor.period, 2min);
  EXPECT_EQ(sensor.noise, 0.2);
  EXPECT_EQ(sensor.low, 20);
  EXPECT_EQ(sensor.high, 22);
  EXPECT_FALSE(sensor.readable);
  EXPECT_EQ(to_string(script->groups[2].address), "1/0/2") << "the state address has a device too";
  ASSERT_THAT(script->steps, SizeIs(2));
  EXPECT_EQ(script->steps[0].kind, Step::Kind::kRamp);
  EXPECT_EQ(script->steps[0].line, 6);
  EXPECT_EQ(script->steps[1].value, (Payload{{0x0c, 0x33}, false}));
}

TEST(KnxScript, NamesTheLineAndWhatWasExpected) {
  EXPECT_THAT(error_of("\ngroup 1/0/1\n"), HasSubstr("line 2: expected 'group GROUP DPT VALUE"));
  EXPECT_THAT(error_of("group 99/0/1 1.001 off"), HasSubstr("line 1: "));
  EXPECT_THAT(error_of("group 1/0/1 900.1 off"), HasSubstr("expected a data point type"));
  EXPECT_THAT(error_of("group 1/0/1 1.001 blue"), HasSubstr("line 1: "));
  EXPECT_THAT(error_of("group 1/0/1 1.001 off\ngroup 1/0/1 1.001 on"), HasSubstr("line 2: 1/0/1 is listed twice"));
  for (const auto* options : {"state 1/0/1", "state", "every 0s", "every", "noise -1", "wave 1 2", "wave 1 2 over 0s",
                              "often", "wave 1 2 within 1s"})
    EXPECT_THAT(error_of(std::string("group 1/0/1 1.001 off ") + options), HasSubstr("expected 'group")) << options;
  EXPECT_THAT(error_of("group 1/0/1 1.001 off every 1s noise 1"), HasSubstr("number type"));
  EXPECT_THAT(error_of("group 1/0/1 9.001 1 noise 1"), HasSubstr("every SPAN"));
  EXPECT_THAT(error_of("at 1s write 1/0/1 on"), HasSubstr("line 1: 1/0/1: expected a group address that has a line"));
  EXPECT_THAT(error_of("group 1/0/1 1.001 off\nat 1s write 1/0/1 7"), HasSubstr("line 2: "));
  EXPECT_THAT(error_of("group 1/0/1 1.001 off\nat 1s ramp 1/0/1 1 2 over 1s"), HasSubstr("a number type"));
  EXPECT_THAT(error_of("at 1s silence 0s"), HasSubstr("at least 1ms"));
  EXPECT_THAT(error_of("at 0s repeat"), HasSubstr("at least 1ms"));
  EXPECT_THAT(error_of("at 1s shout"), HasSubstr("'at SPAN write GROUP VALUE'"));
}

TEST(KnxScript, TheExampleIsOne) {
  std::ifstream file(RUBICON_SOURCE_DIR "/examples/knx.script", std::ios::binary);
  const auto script = parse_script(std::string{std::istreambuf_iterator<char>(file), {}});
  ASSERT_TRUE(script) << script.error().text;
  EXPECT_EQ(script->groups.size(), 8U);
}

}  // namespace
}  // namespace rubicon::knx_simulator
