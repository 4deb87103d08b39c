#include "apps/simulators/zigbee/script.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

namespace rubicon::zigbee_simulator {
namespace {

using namespace std::chrono_literals;
using Kind = Step::Kind;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

std::string error_of(std::string_view text) {
  const auto script = parse_script(text);
  return script ? "none" : script.error().text;
}

TEST(ZigbeeScript, ReadsDevicesGroupsAndSteps) {
  const auto script = parse_script(
      "# a flat\n"
      "device lamp kitchen/ceiling%20lamp every 5s\n"
      "at 2s set kitchen/ceiling%20lamp state ON   # another client\n"
      "device random x\n"
      "group 7 lamps x\n"
      "at 1s say bridge/devices [{\n"
      "at 3s rename x y\n"
      "at 4s delay y 2s\n");
  ASSERT_TRUE(script) << script.error().text;
  ASSERT_THAT(script->devices, SizeIs(2));
  EXPECT_EQ(script->devices[0].name, "kitchen/ceiling lamp");
  EXPECT_EQ(script->devices[0].every, Duration(5s));
  EXPECT_THAT(script->groups[0].members, ElementsAre("x"));
  ASSERT_THAT(script->steps, SizeIs(4));
  EXPECT_EQ(script->steps[0].kind, Kind::kSay);
  EXPECT_EQ(script->steps[0].line, 6);
  EXPECT_EQ(script->steps[1].name, "kitchen/ceiling lamp");
  EXPECT_EQ(script->steps[1].text, "ON");
  EXPECT_EQ(script->steps[3].span, Duration(2s));
}

TEST(ZigbeeScript, ValuesAreJsonOrWords) {
  EXPECT_EQ(value_of_word("21.5"), 21.5);
  EXPECT_EQ(value_of_word("true"), true);
  EXPECT_EQ(value_of_word("ON"), "ON");
  EXPECT_EQ(value_of_word(R"({"x":0.3})")["x"], 0.3);
}

TEST(ZigbeeScript, SaysWhichLineIsWrong) {
  for (const auto* wrong : {"device", "device toaster x", "device lamp", "device lamp x every",
                            "device lamp x every 0s", "group 0 a", "group a b", "dance", "at 1s set lamp state",
                            "at 1s set absent state ON", "at 1s fault lamp sulk", "at 1s join toaster", "at 1s burst 0",
                            "at 1s burst 5000", "at 1s stop 0s", "at 0s repeat", "at 1s delay lamp x"}) {
    EXPECT_THAT(error_of(std::string("device lamp lamp\n") + wrong), HasSubstr("line 2: ")) << wrong;
  }
  EXPECT_THAT(error_of("group 1 lamps absent"), HasSubstr("absent"));
  EXPECT_THAT(error_of("device lamp lamp\nat 1s fault lamp sulk"), HasSubstr("'at SPAN fault NAME FAULT'"));
  EXPECT_THAT(error_of("device toaster x"), HasSubstr("random or one of lamp, plug"));
}

TEST(ZigbeeScript, TheExampleCanBeRead) {
  std::ifstream file(RUBICON_SOURCE_DIR "/examples/zigbee.script");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto script = parse_script(text);
  ASSERT_TRUE(script) << script.error().text;
  EXPECT_GT(script->devices.size(), 5U);
}

}  // namespace
}  // namespace rubicon::zigbee_simulator
