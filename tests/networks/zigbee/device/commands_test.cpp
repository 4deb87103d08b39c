#include "networks/zigbee/device/commands.h"

#include "device_support.h"

namespace rubicon::networks::zigbee {
namespace {

using Texts = std::vector<std::string>;

class CommandsTest : public DeviceTest {
 protected:
  /// A plug that is off.
  void start_plug() {
    start(record_of(definitions::kPlug));
    report(R"("state":"OFF","power":0)");
    forget();
  }
};

TEST_F(CommandsTest, ASetIsPublishedAtTheEndOfTheTurnAndMergesWithThoseOfTheTurn) {
  start(record_of(definitions::kLamp));
  ASSERT_TRUE(command("state", true));
  ASSERT_TRUE(command("brightness", 50.0));
  EXPECT_TRUE(host.published.empty());
  host.time.run_ready();
  EXPECT_EQ(sets(), Texts{R"({"state":"ON","brightness":127})"});
  EXPECT_EQ(host.published[0].name, "kitchen/one");
}

// zigbee.md, section 12, pitfall 9; the messages are those of trace16-small.jsonl at 00:16:51
TEST_F(CommandsTest, Pitfall9_AnEchoMeansSentAndOnlyTheAnswerOfTheDeviceIsAReading) {
  start(record_of(definitions::kLamp));
  report(R"("state":"OFF","brightness":10)");
  forget();
  ASSERT_TRUE(command("state", true));
  commanded("brightness", 40.0 / 254 * 100);
  report(R"("state":"OFF","brightness":10)");
  EXPECT_TRUE(answers().empty());
  echo(R"("state":"ON","brightness":40)");
  EXPECT_EQ(answers(), (Texts{"1 sent", "2 sent"}));
  report(R"("state":"ON","brightness":40)");  // a real report, which cannot be distinguished from a heard message
  EXPECT_TRUE(readings().empty());
  EXPECT_TRUE(gets().empty());
  run(milliseconds(300));
  EXPECT_EQ(gets(), Texts{R"({"state":""})"});
  report(R"("state":"ON","brightness":40)");
  EXPECT_TRUE(readings().empty());
  run(milliseconds(110));
  EXPECT_EQ(readings(), (Values{{"state", "on"}}));
  EXPECT_EQ(gets(), (Texts{R"({"state":""})", R"({"brightness":""})"}));
  report(R"("state":"ON","brightness":40)");
  run(milliseconds(110));
  ASSERT_EQ(readings().size(), 2U);
  EXPECT_EQ(raw_readings()[1].value, Value(40.0 / 254 * 100));
  run(minutes(1));
  EXPECT_EQ(gets().size(), 2U);
  EXPECT_EQ(sets().size(), 1U);
}

TEST_F(CommandsTest, ADeviceThatIgnoresACommandIsNeverShownWithItsEcho) {
  start_plug();
  commanded("state", true);
  report(R"("state":"OFF","power":0)");
  echo(R"("state":"ON","power":0)");
  run(milliseconds(300));
  ASSERT_EQ(gets().size(), 1U);
  report(R"("state":"ON","power":0)");  // heard before the answer, with the echo
  run(milliseconds(50));
  report(R"("state":"OFF","power":0)");
  run(seconds(10));
  EXPECT_EQ(readings(), (Values{{"state", "off"}}));
  EXPECT_EQ(answers(), Texts{"1 sent"});
}

TEST_F(CommandsTest, AReportOfAnotherPropertyBesideTheEchoProvesNothing) {
  start_plug();
  commanded("state", true);
  report(R"("state":"OFF","power":0)");
  echo(R"("state":"ON","power":0)");
  run(milliseconds(300));
  report(R"("state":"ON","power":3)");
  run(milliseconds(500));
  EXPECT_EQ(readings(), (Values{{"power", "3"}}));
}

TEST_F(CommandsTest, ADimmerOnItsWayIsReportedAndConfirmedWhenItArrives) {
  start(record_of(definitions::kLamp));
  report(R"("state":"ON","brightness":10)");
  forget();
  commanded("brightness", 80.0);
  report(R"("state":"ON","brightness":10)");
  echo(R"("state":"ON","brightness":203)");
  run(milliseconds(300));
  report(R"("state":"ON","brightness":90)");
  run(milliseconds(700));
  EXPECT_EQ(gets().size(), 2U);
  report(R"("state":"ON","brightness":203)");
  const auto found = raw_readings();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].value, Value(35.4)) << "90 of 254, without digits that say no more";
  EXPECT_EQ(found[1].value, Value(80.0));
}

TEST_F(CommandsTest, TheCommandedValueIsReportedAsItWasCommandedUntilAnotherOneComes) {
  start(record_of(definitions::kLamp));
  report(R"("brightness":10)");
  commanded("brightness", 30.1);
  EXPECT_EQ(sets(), Texts{R"({"brightness":76})"});
  report(R"("brightness":10)");
  echo(R"("brightness":76)");
  run(milliseconds(300));
  report(R"("brightness":76)");
  run(milliseconds(110));
  EXPECT_EQ(raw_readings().back().value, Value(30.1));
  run(minutes(1));
  report(R"("brightness":127)");
  report(R"("brightness":76)");
  EXPECT_EQ(raw_readings().back().value, Value(30.0));
}

// pitfall 10
TEST_F(CommandsTest, Pitfall10_WithoutAnEchoTheCommandIsUndeliverableAfter15Seconds) {
  start_plug();
  commanded("state", true);
  run(seconds(14));
  EXPECT_TRUE(answers().empty());
  run(seconds(2));
  EXPECT_EQ(answers(), Texts{"1 undeliverable"});
  EXPECT_NE(text_of_answer(1).find("Zigbee2MQTT did not confirm"), std::string::npos);
  EXPECT_NE(text_of_answer(1).find("may still execute it"), std::string::npos);
  run(minutes(2));
  EXPECT_EQ(sets().size(), 1U);
  EXPECT_EQ(answers().size(), 1U);
}

TEST_F(CommandsTest, WhatWaitsBehindASetMergesNewestFirstAndGoesWithTheEcho) {
  start(record_of(definitions::kLamp));
  report(R"("state":"OFF","brightness":10)");
  forget();
  commanded("brightness", 10.0);
  commanded("brightness", 20.0);
  commanded("state", true);
  commanded("brightness", 50.0);
  EXPECT_EQ(sets().size(), 1U);
  EXPECT_EQ(answers(), Texts{"2 failed"});
  EXPECT_NE(text_of_answer(2).find("superseded"), std::string::npos);
  echo(R"("state":"OFF","brightness":25)");
  host.time.run_ready();
  EXPECT_EQ(sets(), (Texts{R"({"brightness":25})", R"({"state":"ON","brightness":127})"}));
}

TEST_F(CommandsTest, ASetWithoutEchoHoldsTheNextOnesForTwoSecondsOnly) {
  start_plug();
  commanded("state", true);
  commanded("state", false, seconds(5));
  run(milliseconds(1900));
  EXPECT_EQ(sets().size(), 1U);
  run(milliseconds(200));
  EXPECT_EQ(sets(), (Texts{R"({"state":"ON"})", R"({"state":"OFF"})"}));
  EXPECT_EQ(answers(), Texts{"1 failed"});
}

TEST_F(CommandsTest, ACommandThatCannotBeReportedIsSentWhenItIsPublished) {
  start(record_of(definitions::kLamp));
  commanded("identify", std::string("identify"));
  EXPECT_EQ(sets(), Texts{R"({"identify":"identify"})"});
  EXPECT_EQ(answers(), Texts{"1 sent"});
}

TEST_F(CommandsTest, EventsKeepTheirOrderAndEachIsPublished) {
  device::Commands commands(host.time,
                            {[&](std::string payload) { return host.publish("x", "set", std::move(payload)); },
                             [&](std::uint64_t number, model::Outcome outcome, std::string text) {
                               host.deliver("x", model::Acknowledge{number, outcome, std::move(text)});
                             },
                             [](const device::Command&) {}});
  for (std::uint64_t i = 1; i <= 3; ++i) {
    device::Command command;
    command.request = i;
    command.key = "step";
    command.json = std::to_string(i);
    command.event = true;
    command.echoed = false;
    ASSERT_TRUE(commands.add(std::move(command), false, seconds(5)));
  }
  host.time.run_ready();
  EXPECT_EQ(sets(), (Texts{R"({"step":1})", R"({"step":2})", R"({"step":3})"}));
  for (int i = 0; i < 3; ++i) commands.taken();
  EXPECT_EQ(answers(), (Texts{"1 sent", "2 sent", "3 sent"}));
}

TEST_F(CommandsTest, WhatTheDeviceCannotTakeIsRefusedBeforeItIsPublished) {
  start(record_of(definitions::kValve, true));
  EXPECT_FALSE(command("occupied_heating_setpoint", 40.0));
  EXPECT_FALSE(command("local_temperature", 20.0));
  Message message;
  message.body = model::Actuate{9, {Kind::kActuator, TypeId{1}, "none"}, Value(true)};
  EXPECT_FALSE(device->send(message));
  host.time.run_ready();
  EXPECT_TRUE(host.published.empty());
}

TEST_F(CommandsTest, ASleepingDeviceMayTakeTheWholeTimeToLive) {
  start(record_of(definitions::kValve, true));
  report(R"("occupied_heating_setpoint":20)");
  forget();
  commanded("occupied_heating_setpoint", 21.5, seconds(25));
  run(seconds(24));
  EXPECT_TRUE(answers().empty());
  echo(R"("occupied_heating_setpoint":21.5)");
  EXPECT_EQ(answers(), Texts{"1 sent"});
  commanded("occupied_heating_setpoint", 22.0, minutes(5));
  run(milliseconds(29'100));
  EXPECT_EQ(answers(), (Texts{"1 sent", "2 undeliverable"}));
}

// pitfall 15
TEST_F(CommandsTest, Pitfall15_ASleepingDeviceConfirmsByALaterMessageAndIsNeverAsked) {
  start(record_of(definitions::kValve, true));
  report(R"("occupied_heating_setpoint":20,"local_temperature":18)");
  forget();
  commanded("occupied_heating_setpoint", 21.5);
  report(R"("occupied_heating_setpoint":20,"local_temperature":18)");
  echo(R"("occupied_heating_setpoint":21.5,"local_temperature":18)");
  report(R"("occupied_heating_setpoint":21.5,"local_temperature":18.5)");
  run(milliseconds(200));
  EXPECT_EQ(readings(), (Values{{"local_temperature", "18.5"}}));
  report(R"("occupied_heating_setpoint":21.5,"local_temperature":18.5)");
  run(milliseconds(200));
  EXPECT_EQ(readings().back(), (std::pair<std::string, std::string>("occupied_heating_setpoint", "21.5")));
  run(hours(2));
  EXPECT_TRUE(gets().empty());
}

TEST_F(CommandsTest, WhereTheEchoOvertakesTheAnswerToTheSetThatAnswerIsNoProof) {
  start(record_of(definitions::kFan));
  report(R"("state":"OFF","power":0)");
  forget();
  commanded("state", true);
  echo(R"("state":"ON","power":0)");
  report(R"("state":"ON","power":0)");
  run(milliseconds(200));
  EXPECT_TRUE(readings().empty());
  report(R"("state":"ON","power":0)");
  run(milliseconds(200));
  EXPECT_EQ(readings(), (Values{{"state", "on"}}));
}

TEST_F(CommandsTest, ALockThatReportsWithoutAnEchoIsConfirmedByItsReport) {
  start(record_of(definitions::kFan, true));
  report(R"("state":"OFF")");
  forget();
  commanded("state", true);
  report(R"("state":"OFF")");
  report(R"("state":"ON")");
  EXPECT_EQ(answers(), Texts{"1 sent"});
  EXPECT_EQ(readings(), (Values{{"state", "on"}}));
}

TEST_F(CommandsTest, WhereNoEchoComesTheDeviceIsAskedOnce) {
  start_plug();
  commanded("state", true);
  report(R"("state":"OFF","power":0)");
  run(seconds(2));
  EXPECT_EQ(gets(), Texts{R"({"state":""})"});
  report(R"("state":"ON","power":0)");
  EXPECT_EQ(answers(), Texts{"1 sent"});
  run(milliseconds(300));
  report(R"("state":"ON","power":0)");
  run(milliseconds(200));
  EXPECT_EQ(readings(), (Values{{"state", "on"}}));
}

TEST_F(CommandsTest, WithoutEchoesTheFirstMessageWithTheValueIsTheReport) {
  start_plug();
  device->optimistic(false);
  commanded("state", true);
  report(R"("state":"OFF","power":0)");
  run(milliseconds(300));
  EXPECT_EQ(gets().size(), 1U);
  report(R"("state":"ON","power":0)");
  EXPECT_EQ(answers(), Texts{"1 sent"});
  EXPECT_EQ(readings(), (Values{{"state", "on"}}));
}

TEST_F(CommandsTest, WithoutLastSeenTheAnswerToOurGetIsTheProof) {
  start(record_of(definitions::kPlug));
  say_plain(R"("state":"OFF","power":0)");
  forget();
  commanded("state", true);
  say_plain(R"("state":"ON","power":0)");
  EXPECT_EQ(answers(), Texts{"1 sent"});
  run(milliseconds(300));
  EXPECT_TRUE(readings().empty());
  say_plain(R"("state":"ON","power":0)");
  run(milliseconds(200));
  EXPECT_EQ(readings(), (Values{{"state", "on"}}));
}

TEST_F(CommandsTest, WithoutLastSeenADeviceThatCannotBeAskedConfirmsNothing) {
  start(record_of(definitions::kFan));
  say_plain(R"("state":"OFF","power":0)");
  forget();
  commanded("state", true);
  say_plain(R"("state":"ON","power":0)");
  run(seconds(5));
  say_plain(R"("state":"ON","power":0)");
  run(seconds(5));
  EXPECT_EQ(answers(), Texts{"1 sent"});
  EXPECT_TRUE(readings().empty());
  say_plain(R"("state":"OFF","power":0)");
  EXPECT_EQ(readings(), (Values{{"state", "off"}}));
}

TEST_F(CommandsTest, WholeNumbersAreTakenExactlyAndRealOnesToHalfAStep) {
  constexpr std::string_view kTimer = R"([
    {"type":"numeric","name":"countdown","property":"countdown","access":7,"unit":"s","value_min":0,"value_max":9000},
    {"type":"numeric","name":"brightness","property":"brightness","access":7,"value_min":0,"value_max":1000},
    {"type":"numeric","name":"setpoint","property":"setpoint","access":7,"value_min":0,"value_max":30,"value_step":0.5},
    {"type":"numeric","name":"ratio","property":"ratio","access":7}])";
  struct Case {
    std::string property;
    Value wanted;
    std::string reported;
    bool same;
  };
  const std::vector<Case> cases{
      {"countdown", 3600.0, "3599", false},  {"countdown", 3600.0, "3600", true}, {"countdown", 2000.0, "1999", false},
      {"countdown", 2000.0, "2000.0", true}, {"brightness", 100.0, "999", false}, {"brightness", 100.0, "1000", true},
      {"setpoint", 21.5, "21.3", true},      {"setpoint", 21.5, "21.2", false},   {"setpoint", 21.5, "22", false},
      {"ratio", 0.3, "0.30000001192", true}, {"ratio", 0.3, "0.3001", false},
  };
  for (const auto& one : cases) {
    start(record_of(kTimer));
    report('"' + one.property + "\":1");
    commanded(one.property, one.wanted);
    forget();
    report('"' + one.property + "\":1");
    report('"' + one.property + "\":" + one.reported);
    EXPECT_EQ(answers().size(), one.same ? 1U : 0U) << one.property << ' ' << one.reported;
    run(milliseconds(310));
    report('"' + one.property + "\":" + one.reported);
    run(milliseconds(110));
    ASSERT_FALSE(raw_readings().empty()) << one.property << ' ' << one.reported;
    EXPECT_EQ(raw_readings().back().value == one.wanted, one.same) << one.property << ' ' << one.reported;
  }
}

TEST_F(CommandsTest, ACommandForTheStateThatIsThereIsProvenToo) {
  start_plug();
  commanded("state", false);
  report(R"("state":"OFF","power":0)");
  EXPECT_EQ(answers(), Texts{"1 sent"});
  echo(R"("state":"OFF","power":0)");
  EXPECT_TRUE(readings().empty());
  run(milliseconds(300));
  report(R"("state":"OFF","power":0)");
  run(milliseconds(200));
  EXPECT_EQ(readings(), (Values{{"state", "off"}}));
}

TEST_F(CommandsTest, AReportIsNeverOlderThanItsCommandWhateverTheClockOfTheBridgeSays) {
  start_plug();
  const auto behind = seconds(3);
  say(R"("state":"OFF","power":1)", now() - behind);
  run(seconds(1));
  forget();
  commanded("state", true);
  const auto commanded_at = now();
  say(R"("state":"ON","power":1)", now() - behind - seconds(1));
  run(milliseconds(10));
  say(R"("state":"ON","power":1)", now() - behind);
  run(milliseconds(300));
  say(R"("state":"ON","power":1)", now() - behind);
  run(milliseconds(200));
  ASSERT_EQ(readings(), (Values{{"state", "on"}}));
  EXPECT_GE(raw_readings().back().user_time, commanded_at);
}

TEST_F(CommandsTest, ALostLineAnswersWhatWaitsAndNothingIsPublishedAfterwards) {
  start_plug();
  commanded("state", true);
  ASSERT_TRUE(command("state", false));
  device->line_lost("the broker is gone");
  EXPECT_EQ(answers(), (Texts{"1 undeliverable", "2 undeliverable"}));
  EXPECT_EQ(text_of_answer(2), "the broker is gone");
  const auto refused = command("state", true);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnreachable);
  run(hours(3));
  EXPECT_EQ(host.published.size(), 1U);
  device->line_up();
  run(minutes(1));
  EXPECT_EQ(sets().size(), 1U);
  EXPECT_EQ(answers().size(), 2U);
}

TEST_F(CommandsTest, AnEchoThatWasNotProvenIsNotShownAfterAnInterruptionEither) {
  start_plug();
  commanded("state", true);
  report(R"("state":"OFF","power":0)");
  echo(R"("state":"ON","power":0)");
  device->line_lost("the broker is gone");
  run(minutes(1));
  device->line_up();
  report(R"("state":"ON","power":0)");
  EXPECT_EQ(readings(), (Values{{"power", "0"}}));
  run(seconds(2));
  report(R"("state":"OFF","power":0)");
  EXPECT_EQ(readings().back(), (std::pair<std::string, std::string>("state", "off")));
}

TEST_F(CommandsTest, ABusyLineAnswersTheCommandsOfTheSet) {
  start_plug();
  host.refuse = true;
  commanded("state", true);
  EXPECT_EQ(answers(), Texts{"1 busy"});
}

TEST_F(CommandsTest, ManyEventsAreRefusedBeyondTheBound) {
  start(record_of(definitions::kPlug));
  device::Commands commands(
      host.time, {[](std::string) { return Result<void>(); }, [](std::uint64_t, model::Outcome, std::string) {},
                  [](const device::Command&) {}});
  device::Command event;
  event.event = true;
  for (std::size_t i = 0; i < device::Commands::kMaxPending; ++i) ASSERT_TRUE(commands.add(event, false, {}));
  EXPECT_FALSE(commands.add(event, false, {}));
}

TEST_F(CommandsTest, ACommandOfAnotherClientIsShownWhenTheDeviceConfirmsIt) {
  start_plug();
  report(R"("state":"OFF","power":0)");
  echo(R"("state":"ON","power":0)");  // its echo, or that of its group
  EXPECT_TRUE(readings().empty());
  run(milliseconds(300));
  EXPECT_EQ(gets(), Texts{R"({"state":""})"});
  report(R"("state":"ON","power":0)");
  run(milliseconds(200));
  EXPECT_EQ(readings(), (Values{{"state", "on"}}));
}

TEST_F(CommandsTest, ACommandOfAnotherClientThatTheDeviceIgnoresIsNotShown) {
  start_plug();
  echo(R"("state":"ON","power":0)");
  run(milliseconds(300));
  report(R"("state":"OFF","power":0)");
  run(minutes(5));
  EXPECT_EQ(readings(), (Values{{"state", "off"}}));
}

TEST_F(CommandsTest, ACommandOfAnotherClientToADeviceThatCannotBeAskedIsShown) {
  start(record_of(definitions::kFan));
  report(R"("state":"OFF","power":0)");
  forget();
  echo(R"("state":"ON","power":0)");
  EXPECT_EQ(readings(), (Values{{"state", "on"}}));
}

TEST_F(CommandsTest, WhatASetChangesBesidesItsOwnPropertyIsAnEchoToo) {
  start(record_of(definitions::kLamp));
  report(R"("state":"OFF","brightness":10)");
  forget();
  commanded("brightness", 50.0);
  report(R"("state":"OFF","brightness":10)");
  echo(R"("state":"ON","brightness":127)");
  EXPECT_TRUE(readings().empty());
  run(milliseconds(300));
  report(R"("state":"ON","brightness":127)");
  run(milliseconds(110));
  EXPECT_EQ(readings().size(), 1U);
  report(R"("state":"ON","brightness":127)");
  run(milliseconds(110));
  EXPECT_EQ(readings().size(), 2U);
  EXPECT_EQ(answers(), Texts{"1 sent"});
}

TEST_F(CommandsTest, ANewDefinitionEndsTheCommandsOfTheOldOne) {
  start_plug();
  commanded("state", true);
  auto record = record_of(definitions::kLamp);
  device->update(std::move(record));
  EXPECT_EQ(answers(), Texts{"1 undeliverable"});
  EXPECT_EQ(host.all<model::Join>().size(), 1U);
}

}  // namespace
}  // namespace rubicon::networks::zigbee
