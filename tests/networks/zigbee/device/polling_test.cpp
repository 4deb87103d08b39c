#include "networks/zigbee/device/polling.h"

#include "device_support.h"

namespace rubicon::networks::zigbee {
namespace {

using Texts = std::vector<std::string>;
using PollingTest = DeviceTest;

TEST_F(PollingTest, ADemandAsksAtOnceAndAgainEachPeriodUntilItEnds) {
  start(record_of(definitions::kPlug));
  sample({"power", "voltage"}, seconds(5));
  EXPECT_EQ(answers(), Texts{"1 sent"});
  run(milliseconds(10));
  EXPECT_EQ(gets(), Texts{R"({"power":"","voltage":""})"});
  run(seconds(20));
  EXPECT_EQ(gets().size(), 5U);
  sample({}, seconds(0));
  run(minutes(5));
  EXPECT_EQ(gets().size(), 5U);
}

TEST_F(PollingTest, AnAnswerIsAReadingAlsoIfNothingChanged) {
  start(record_of(definitions::kPlug));
  report(R"("state":"ON","power":5,"voltage":230)");
  forget();
  sample({"power"}, seconds(5));
  run(milliseconds(10));
  report(R"("state":"ON","power":5,"voltage":231)");
  EXPECT_EQ(readings(), (Values{{"voltage", "231"}}));
  report(R"("state":"ON","power":5,"voltage":231)");
  EXPECT_EQ(readings(), (Values{{"voltage", "231"}, {"power", "5"}}));
  report(R"("state":"ON","power":5,"voltage":231)");
  EXPECT_EQ(readings().size(), 2U);
}

TEST_F(PollingTest, ADeviceIsAskedAtMostOnceASecond) {
  start(record_of(definitions::kPlug));
  sample({"power"}, milliseconds(10));
  for (int i = 0; i < 20; ++i) {
    sample({i % 2 ? "power" : "voltage"}, milliseconds(10));
    run(milliseconds(100));
  }
  EXPECT_LE(gets().size(), 3U);
  host.published.clear();
  run(seconds(10));
  EXPECT_LE(gets().size(), 10U);
  EXPECT_GE(gets().size(), 9U);
}

TEST_F(PollingTest, WithoutAPlaceInTheBoundOfTheNetworkAQuestionWaits) {
  start(record_of(definitions::kPlug));
  host.polls_left = 0;
  sample({"power"}, minutes(10));
  run(seconds(10));
  EXPECT_TRUE(gets().empty());
  host.polls_left = 1;
  run(seconds(2));
  EXPECT_EQ(gets().size(), 1U);
  EXPECT_EQ(host.polls_left, 0);
}

TEST_F(PollingTest, WhatTheDeviceReportsOftenEnoughIsAskedForOnce) {
  auto record = record_of(definitions::kPlug);
  record.reportings.push_back({"haElectricalMeasurement", "activePower", 5, 60});
  start(std::move(record));
  sample({"power"}, minutes(2));
  run(minutes(20));
  EXPECT_EQ(gets().size(), 1U);
  sample({"power"}, seconds(30));
  run(minutes(2));
  EXPECT_GE(gets().size(), 4U);
}

TEST_F(PollingTest, Pitfall15_ASleepingDeviceIsNotPolled) {
  start(record_of(definitions::kValve, true));
  sample({"local_temperature", "occupied_heating_setpoint"}, seconds(1));
  EXPECT_EQ(answers(), Texts{"1 sent"});
  run(hours(1));
  EXPECT_TRUE(host.published.empty());
}

TEST_F(PollingTest, AQuestionThatWaitsEndsWithTheDefinitionAndTheNewOneIsAskedFor) {
  for (const auto definition : {definitions::kPlug, definitions::kFan}) {
    start(record_of(definitions::kLamp));
    host.polls_left = 0;
    sample({"power_on_behavior"}, seconds(5));
    run(seconds(1));
    EXPECT_TRUE(gets().empty());
    device->update(record_of(definition));
    host.polls_left = 1'000'000;
    run(seconds(20));
    const bool asked = definition == definitions::kPlug;
    EXPECT_EQ(gets(), asked ? Texts{R"({"state":"","power":"","voltage":""})"} : Texts{});
  }
}

TEST_F(PollingTest, NothingIsAskedWithoutALine) {
  start(record_of(definitions::kPlug));
  sample({"power"}, seconds(1));
  run(seconds(3));
  device->line_lost("the broker is gone");
  host.published.clear();
  run(hours(3));
  EXPECT_TRUE(host.published.empty());
  device->line_up();
  run(seconds(5));
  EXPECT_GE(gets().size(), 3U);
}

}  // namespace
}  // namespace rubicon::networks::zigbee
