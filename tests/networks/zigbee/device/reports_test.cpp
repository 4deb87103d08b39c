#include "networks/zigbee/device/reports.h"

#include "device_support.h"

namespace rubicon::networks::zigbee {
namespace {

using ReportsTest = DeviceTest;

// zigbee.md, section 12, pitfall 6
TEST_F(ReportsTest, Pitfall6_ThePresenceOfAPropertyIsNoReport) {
  start(record_of(definitions::kWeather, true));
  report(R"("temperature":21.5,"humidity":40)");
  EXPECT_EQ(readings(), (Values{{"temperature", "21.5"}, {"humidity", "40"}}));
  forget();
  report(R"("temperature":21.6,"humidity":40)");
  EXPECT_EQ(readings(), (Values{{"temperature", "21.6"}}));
}

// pitfall 7
TEST_F(ReportsTest, Pitfall7_AMessageThatWasOnlyHeardDatesNoValue) {
  start(record_of(definitions::kWeather, true));
  report(R"("temperature":21.5)");
  forget();
  report(R"("temperature":21.5)");
  EXPECT_TRUE(readings().empty());
  EXPECT_EQ(host.all<model::KeepAlive>().size(), 1U);
  report(R"("temperature":22)");
  ASSERT_EQ(raw_readings().size(), 1U);
  EXPECT_EQ(raw_readings()[0].user_time, std::chrono::floor<milliseconds>(now()));
}

// pitfall 8
TEST_F(ReportsTest, Pitfall8_StatesAtTheStartOfTheBridgeAreShownAsStoredWithTheirOwnTime) {
  start(record_of(definitions::kWeather, true));
  const auto yesterday = now() - hours(24);
  say(R"("temperature":19)", yesterday);
  EXPECT_TRUE(readings().empty());
  EXPECT_EQ(readings(false), (Values{{"temperature", "19"}}));
  EXPECT_EQ(raw_readings()[0].user_time, yesterday);
  EXPECT_TRUE(host.all<model::KeepAlive>().empty());
  forget();
  report(R"("temperature":19)");
  EXPECT_TRUE(raw_readings().empty()) << "the device lives, but nothing was measured";
  EXPECT_EQ(host.all<model::KeepAlive>().size(), 1U);
  report(R"("temperature":19,"humidity":40)");
  EXPECT_EQ(readings(), (Values{{"humidity", "40"}}));
  report(R"("temperature":19.5,"humidity":40)");
  EXPECT_EQ(readings(), (Values{{"humidity", "40"}, {"temperature", "19.5"}}));
}

TEST_F(ReportsTest, AStoredValueIsGoodWhenAnAnswerRepeatsIt) {
  start(record_of(definitions::kPlug));
  say(R"("state":"ON","power":7)", now() - hours(1));
  EXPECT_EQ(readings(false), (Values{{"state", "on"}, {"power", "7"}}));
  report(R"("state":"ON","power":7)");
  EXPECT_TRUE(readings().empty()) << "nothing was asked";
  sample({"power"}, seconds(10));
  report(R"("state":"ON","power":7)");
  EXPECT_EQ(readings(), (Values{{"power", "7"}}));
}

TEST_F(ReportsTest, WithoutLastSeenWhatComesAtTheStartOfTheBridgeIsStored) {
  start(record_of(definitions::kWeather, true), false);
  device->line_up();
  run(seconds(5));
  say_plain(R"("temperature":19)");
  EXPECT_EQ(readings(false), (Values{{"temperature", "19"}}));
  run(seconds(6));
  say_plain(R"("temperature":19,"humidity":50)");
  EXPECT_EQ(readings(), (Values{{"humidity", "50"}}));
  say_plain(R"("temperature":18,"humidity":50)");
  EXPECT_EQ(readings(), (Values{{"humidity", "50"}, {"temperature", "18"}}));
}

TEST_F(ReportsTest, WithoutLastSeenACopyThatComesInsteadOfAnAnswerIsStored) {
  start(record_of(definitions::kPlug), false);
  device->line_up();
  run(seconds(1));
  ASSERT_FALSE(host.payloads("get").empty()) << "it was asked, and Zigbee2MQTT repeats what it knows at its start";
  say_plain(R"("state":"ON","power":7)");
  EXPECT_TRUE(readings().empty());
  EXPECT_EQ(readings(false), (Values{{"state", "on"}, {"power", "7"}}));
}

TEST_F(ReportsTest, WithoutLastSeenABridgeThatRanBeforeRepeatsNothing) {
  start(record_of(definitions::kWeather, true), false);
  device->line_up(false);
  run(seconds(1));
  say_plain(R"("temperature":19)");
  EXPECT_EQ(readings(), (Values{{"temperature", "19"}}));
}

TEST_F(ReportsTest, AfterARenameARetainedStateIsThatOfWhoHadTheNameBefore) {
  start(record_of(definitions::kWeather, true));
  report(R"("temperature":20.7)");
  forget();
  auto record = device->record();
  record.name = "kitchen/two";
  for (int list = 0; list < 2; ++list) device->update(record);
  forget();
  ASSERT_TRUE(device->state(R"({"temperature":10.7,"last_seen":")" + iso(now() + seconds(5)) + "\"}", true));
  EXPECT_TRUE(raw_readings().empty());
  report(R"("temperature":20.8)");
  EXPECT_EQ(readings(), (Values{{"temperature", "20.8"}}));
  forget();
  ASSERT_TRUE(device->state(R"({"temperature":21,"last_seen":")" + iso(now() + seconds(60)) + "\"}", true));
  EXPECT_EQ(readings(false), (Values{{"temperature", "21"}})) << "it was heard under its name since";
}

TEST_F(ReportsTest, ARetainedStateIsStored) {
  start(record_of(definitions::kWeather, true));
  ASSERT_TRUE(device->state(R"({"temperature":19,"last_seen":")" + iso(now()) + "\"}", true));
  EXPECT_EQ(readings(false), (Values{{"temperature", "19"}}));
  report(R"("temperature":19)");
  EXPECT_TRUE(readings().empty());
  report(R"("temperature":20)");
  EXPECT_EQ(readings(), (Values{{"temperature", "20"}}));
}

TEST_F(ReportsTest, ABridgeThatForgotWhatItPublishedDoesNotUndoIt) {
  start(record_of(definitions::kWeather, true));
  report(R"("temperature":21)");
  run(minutes(1));
  report(R"("temperature":22)");
  forget();
  run(seconds(15));
  say(R"("temperature":21)", now() - minutes(1));
  EXPECT_TRUE(host.delivered.empty());
  report(R"("temperature":22)");
  EXPECT_EQ(readings(), (Values{{"temperature", "22"}}));
}

// pitfall 11
TEST_F(ReportsTest, Pitfall11_NullAndAbsentAreUnknown) {
  start(record_of(definitions::kWeather, true));
  report(R"("temperature":null,"humidity":null,"occupancy":null)");
  EXPECT_TRUE(raw_readings().empty());
  report(R"("temperature":21)");
  report(R"("temperature":null)");
  ASSERT_EQ(raw_readings().size(), 2U);
  EXPECT_EQ(raw_readings()[1].value, Value());
  EXPECT_EQ(raw_readings()[1].why, "") << "with a reason it would be bad";
}

// pitfall 12
TEST_F(ReportsTest, Pitfall12_AContactIsOpenIfItsValueOnSaysSo) {
  start(record_of(definitions::kWeather, true));
  report(R"("contact":false)");
  ASSERT_EQ(raw_readings().size(), 1U);
  EXPECT_EQ(raw_readings()[0].value, Value(true));
}

// pitfall 14
TEST_F(ReportsTest, Pitfall14_EachActionCountsOnceAndTheEmptyOneNever) {
  start(record_of(definitions::kButton, true));
  report(R"("action":"single","battery":90)");
  echo(R"("action":"","battery":90)");
  report(R"("battery":90)");
  report(R"("action":"single","battery":90)");
  report(R"("action":null,"battery":91)");
  EXPECT_EQ(readings(), (Values{{"action", "single"}, {"battery", "90"}, {"action", "single"}, {"battery", "91"}}));
}

TEST_F(ReportsTest, WithoutLastSeenAnActionCountsAlsoSoonAfterTheStart) {
  start(record_of(definitions::kButton, true), false);
  device->line_up();
  run(seconds(1));
  say_plain(R"("action":"single","battery":90)");
  EXPECT_EQ(readings(), (Values{{"action", "single"}}));
  EXPECT_EQ(readings(false), (Values{{"battery", "90"}}));
}

TEST_F(ReportsTest, AnActionOfTheBrokersMemoryOrOfALongTimeAgoIsNone) {
  start(record_of(definitions::kButton, true), false);
  device->line_up();
  ASSERT_TRUE(device->state(R"({"action":"single"})", true));
  ASSERT_TRUE(device->state(R"({"action":"single","last_seen":")" + iso(now()) + "\"}", true));
  say(R"("action":"single")", now() - minutes(5));
  EXPECT_TRUE(host.all<model::Updates>().empty());
}

TEST_F(ReportsTest, AnActionIsDeliveredAlsoWhereItsMessageBringsNoNewLastSeen) {
  start(record_of(definitions::kButton, true));
  report(R"("battery":90)");
  forget();
  echo(R"("action":"double","battery":90)");
  EXPECT_EQ(readings(), (Values{{"action", "double"}}));
}

TEST_F(ReportsTest, ATimerOfTheBridgeChangesTheValueNowAndIsNoSignOfLife) {
  start(record_of(definitions::kWeather, true));
  report(R"("occupancy":true)");
  forget();
  run(seconds(90));
  echo(R"("occupancy":false)");
  ASSERT_EQ(raw_readings().size(), 1U);
  EXPECT_EQ(readings(), (Values{{"occupancy", "off"}}));
  EXPECT_EQ(raw_readings()[0].user_time, now());
  EXPECT_TRUE(host.all<model::KeepAlive>().empty());
  report(R"("occupancy":true)");
  device->availability(false);
  forget();
  run(seconds(90));
  echo(R"("occupancy":false)");
  EXPECT_EQ(readings(false), (Values{{"occupancy", "off"}}));  // it must not make the device reachable
  EXPECT_TRUE(readings().empty());
  report(R"("occupancy":true)");
  EXPECT_EQ(readings(), (Values{{"occupancy", "on"}}));
}

TEST_F(ReportsTest, TheEchoOfAGroupIsNoSignOfLifeOfAMemberThatCannotBeAsked) {
  start(record_of(definitions::kFan));
  report(R"("state":"OFF")");
  device->availability(false);
  forget();
  echo(R"("state":"ON")");
  EXPECT_EQ(readings(false), (Values{{"state", "on"}}));
  EXPECT_TRUE(readings().empty());
  device->availability(true);
  echo(R"("state":"OFF")");
  EXPECT_EQ(readings(), (Values{{"state", "off"}}));
}

TEST_F(ReportsTest, TwoReportsInOneMillisecondAreTwoReports) {
  start(record_of(definitions::kWeather, true));
  report(R"("temperature":21,"humidity":40)");
  forget();
  report(R"("temperature":22,"humidity":40)");
  echo(R"("temperature":22,"humidity":41)");
  EXPECT_EQ(readings(), (Values{{"temperature", "22"}, {"humidity", "41"}}));
}

TEST_F(ReportsTest, AClockThatIsWrongMakesOnlyTheFirstMessageOld) {
  start(record_of(definitions::kWeather, true));
  say(R"("temperature":20)", now() - minutes(5));
  run(minutes(1));
  say(R"("temperature":21)", now() - minutes(5));
  run(minutes(1));
  say(R"("temperature":22)", now() - minutes(5) - milliseconds(300));
  EXPECT_EQ(readings(false), (Values{{"temperature", "20"}}));
  EXPECT_EQ(readings(), (Values{{"temperature", "21"}, {"temperature", "22"}}));
}

TEST_F(ReportsTest, AClockThatIsWrongLeavesNoValueStored) {
  start(record_of(definitions::kWeather, true));
  say(R"("temperature":20)", now() - minutes(5));
  run(minutes(1));
  say(R"("temperature":20)", now() - minutes(5));
  EXPECT_EQ(readings(), (Values{{"temperature", "20"}}));
}

TEST_F(ReportsTest, AClockThatIsSetBackSilencesNoDevice) {
  start(record_of(definitions::kWeather, true));
  say(R"("temperature":20)", now() + hours(1));
  run(minutes(1));
  say(R"("temperature":21)", now());
  EXPECT_EQ(readings(), (Values{{"temperature", "20"}, {"temperature", "21"}}));
  for (const auto& one : raw_readings()) EXPECT_LE(one.user_time, now());
}

TEST_F(ReportsTest, AfterAnInterruptionTheValuesAreGoodAgainWhenTheDeviceIsHeard) {
  start(record_of(definitions::kWeather, true));
  report(R"("temperature":20,"humidity":40)");
  const auto measured = std::chrono::floor<milliseconds>(now());
  device->line_lost("the broker is gone");
  run(minutes(5));
  device->line_up();
  run(minutes(5));
  forget();
  report(R"("temperature":20,"humidity":41)");
  EXPECT_EQ(readings(), (Values{{"temperature", "20"}, {"humidity", "41"}}));
  EXPECT_EQ(raw_readings()[0].user_time, measured);
  forget();
  report(R"("temperature":20,"humidity":41)");
  EXPECT_TRUE(readings().empty());
}

/// A device with a battery cannot be asked: the values that it still has count when it is heard.
TEST_F(ReportsTest, AfterItWasOutOfReachTheValuesAreGoodAgainWhenTheDeviceIsHeard) {
  start(record_of(definitions::kWeather, true));
  device->bridge_decides(true);
  report(R"("temperature":20,"humidity":40)");
  const auto measured = std::chrono::floor<milliseconds>(now());
  run(hours(2));
  device->availability(false);
  forget();
  run(hours(1));
  device->availability(true);
  report(R"("temperature":20,"humidity":40)");
  ASSERT_EQ(readings(), (Values{{"temperature", "20"}, {"humidity", "40"}}));
  EXPECT_EQ(raw_readings()[0].user_time, measured);
  forget();
  report(R"("temperature":20,"humidity":40)");
  EXPECT_TRUE(readings().empty());
}

TEST_F(ReportsTest, AfterALongSilenceTheValuesAreGoodAgainWhenTheDeviceIsHeard) {
  start(record_of(definitions::kWeather, true));
  report(R"("temperature":20)");
  run(hours(30));
  ASSERT_EQ(host.all<model::Unreachable>().size(), 1U);
  forget();
  report(R"("temperature":20)");
  EXPECT_EQ(readings(), (Values{{"temperature", "20"}}));
}

/// What a timer of Zigbee2MQTT changed meanwhile was only stored.
TEST_F(ReportsTest, WhatChangedWhileTheDeviceWasOutOfReachIsGoodWhenItIsHeard) {
  start(record_of(definitions::kWeather, true));
  report(R"("occupancy":true)");
  device->availability(false);
  run(seconds(90));
  echo(R"("occupancy":false)");
  forget();
  report(R"("occupancy":false)");
  EXPECT_EQ(readings(), (Values{{"occupancy", "off"}}));
}

TEST_F(ReportsTest, AfterARestartOfTheBridgeOnlyWhatIsReportedIsGood) {
  start(record_of(definitions::kWeather, true));
  report(R"("temperature":20,"humidity":40)");
  const auto last = now();
  run(minutes(1));
  device->line_lost("Zigbee2MQTT is offline");
  run(minutes(5));
  device->line_up();
  say(R"("temperature":20,"humidity":40)", last);
  forget();
  report(R"("temperature":20,"humidity":41)");
  EXPECT_EQ(readings(), (Values{{"humidity", "41"}})) << "a report of 20.5 may be lost";
  report(R"("temperature":21,"humidity":41)");
  EXPECT_EQ(readings(), (Values{{"humidity", "41"}, {"temperature", "21"}}));
}

TEST_F(ReportsTest, AfterARestartOfTheBridgeOlderValuesThanTheLastAreNotShown) {
  start(record_of(definitions::kWeather, true));
  report(R"("temperature":21)");
  const auto first = now();
  run(minutes(1));
  report(R"("temperature":22,"humidity":40)");
  device->line_lost("Zigbee2MQTT is offline");
  run(minutes(5));
  device->line_up();
  say(R"("temperature":21)", first);
  forget();
  report(R"("temperature":21,"humidity":41)");
  EXPECT_EQ(readings(), (Values{{"humidity", "41"}}));
}

TEST_F(ReportsTest, WhatCannotBeReadIsAReadingWithoutValue) {
  start(record_of(definitions::kWeather, true));
  report(R"("temperature":"warm","humidity":40)");
  ASSERT_EQ(raw_readings().size(), 2U);
  EXPECT_EQ(raw_readings()[0].value, Value());
  EXPECT_NE(raw_readings()[0].why.find("warm"), std::string::npos);
}

TEST_F(ReportsTest, OfAColourThePointThatCanReadItIsUpdated) {
  start(record_of(definitions::kLamp));
  report(R"("color":{"x":0.3,"y":0.4})");
  EXPECT_EQ(readings(), (Values{{"color", R"({"x":0.3,"y":0.4})"}}));
}

TEST_F(ReportsTest, AMessageThatCannotBeReadCountsForNothing) {
  start(record_of(definitions::kWeather, true));
  for (const std::string broken :
       {"{", "[]", "7", "\"ON\"", "{\"temperature\":21", "{\"temperature\":21}x", "{\"temperature\" 21}", "ON"}) {
    EXPECT_FALSE(device->state(broken, false)) << broken;
  }
  EXPECT_FALSE(device->state("{\"a\":\"" + std::string(70'000, 'x') + "\"}", false));
  EXPECT_TRUE(host.delivered.empty());
  EXPECT_TRUE(device->state("", false));
}

}  // namespace
}  // namespace rubicon::networks::zigbee
