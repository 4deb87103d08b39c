#include "commands.h"

// What a command waits for and how long, and the name of its commander.

namespace rubicon::proxy {
namespace {

TEST_F(Commands, ShowWhatTheyWaitForAndUntilWhen) {
  begin();
  const auto seconds_left = [&] {
    return command()["until"].get<double>() - static_cast<double>(time.wall_now().time_since_epoch().count()) / 1e6;
  };
  hall().answers = false;
  set(kFlapCommand, "open");
  EXPECT_EQ(command()["reason"], "waits for the acknowledgement of hall");
  EXPECT_NEAR(seconds_left(), 5, 0.01);
  hall().answers = true;
  set(kFlapCommand, "shut");
  EXPECT_EQ(command()["state"], "sent");
  EXPECT_EQ(command()["reason"], "waits for the device's report");
  EXPECT_NEAR(seconds_left(), 5, 0.01);
  sleep();
  set(kFlapCommand, "open", 90s);
  EXPECT_EQ(command()["reason"], "the device is unreachable: silent for 60 s");
  EXPECT_NEAR(seconds_left(), 90, 0.01);
  hall().lose_line();
  time.run_for(10ms);
  EXPECT_THAT(command()["reason"].get<std::string>(), ::testing::StartsWith("the line is down"));
}

TEST_F(Commands, WithoutATimeToLiveAreNotCarriedOutAfterTheDocumentedFiveSeconds) {
  begin();
  sleep();
  record(kFlapPoint);
  set(kFlapCommand, "open");
  time.run_for(4900ms);
  EXPECT_EQ(command_state(kFlapPoint), "queued");
  time.run_for(200ms);
  EXPECT_EQ(states, (std::vector<std::string>{"1:queued", "1:expired"}));
  EXPECT_EQ(command()["reason"], "not sent within 5 s: the device is unreachable: silent for 60 s");
  say("7", model::KeepAlive{});
  EXPECT_TRUE(actuated().empty());
}

TEST_F(Commands, OfForeignProgramsWithoutATimeToLiveGetTheIslandsOwn) {
  config.command_time_to_live = 2s;
  begin();
  sleep();
  gateway::Gateway abroad(time, *robot, log);
  Message message;
  message.destination = {kIsland, "hall", "7"};
  message.body = model::Actuate{4, actuator(kFlap), true};
  abroad.send(std::move(message));
  time.run_for(1900ms);
  EXPECT_EQ(command_state(kFlapPoint), "queued");
  time.run_for(200ms);
  EXPECT_EQ(command_state(kFlapPoint), "expired");
}

TEST_F(Commands, NameTheirCommander) {
  ASSERT_TRUE(robot->describe(R"({"name":"rubicon set","host":"desk","program":"pid 4 of anna"})"));
  config.host = "desk";
  config.island_name = "flat";
  begin();
  set(kFlapCommand, "open");
  EXPECT_EQ(command()["commander"], "rubicon set (pid 4 of anna)");
  space->set_remote(kIsland, kFlapCommand, "shut", 0s, [](const Reply&) {});
  time.run_ready();
  EXPECT_EQ(command()["commander"], "flat (island 6541)");
  EXPECT_TRUE(log.contain(kFlapPoint + " = 'open' by rubicon set (pid 4 of anna), id 70001: superseded after 0.00 s: "
                                       "by flat (island 6541)"))
      << log.lines.back();
}

TEST_F(Commands, TheSupersedingCommandIsNamedForProgramsToo) {
  nlohmann::json by;
  begin();
  hall().answers = false;
  set(kFlapCommand, "open");
  auto ear = space->subscribe({kIsland, kFlapPoint + ".status"}, {.passive = true}, [&](const Event& event) {
    const auto status = nlohmann::json::parse(event.tuple.value)["command"];
    if (status["state"] == "superseded") by = status["by"];
  });
  time.run_ready();
  set(kFlapCommand, "shut");
  EXPECT_EQ(by, nlohmann::json({{"creator", 70001}, {"commander", "component 70001"}, {"request", 2}}));
}

TEST_F(Commands, OfAComponentOnAnotherHostAreNamedWithIt) {
  ASSERT_TRUE(robot->describe(R"({"name":"robot\n","host":"dock","program":"pid 9 of root"})"));
  config.host = "desk";
  begin();
  set(kFlapCommand, "open");
  EXPECT_EQ(command()["commander"], "robot? (pid 9 of root on dock)");
}

TEST_F(Commands, NameTheirCommanderInCharactersThatDoNotSteerATerminal) {
  std::string umlauts;
  for (int i = 0; i < 40; ++i) umlauts += "\u00e4";
  ASSERT_TRUE(robot->describe("{\"name\":\"\u202etoor\u0085\",\"host\":\"desk\",\"program\":\"x" + umlauts + "\"}"));
  config.host = "desk";
  begin();
  set(kFlapCommand, "open");
  EXPECT_EQ(command()["commander"], "?toor? (x" + umlauts.substr(0, 58) + ")") << "29 whole characters of two bytes";
}

TEST_F(Commands, LeaveOneLineInTheLogWithTheirOutcome) {
  begin();
  set(kFlapCommand, "open");
  time.run_for(500ms);
  report("7", actuator(kFlap), true);
  EXPECT_TRUE(log.contain(kFlapPoint + " = 'open' by component 70001, id 70001: confirmed after 0.50 s"));
  set(kFlapCommand, "shut");
  say("7", model::Leave{""});
  EXPECT_TRUE(
      log.contain(kFlapPoint + " = 'shut' by component 70001, id 70001: dropped after 0.00 s: its device left"));
}

TEST_F(Commands, OfTheIslandsLastTurnLeaveTheirLineInTheLogToo) {
  begin();
  std::function<void()> end_when_accepted = [&] {
    text(kFlapCommand) == "open" ? proxy.reset() : time.post(end_when_accepted);
  };
  time.post(end_when_accepted);
  set(kFlapCommand, "open");
  EXPECT_TRUE(
      log.contain(kFlapPoint + " = 'open' by component 70001, id 70001: dropped after 0.00 s: the island ends"));
}

TEST_F(Commands, InAFloodAreCountedInTheLog) {
  begin();
  const auto before = log.lines.size();
  for (int i = 0; i < 1000; ++i) set("proxy.hall.7.actuator.mood-1.command", "night");
  EXPECT_LE(log.lines.size() - before, 60u);
  time.run_for(11s);
  EXPECT_TRUE(log.contain("950 more commands ended within 10 s: 950 assumed"));
  set("proxy.hall.7.actuator.mood-1.command", "night");
  EXPECT_THAT(log.lines.back(), ::testing::HasSubstr("assumed after")) << "a new window";
}

TEST_F(Commands, NoneWaitsLongerThanTheQueueExpiry) {
  config.queue_expiry = 30s;
  begin();
  sleep();
  set(kFlapCommand, "open", 10min);
  time.run_for(29s);
  EXPECT_EQ(command_state(kFlapPoint), "queued");
  time.run_for(2s);
  EXPECT_EQ(command_state(kFlapPoint), "expired");
  say("7", model::KeepAlive{});
  EXPECT_TRUE(actuated().empty());
}

TEST_F(Commands, ATimeToLiveThatIsNamedBoundsTheWait) {
  begin();
  sleep();
  set(kFlapCommand, "open", 2s);
  time.run_for(2100ms);
  EXPECT_EQ(command_state(kFlapPoint), "expired");
}

TEST_F(Commands, AreNotSentToADeviceThatReturnsWhenTheirTimeIsOver) {
  begin();
  sleep();
  const auto return_of_7 = time.at(time.now() + 2s, [this] { hall().say("7", model::KeepAlive{}); });
  set(kFlapCommand, "open", 2s);
  set("proxy.hall.7.actuator.chime-1.command", "1", 2s);
  set("proxy.hall.7.actuator.chime-1.command", "2", 3s);
  time.run_for(2s);
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "reachable") << "heard before the timer of the command";
  EXPECT_EQ(command()["state"], "expired");
  EXPECT_EQ(command()["reason"], "not sent within 2 s: the device is unreachable: silent for 60 s");
  ASSERT_EQ(actuated().size(), 1u);
  EXPECT_EQ(actuated()[0].value, Value(std::int64_t{2})) << "that one still has a second";
}

TEST_F(Commands, AreNotCarriedOutAfterAStopOfTheIslandThatTookAllTheirTime) {
  begin();
  std::function<void()> stop_when_accepted = [&] {
    text(kFlapCommand) == "open" ? time.stop_for(3s) : time.post(stop_when_accepted);
  };
  time.post(stop_when_accepted);
  set(kFlapCommand, "open", 2s);
  EXPECT_TRUE(actuated().empty());
  EXPECT_EQ(command()["state"], "expired");
  EXPECT_EQ(command()["reason"], "not sent within 2 s");
}

TEST_F(Commands, ADoorDoesNotOpenWhenTheCableIsMendedAnHourLater) {
  begin();
  hall().lose_line();
  time.run_for(10ms);
  EXPECT_EQ(set(kFlapCommand, "open").verdict, Verdict::kApplied);
  EXPECT_EQ(command_state(kFlapPoint), "queued");
  time.run_for(5100ms);
  EXPECT_EQ(command_state(kFlapPoint), "expired");
  hall().line_works = true;
  time.run_for(1h);
  EXPECT_TRUE(actuated().empty());
}

TEST_F(Commands, AShortInterruptionOfTheLineDelaysACommand) {
  begin();
  hall().lose_line();
  time.run_for(10ms);
  set(kFlapCommand, "open", 30s);
  hall().line_works = true;
  time.run_for(5s);
  EXPECT_EQ(actuated().size(), 1u);
}

}  // namespace
}  // namespace rubicon::proxy
