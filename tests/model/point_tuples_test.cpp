#include "model/point_tuples.h"

#include <gtest/gtest.h>

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

TEST(PointTuples, TheStatusOfALineSurvivesItsText) {
  const LineStatus down{"down", "no \"server\"", at(1767225600.25), 9, at(1767225630)};
  EXPECT_EQ(line_status_to_json(down),
            R"({"line":"down","since":1767225600.25,"reason":"no \"server\"","attempts":9,"next_attempt":1767225630})");
  EXPECT_EQ(line_status_from_json(line_status_to_json(down)), down);
  EXPECT_FALSE(down.works());
  EXPECT_TRUE((LineStatus{"ended", "", {}, 1, {}}.works()));
}

TEST(PointTuples, TheConditionOfADeviceSurvivesItsText) {
  const DeviceCondition silent{"unreachable", "silent for 60s", at(7)};
  EXPECT_EQ(device_condition_to_json(silent), R"({"status":"unreachable","since":7,"reason":"silent for 60s"})");
  EXPECT_EQ(device_condition_from_json(device_condition_to_json(silent)), silent);
}

}  // namespace
}  // namespace rubicon::model
