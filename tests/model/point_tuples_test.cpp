#include "model/point_tuples.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <ctime>

namespace rubicon::model {
namespace {

WallTime at(double seconds) {
  return WallTime(std::chrono::microseconds(static_cast<std::int64_t>(seconds * 1e6)));
}

TEST(PointTuples, ReadTheStatusOfAPoint) {
  const auto status = point_status_from_json(
      R"({"quality":"stale","since":8,"heard":5.5,"changed":4,"reason":"why","command":{"state":"sent"}})");
  EXPECT_EQ(status, (PointStatus{"stale", "why", at(8), at(5.5), at(4), "sent"}));
}

TEST(PointTuples, WhatIsMissingOrOfAnotherKindIsEmpty) {
  EXPECT_EQ(point_status_from_json("no json"), PointStatus{});
  EXPECT_EQ(point_status_from_json(R"({"quality":7,"heard":"x","since":-1,"changed":1e300,"command":[]})"),
            PointStatus{});
  EXPECT_EQ(line_status_from_json(R"([1])"), LineStatus{});
  EXPECT_EQ(line_status_from_json(R"({"line":null,"attempts":-3,"next_attempt":{}})"), LineStatus{});
  EXPECT_EQ(device_condition_from_json("{}"), DeviceCondition{});
}

/// Recordings and other islands are not trusted: a text of many members must not stop the loop for seconds.
TEST(PointTuples, TextsWithManyMembersAreReadQuickly) {
  std::string text = "{";
  for (int i = 0; i < 30'000; ++i) text += fmt::format("\"{:x}\":0,", i);
  text += R"("type":"light","address":"7","quality":"good","status":"ok","line":"up","command":{"state":"sent"}})";
  const auto start = std::clock();  // of this process, whatever else the machine does
  EXPECT_EQ(point_description_from_json(text)->type, "light");
  EXPECT_EQ(device_description_from_json(text)->address, "7");
  EXPECT_EQ(point_status_from_json(text).quality, "good");
  EXPECT_EQ(command_status_from_json(text)->state, "sent");
  EXPECT_EQ(device_condition_from_json(text).status, "ok");
  EXPECT_EQ(line_status_from_json(text).line, "up");
  EXPECT_LT(std::clock() - start, 5 * CLOCKS_PER_SEC) << "it needs half a second";
}

TEST(PointTuples, TheStatusOfALineSurvivesItsText) {
  const LineStatus down{"down", "no \"server\"", at(1767225600.25), 9, at(1767225630)};
  EXPECT_EQ(line_status_to_json(down),
            R"({"line":"down","since":1767225600.25,"reason":"no \"server\"","attempts":9,"next_attempt":1767225630})");
  EXPECT_EQ(line_status_from_json(line_status_to_json(down)), down);
  auto found = down;
  found.finding = "host-silent";
  EXPECT_EQ(line_status_from_json(line_status_to_json(found)), found);
  EXPECT_FALSE(down.works());
  EXPECT_TRUE((LineStatus{"ended", "", {}, 1, {}}.works()));
}

TEST(PointTuples, TheConditionOfADeviceSurvivesItsText) {
  const DeviceCondition silent{"unreachable", "silent for 60s", at(7)};
  EXPECT_EQ(device_condition_to_json(silent), R"({"status":"unreachable","since":7,"reason":"silent for 60s"})");
  EXPECT_EQ(device_condition_from_json(device_condition_to_json(silent)), silent);
}

TEST(PointTuples, AStatusIsReadAsItWasWritten) {
  const CommandStatus sent{"superseded",   {OwnerId(70000), "top of \"desk\"", 7}, "on", at(8), at(13.5),
                           "by the other", Commander{OwnerId(70001), "robot", 8}};
  const auto command = command_status_to_json(sent);
  EXPECT_EQ(command,
            R"({"state":"superseded","creator":70000,"commander":"top of \"desk\"","request":7,"value":"on","since":8,)"
            R"("until":13.5,"reason":"by the other","by":{"creator":70001,"commander":"robot","request":8}})");
  std::string text = "what was there before";
  write_point_status({"good", "a \"reason\"", at(9), at(9.25), {}, command}, text);
  EXPECT_EQ(text, R"({"quality":"good","since":9,"heard":9.25,"changed":0,"reason":"a \"reason\"","command":)" +
                      command + "}");
  EXPECT_EQ(point_status_from_json(text), (PointStatus{"good", "a \"reason\"", at(9), at(9.25), {}, "superseded"}));
  EXPECT_EQ(command_status_from_json(text), sent);
  EXPECT_EQ(command_status_from_json(R"({"quality":"good","command":"on"})"), std::nullopt);
  EXPECT_EQ(command_status_from_json("no json"), std::nullopt);
}

TEST(PointTuples, QualityAndTimeAreFoundWithoutParsingTheRest) {
  const auto found = heard_quality_from_json(R"({"quality":"stale","since":8,"heard":5.5,"changed":4,"rea)");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->quality, Quality::kStale);
  EXPECT_EQ(found->heard, at(5.5));
  EXPECT_EQ(heard_quality_from_json(R"({"quality":"good","heard":"x"})")->heard, WallTime{});
  EXPECT_FALSE(heard_quality_from_json(R"({"quality":"excellent","heard":5})"));
  EXPECT_FALSE(heard_quality_from_json(""));
}

TEST(PointTuples, ThePointDescriptionSurvivesItsText) {
  PointDescription mode{"mode",       700,     "", "1", "enumeration", 0.0, 3.5, {{0, "off"}, {4, "eco"}},
                        "read-write", "state", "1"};
  const auto text = point_description_to_json(mode);
  EXPECT_EQ(text, R"({"type":"mode","type_id":700,"quantity":"","unit":"1","data_type":"enumeration","minimum":0.0,)"
                  R"("maximum":3.5,"words":["off","eco"],"codes":[0,4],"access":"read-write","report":"state",)"
                  R"("instance":"1"})");
  EXPECT_EQ(point_description_from_json(text), mode);
  mode.words = {{0, "off"}, {1, "on"}};
  EXPECT_EQ(point_description_to_json(mode).find("codes"), std::string::npos) << "they are 0, 1, 2";
  EXPECT_EQ(point_description_from_json(point_description_to_json(mode)), mode);
  EXPECT_TRUE(point_description_from_json(R"({"words":["a","b"],"codes":["x",1]})")->words.empty());
  EXPECT_EQ(point_description_from_json("[]"), std::nullopt);
}

TEST(PointTuples, TheDeviceDescriptionSurvivesItsText) {
  DeviceDescription lamp{"Lamp", "Kitchen", "m", "t", "1.4.6", "knx", {"switch"}, {"switch-1"}, {"switch-1"}, {"rate"}};
  const auto text = device_description_to_json(lamp);
  EXPECT_EQ(text,
            R"({"name":"Lamp","area":"Kitchen","model":"m","type":"t","address":"1.4.6","network":"knx",)"
            R"("capabilities":["switch"],"sensors":["switch-1"],"actuators":["switch-1"],"properties":["rate"]})");
  EXPECT_EQ(device_description_from_json(text), lamp);
  lamp.area.clear();
  EXPECT_EQ(device_description_to_json(lamp).find("area"), std::string::npos);
  EXPECT_EQ(device_description_from_json("7"), std::nullopt);
}

TEST(PointTuples, OnlyReachableDevicesSayReachable) {
  EXPECT_TRUE(says_reachable(device_condition_to_json({"reachable", "", at(7)})));
  EXPECT_FALSE(says_reachable(device_condition_to_json({"unreachable", "was \"reachable\"", at(7)})));
}

}  // namespace
}  // namespace rubicon::model
