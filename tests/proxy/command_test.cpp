#include "proxy/command.h"

#include "commands.h"

namespace rubicon::proxy {
namespace {

TEST_F(Commands, AReportOfTheCommandedValueConfirms) {
  begin();
  record(kFlapPoint);
  EXPECT_EQ(set(kFlapCommand, "open").verdict, Verdict::kApplied);
  ASSERT_EQ(actuated().size(), 1u);
  EXPECT_EQ(actuated()[0].point, actuator(kFlap));
  EXPECT_EQ(actuated()[0].value, Value(true));
  EXPECT_EQ(command_state(kFlapPoint), "sent");
  EXPECT_EQ(text(kFlapPoint + ".value"), "") << "no optimistic echo";
  report("7", actuator(kFlap), true);
  EXPECT_EQ(command_state(kFlapPoint), "confirmed");
  EXPECT_EQ(states, (std::vector<std::string>{"1:queued", "1:sent", "1:confirmed"}));
}

TEST_F(Commands, TheStatusNamesTheCommander) {
  begin();
  set(kFlapCommand, "open");
  EXPECT_EQ(command()["creator"], 70001);
  EXPECT_EQ(command()["request"], 1);
  EXPECT_EQ(command()["value"], "open");
  EXPECT_EQ(space->get(kIsland, kFlapCommand)->creator, kRobot);
  EXPECT_EQ(text(kFlapCommand), "open");
}

TEST_F(Commands, RefusesInsideTheReplyWhatCannotBe) {
  begin();
  const std::string device = "proxy.hall.7.";
  const std::tuple<std::string, std::string, ErrorCode> wrong[] = {
      {device + "actuator.flap-9.command", "open", ErrorCode::kNotFound},
      {"proxy.hall.99.actuator.flap-1.command", "open", ErrorCode::kNotFound},
      {kFlapCommand, "sideways", ErrorCode::kInvalid},
      {kFlapCommand, "", ErrorCode::kInvalid},
      {device + "actuator.knob-1.command", "256", ErrorCode::kOutOfRange},
      {device + "actuator.knob-1.command", "9", ErrorCode::kOutOfRange},
      {device + "actuator.knob-1.command", "201", ErrorCode::kOutOfRange},
      {device + "actuator.knob-1.command", "12.5", ErrorCode::kInvalid},
      {device + "property.mood.command", "day", ErrorCode::kNotFound},
      {device + "actuator.flap-1.value", "open", ErrorCode::kRefused},
      {device + "sensor.glow-1.value", "1", ErrorCode::kRefused},
      {"proxy.hall.status", "up", ErrorCode::kRefused}};
  for (const auto& [key, value, code] : wrong) {
    const auto reply = set(key, value);
    EXPECT_EQ(reply.verdict, Verdict::kRefused) << key << " = " << value;
    EXPECT_EQ(reply.code, code) << key << " = " << value << ": " << reply.text;
    EXPECT_FALSE(reply.text.empty());
  }
  EXPECT_TRUE(actuated().empty());
  EXPECT_EQ(text(kFlapCommand), "");
}

TEST_F(Commands, NothingIsAppendedToWhatTheIslandPublishes) {
  begin();
  set(kFlapCommand, "open");
  const auto sent = actuated().size();
  for (const std::string key : {kFlapCommand.c_str(), "proxy.hall.7.property.knob.command", "proxy.hall.status"}) {
    Reply reply;
    robot->append_remote(kIsland, key, "1", 1s, [&](const Reply& answer) { reply = answer; }, {.media_type = {}});
    time.run_ready();
    EXPECT_EQ(reply.verdict, Verdict::kRefused) << key;
    EXPECT_EQ(reply.code, ErrorCode::kRefused) << key;
    EXPECT_NE(reply.text.find(key + " accepts whole values only"), std::string::npos) << reply.text;
  }
  EXPECT_EQ(text(kFlapCommand), "open");
  EXPECT_EQ(actuated().size(), sent);
}

TEST_F(Commands, ACommandCanRequireThatNoOtherCommandCameMeanwhile) {
  begin();
  set(kFlapCommand, "open");
  const auto seen = space->get(kIsland, kFlapCommand)->sequence;
  set(kFlapCommand, "shut");
  Reply reply;
  const auto ask = [&](std::uint64_t sequence) {
    robot->set_remote(kIsland, kFlapCommand, "open", 1s, [&](const Reply& answer) { reply = answer; },
                      {.expected_sequence = sequence});
    time.run_ready();
    return reply.verdict;
  };
  EXPECT_EQ(ask(seen), Verdict::kRefused);
  EXPECT_EQ(text(kFlapCommand), "shut");
  EXPECT_EQ(ask(reply.sequence), Verdict::kApplied);
  EXPECT_EQ(text(kFlapCommand), "open");
}

TEST_F(Commands, AHugeTextIsRefused) {
  start();
  auto message = lamp();
  message.capabilities.push_back(capability(Kind::kActuator, TypeId{0x9000}));
  message.capabilities.back().type_name = "speech";
  join("7", message);
  EXPECT_EQ(set("proxy.hall.7.actuator.speech-1.command", std::string(100000, 'x')).code, ErrorCode::kOutOfRange);
  EXPECT_EQ(set("proxy.hall.7.actuator.speech-1.command", "hello").verdict, Verdict::kApplied);
  EXPECT_EQ(actuated().back().value, Value(std::string("hello")));
}

TEST_F(Commands, ADeviceThatIgnoresACommandEndsTimedOutWithTheOldValue) {
  begin();
  report("7", actuator(kFlap), false);
  set(kFlapCommand, "open");
  time.run_for(4900ms);
  EXPECT_EQ(command_state(kFlapPoint), "sent");
  time.run_for(200ms);
  EXPECT_EQ(command_state(kFlapPoint), "timed-out");
  EXPECT_EQ(text(kFlapPoint + ".value"), "shut");
  report("7", actuator(kFlap), true);
  EXPECT_EQ(command_state(kFlapPoint), "timed-out") << "final";
  EXPECT_EQ(text(kFlapPoint + ".value"), "open");
}

TEST_F(Commands, ANetworkThatNeverAnswersEndsTimedOut) {
  begin();
  hall().answers = false;
  set(kFlapCommand, "open");
  EXPECT_EQ(command_state(kFlapPoint), "queued");
  time.run_for(5100ms);
  EXPECT_EQ(command_state(kFlapPoint), "timed-out");
  EXPECT_EQ(command()["reason"], "no acknowledgement within 5 s");
  EXPECT_FALSE(command().contains("until")) << "final";
}

TEST_F(Commands, AReportOlderThanTheCommandDoesNotConfirm) {
  begin();
  const auto before = time.wall_now() - 1s;
  set(kFlapCommand, "open");
  report("7", actuator(kFlap), true, before);
  EXPECT_EQ(command_state(kFlapPoint), "sent");
  time.run_for(100ms);
  report("7", actuator(kFlap), true, time.wall_now());
  EXPECT_EQ(command_state(kFlapPoint), "confirmed");
}

TEST_F(Commands, AReportConfirmsThoughTheClockWasSetBackSinceTheCommand) {
  begin();
  set(kFlapCommand, "open");
  time.run_for(100ms);
  const auto before = time.wall_now() - 200ms;
  time.set_wall(time.wall_now() - 1h);
  report("7", actuator(kFlap), true, before);
  EXPECT_EQ(command_state(kFlapPoint), "sent") << "older than the command, by the clock of then";
  report("7", actuator(kFlap), true, time.wall_now() - 200ms);
  EXPECT_EQ(command_state(kFlapPoint), "sent") << "older than the command";
  report("7", actuator(kFlap), true, time.wall_now());
  EXPECT_EQ(command_state(kFlapPoint), "confirmed");
}

TEST_F(Commands, AReportOfBeforeTheClockWasSetForwardConfirms) {
  begin();
  set(kFlapCommand, "open");
  time.run_for(100ms);
  const auto measured = time.wall_now();
  time.set_wall(measured + 1h);
  report("7", actuator(kFlap), true, measured);
  EXPECT_EQ(command_state(kFlapPoint), "confirmed");
}

TEST_F(Commands, AReportThatWasUnderWayBeforeTheCommandDoesNotConfirm) {
  begin();
  hall().answers = false;
  hall().say("7", updates(actuator(kFlap), true));
  set(kFlapCommand, "open");
  report("7", actuator(kFlap), true);
  EXPECT_EQ(command_state(kFlapPoint), "queued") << "not acknowledged: the report may be older";
}

TEST_F(Commands, AReportOfAnotherValueDoesNotConfirm) {
  begin();
  set(kFlapCommand, "open");
  report("7", actuator(kFlap), false);
  EXPECT_EQ(command_state(kFlapPoint), "sent");
  report("7", sensor(kGlow), 1.0);
  EXPECT_EQ(command_state(kFlapPoint), "sent");
}

TEST_F(Commands, ANumberConfirmsWithinAThousandth) {
  EXPECT_TRUE(confirms(Value(20.0), Value(20.0)));
  EXPECT_TRUE(confirms(Value(20.02), Value(20.0)));
  EXPECT_TRUE(confirms(Value(-19.99), Value(-20.0)));
  EXPECT_TRUE(confirms(Value(std::int64_t{20}), Value(20.01)));
  for (const double other : {10.0, 30.0, 20.1, 19.9, -20.0, 0.0}) {
    EXPECT_FALSE(confirms(Value(other), Value(20.0))) << other;
  }
  EXPECT_FALSE(confirms(Value(0.001), Value(0.0)));
  EXPECT_FALSE(confirms(Value(std::int64_t{10'000}), Value(std::int64_t{10'001}))) << "whole numbers are equal or not";
  EXPECT_FALSE(confirms(Value(std::string("20")), Value(std::string("2"))));
}

TEST_F(Commands, AnActuatorThatNeverReportsEndsAssumed) {
  begin();
  set("proxy.hall.7.actuator.mood-1.command", "night");
  EXPECT_EQ(command_state("proxy.hall.7.actuator.mood-1"), "assumed");
  EXPECT_EQ(text("proxy.hall.7.actuator.mood-1.value"), "night");
  EXPECT_EQ(quality("proxy.hall.7.actuator.mood-1"), "assumed");
  EXPECT_EQ(json("proxy.hall.7.actuator.mood-1.status")["heard"], 0);
}

TEST_F(Commands, TheAnswerOfTheNetworkDecidesTheState) {
  begin();
  const std::pair<Outcome, std::string> cases[] = {{Outcome::kFailed, "failed"},
                                                   {Outcome::kRefused, "refused"},
                                                   {Outcome::kUnsupported, "refused"},
                                                   {Outcome::kBusy, "refused"},
                                                   {Outcome::kUndeliverable, "failed"}};
  for (const auto& [outcome, state] : cases) {
    hall().outcome = outcome;
    hall().why = "because";
    set(kFlapCommand, "open");
    EXPECT_EQ(command_state(kFlapPoint), state);
    EXPECT_EQ(command()["reason"], "because");
    EXPECT_EQ(text(kFlapPoint + ".value"), "");
  }
}

TEST_F(Commands, ANewerCommandSupersedesAnUnconfirmedOne) {
  begin();
  record(kFlapPoint);
  set(kFlapCommand, "open");
  set(kFlapCommand, "shut");
  EXPECT_EQ(states, (std::vector<std::string>{"1:queued", "1:sent", "1:superseded", "2:queued", "2:sent"}));
  report("7", actuator(kFlap), true);
  EXPECT_EQ(command_state(kFlapPoint), "sent");
  report("7", actuator(kFlap), false);
  EXPECT_EQ(command_state(kFlapPoint), "confirmed");
}

TEST_F(Commands, OfThreeCommandsToASleepingDeviceTheLastOneIsDelivered) {
  begin();
  sleep();
  record(kFlapPoint);
  EXPECT_EQ(set(kFlapCommand, "open").verdict, Verdict::kApplied);
  set(kFlapCommand, "shut");
  set(kFlapCommand, "open");
  EXPECT_TRUE(actuated().empty());
  EXPECT_EQ(command_state(kFlapPoint), "queued");
  say("7", model::KeepAlive{});
  ASSERT_EQ(actuated().size(), 1u);
  EXPECT_EQ(actuated()[0].value, Value(true));
  EXPECT_EQ(states,
            (std::vector<std::string>{"1:queued", "1:superseded", "2:queued", "2:superseded", "3:queued", "3:sent"}));
}

TEST_F(Commands, EventsKeepTheirOrderAndAreAllDelivered) {
  begin();
  sleep();
  for (const auto* step : {"3", "1", "2"}) set("proxy.hall.7.actuator.chime-1.command", step);
  set(kFlapCommand, "open");
  say("7", model::KeepAlive{});
  const auto sent = actuated();
  ASSERT_EQ(sent.size(), 4u);
  EXPECT_EQ(sent[0].value, Value(std::int64_t{3}));
  EXPECT_EQ(sent[1].value, Value(std::int64_t{1}));
  EXPECT_EQ(sent[2].value, Value(std::int64_t{2}));
  EXPECT_EQ(sent[3].value, Value(true));
}

TEST_F(Commands, ACommandIsSentOnceHoweverOftenTheDeviceReturns) {
  begin();
  sleep();
  set(kFlapCommand, "open");
  for (int i = 0; i < 3; ++i) {
    say("7", model::KeepAlive{});
    join("7", lamp());
    time.run_for(61s);
  }
  EXPECT_EQ(actuated().size(), 1u);
}

TEST_F(Commands, ADeviceThatReturnsWhileItsCommandIsUnderWayIsNotSentItAgain) {
  config.confirmation_wait = 10min;
  begin();
  sleep();
  set(kFlapCommand, "open");
  say("7", model::KeepAlive{});
  time.run_for(10ms);
  ASSERT_EQ(actuated().size(), 1u);
  for (int i = 0; i < 3; ++i) {
    sleep();
    say("7", model::KeepAlive{});
    join("7", lamp());
    time.run_for(10ms);
    EXPECT_EQ(command_state(kFlapPoint), "sent");
  }
  EXPECT_EQ(actuated().size(), 1u);
}

TEST_F(Commands, TheNetworkIsGivenNoMoreTimeThanTheIslandWaits) {
  begin();
  set(kFlapCommand, "open", 1h);
  ASSERT_EQ(actuated().size(), 1u);
  EXPECT_EQ(actuated()[0].time_to_live, 5s) << "the wait for a confirmation";
  set(kFlapCommand, "shut", 2s);
  ASSERT_EQ(actuated().size(), 2u);
  EXPECT_EQ(actuated()[1].time_to_live, 2s);
  sleep();
  set(kFlapCommand, "open", 30s);
  time.run_for(27s);
  say("7", model::KeepAlive{});
  time.run_for(10ms);
  ASSERT_EQ(actuated().size(), 3u);
  EXPECT_GT(actuated()[2].time_to_live, 2900ms);
  EXPECT_LE(actuated()[2].time_to_live, 3s) << "what is left of it";
}

TEST_F(Commands, AFullQueueRefusesBusy) {
  begin();
  sleep();
  for (int i = 0; i < 100; ++i) {
    ASSERT_EQ(set("proxy.hall.7.actuator.chime-1.command", "1").verdict, Verdict::kApplied) << i;
  }
  const auto reply = set("proxy.hall.7.actuator.chime-1.command", "1");
  EXPECT_EQ(reply.verdict, Verdict::kRefused);
  EXPECT_EQ(reply.code, ErrorCode::kBusy);
  time.run_for(61s);
  EXPECT_EQ(set("proxy.hall.7.actuator.chime-1.command", "1").verdict, Verdict::kApplied) << "room again";
}

TEST_F(Commands, AFloodInOneTurnIsBoundedToo) {
  begin();
  int applied = 0, busy = 0;
  for (int i = 0; i < 300; ++i) {
    robot->set_remote(kIsland, "proxy.hall.7.actuator.chime-1.command", "1", 0s,
                      [&](const Reply& reply) { ++(reply.verdict == Verdict::kApplied ? applied : busy); });
  }
  time.run_ready();
  EXPECT_EQ(applied, 100);
  EXPECT_EQ(busy, 200);
}

TEST_F(Commands, OfDevicesThatLeftTakeNoRoomOnTheIsland) {
  begin();
  hall().answers = false;
  auto bell = lamp();
  bell.capabilities.push_back(capability(Kind::kActuator, kChime));
  for (int round = 0; round < 101; ++round) {  // a hundred commands each: more than the island keeps
    for (int i = 0; i < 100; ++i) robot->set_remote(kIsland, "proxy.hall.7.actuator.chime-1.command", "1", 0s, {});
    time.run_ready();
    say("7", model::Leave{});
    join("7", bell);
  }
  EXPECT_EQ(set("proxy.hall.7.actuator.chime-1.command", "1").verdict, Verdict::kApplied);
}

TEST_F(Commands, APropertyIsSetAndConfirmedLikeAnActuator) {
  begin();
  EXPECT_EQ(set("proxy.hall.7.property.knob.command", "12").verdict, Verdict::kApplied);
  const auto sent = hall().sent_bodies<model::SetProperty>();
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sent[0].value, Value(std::int64_t{12}));
  report("7", {Kind::kProperty, kKnob, ""}, std::int64_t{12});
  EXPECT_EQ(command_state("proxy.hall.7.property.knob"), "confirmed");
  EXPECT_EQ(text("proxy.hall.7.property.knob.value"), "12");
}

TEST_F(Commands, CommandsEndWithTheirDevice) {
  begin();
  sleep();
  set(kFlapCommand, "open");
  say("7", model::Leave{""});
  join("7", lamp());
  time.run_for(10s);
  EXPECT_TRUE(actuated().empty());
  EXPECT_EQ(command_state(kFlapPoint), "none");
}

TEST_F(Commands, CommandsEndWithTheirPoint) {
  begin();
  hall().answers = false;
  set(kFlapCommand, "open");
  auto without = lamp();
  without.capabilities.pop_back();
  join("7", without);
  time.run_for(10s);
  EXPECT_FALSE(exists(kFlapCommand));
}

TEST_F(Commands, AnAnswerToAnUnknownRequestIsIgnored) {
  begin();
  set(kFlapCommand, "open");
  say("7", Acknowledge{999999, Outcome::kFailed, "?"});
  EXPECT_EQ(command_state(kFlapPoint), "sent");
}

TEST_F(Commands, TheIslandMayCommandItself) {
  begin();
  Reply reply;
  space->set_remote(kIsland, kFlapCommand, "open", 0s, [&](const Reply& answer) { reply = answer; });
  time.run_ready();
  EXPECT_EQ(reply.verdict, Verdict::kApplied);
  EXPECT_EQ(command()["creator"], 6541);
}

TEST_F(Commands, OfTwoCommandersEachFindsItsOwnOutcome) {
  begin();
  record(kFlapPoint);
  set(kFlapCommand, "open");
  space->set_remote(kIsland, kFlapCommand, "shut", 0s, [](const Reply&) {});
  time.run_ready();
  report("7", actuator(kFlap), false);
  EXPECT_EQ(command()["creator"], 6541);
  EXPECT_EQ(command()["state"], "confirmed");
  EXPECT_THAT(states, ::testing::Contains("1:superseded"));
}

class Rate : public Island {
 protected:
  void begin(Value initial) {
    const auto* rate = types.find("rate");
    ASSERT_NE(rate, nullptr);
    start();
    auto message = lamp();
    message.capabilities.push_back(capability(Kind::kProperty, rate->id, ""));
    message.capabilities.back().initial = std::move(initial);
    join("7", message);
  }
  const std::string rate_point = "proxy.hall.7.property.rate";
};

TEST_F(Rate, StartsWithTheRateOfTheDeviceElseOfTheNetwork) {
  begin(std::int64_t{400});
  EXPECT_EQ(text(rate_point + ".value"), "400");
  auto message = lamp();
  message.capabilities.push_back(capability(Kind::kProperty, types.find("rate")->id, ""));
  join("8", message);
  EXPECT_EQ(text("proxy.hall.8.property.rate.value"), "1000");
}

TEST_F(Rate, IsSetByCommandAndResamples) {
  begin({});
  auto ears = robot->subscribe({std::nullopt, "proxy.hall.7.sensor.**"}, {}, [](const Event&) {});
  time.run_ready();
  EXPECT_EQ(hall().sampled["7"].period, 1000ms);
  EXPECT_EQ(set(rate_point + ".command", "250").verdict, Verdict::kApplied);
  EXPECT_EQ(text(rate_point + ".value"), "250");
  EXPECT_EQ(command_state(rate_point), "confirmed");
  EXPECT_EQ(hall().sampled["7"].period, 250ms);
  EXPECT_TRUE(hall().sent_bodies<model::SetProperty>().empty());
}

TEST_F(Rate, IsSetUnderTheNameOfTheTextOfD14Too) {
  begin({});
  EXPECT_EQ(set("proxy.hall.7.property.sampling-rate.command", "250").verdict, Verdict::kApplied);
  EXPECT_EQ(text(rate_point + ".value"), "250");
  EXPECT_EQ(text(rate_point + ".command"), "250");
  EXPECT_EQ(command_state(rate_point), "confirmed");
  EXPECT_FALSE(exists("proxy.hall.7.property.sampling-rate.command"));
  EXPECT_TRUE(log.contain(rate_point + " = '250' by component 70001")) << "the log has one name for it";
}

TEST_F(Rate, YieldsToASubscriberThatNamesAPeriod) {
  begin({});
  auto ears = robot->subscribe({std::nullopt, "proxy.hall.7.sensor.**"}, {.minimum = 100ms}, [](const Event&) {});
  time.run_ready();
  set(rate_point + ".command", "250");
  EXPECT_EQ(hall().sampled["7"].period, 100ms);
}

TEST_F(Rate, SurvivesARejoin) {
  begin(std::int64_t{400});
  set(rate_point + ".command", "250");
  auto message = lamp();
  message.capabilities.push_back(capability(Kind::kProperty, types.find("rate")->id, ""));
  message.capabilities.back().initial = std::int64_t{400};
  join("7", message);
  EXPECT_EQ(text(rate_point + ".value"), "250");
}

TEST_F(Rate, MustBePositive) {
  begin({});
  EXPECT_EQ(set(rate_point + ".command", "0").code, ErrorCode::kOutOfRange);
  EXPECT_EQ(text(rate_point + ".value"), "1000");
}

}  // namespace
}  // namespace rubicon::proxy
