#include "commands.h"

// What a network says of a device before its silence ends (Unreachable), and values that it remembers of it.

namespace rubicon::proxy {
namespace {

const std::string kSilentLamp = "proxy.hall.7";
const std::string kSilentGlow = kSilentLamp + ".sensor.glow-1";

class FoundUnreachable : public Commands {
 protected:
  std::string status() const { return json(kSilentLamp + ".status")["status"]; }
  std::string reason() const { return json(kSilentLamp + ".status")["reason"]; }
};

TEST_F(FoundUnreachable, ADeviceIsUnreachableAtOnceWithTheReasonOfItsNetwork) {
  begin();
  report("7", sensor(kGlow), 1.5);
  const auto before = time.wall_now();
  time.run_for(5s);
  say("7", model::Unreachable{"no answer to 3 pings"});
  EXPECT_EQ(status(), "unreachable");
  EXPECT_EQ(reason(), "no answer to 3 pings");
  EXPECT_GT(json(kSilentLamp + ".status")["since"].get<double>(), base::to_seconds(before) + 4);
  EXPECT_EQ(quality(kSilentGlow), "device-offline");
  EXPECT_EQ(text(kSilentGlow + ".value"), "1.5");
  time.run_for(300ms);
  EXPECT_EQ(text("proxy.hall.devices"), "[]");
}

TEST_F(FoundUnreachable, AnySignOfLifeEndsIt) {
  begin();
  const model::Body signs[] = {model::KeepAlive{}, updates(sensor(kGlow), 2.5), lamp()};
  for (const auto& sign : signs) {
    say("7", model::Unreachable{"gone"});
    EXPECT_EQ(status(), "unreachable");
    say("7", sign);
    EXPECT_EQ(status(), "reachable");
    EXPECT_EQ(reason(), "");
  }
}

TEST_F(FoundUnreachable, WorksWithoutSilenceAndOutlastsTheLine) {
  rules().silence = std::nullopt;
  begin();
  say("7", model::Unreachable{"gone"});
  EXPECT_EQ(status(), "unreachable");
  hall().lose_line();
  time.run_for(1s);
  hall().line_works = true;
  time.run_for(5s);
  EXPECT_EQ(json("proxy.hall.status")["line"], "up");
  EXPECT_EQ(status(), "unreachable") << "the line says nothing about the device";
  EXPECT_EQ(reason(), "gone");
  say("7", model::KeepAlive{});
  EXPECT_EQ(status(), "reachable");
}

TEST_F(FoundUnreachable, ADeviceThatWasNotHeardYetIsUnreachableToo) {
  start();
  auto message = lamp();
  message.heard = false;
  join("7", message);
  say("7", model::Unreachable{"gone"});
  EXPECT_EQ(status(), "unreachable");
}

TEST_F(FoundUnreachable, ANewReasonReplacesTheOldOneAndARepeatedOneChangesNothing) {
  begin();
  say("7", model::Unreachable{"gone"});
  const auto since = json(kSilentLamp + ".status")["since"];
  time.run_for(5s);
  int published = 0;
  const auto ears =
      space->subscribe({kIsland, kSilentLamp + ".status"}, {.passive = true}, [&](const Event&) { ++published; });
  time.run_ready();
  published = 0;
  say("7", model::Unreachable{"gone"});
  EXPECT_EQ(published, 0);
  say("7", model::Unreachable{"removed from its socket"});
  EXPECT_EQ(reason(), "removed from its socket");
  EXPECT_EQ(json(kSilentLamp + ".status")["since"], since);
}

TEST_F(FoundUnreachable, OfADeviceThatIsNotListedChangesNothing) {
  start();
  say("7", model::Unreachable{"gone"});
  EXPECT_FALSE(exists(kSilentLamp + ".status"));
  EXPECT_EQ(log.lines.size(), 0U);
}

TEST_F(FoundUnreachable, TheNetworkStillTakesItsCommandsAtOnce) {
  begin();
  say("7", model::Unreachable{"gone"});
  hall().answers = false;
  ASSERT_EQ(set(kFlapCommand, "open").verdict, Verdict::kApplied);
  ASSERT_EQ(actuated().size(), 1U);
  hall().say("7", Acknowledge{actuated()[0].request, Outcome::kUndeliverable, "no answer of the device"});
  time.run_ready();
  EXPECT_EQ(command()["state"], "failed");
  EXPECT_EQ(command()["reason"], "no answer of the device");
}

TEST_F(FoundUnreachable, CommandsThatWaitForASilentDeviceGoToTheNetworkThatKnowsMore) {
  begin();
  sleep();
  set(kFlapCommand, "open");
  EXPECT_TRUE(actuated().empty());
  say("7", model::Unreachable{"gone"});
  EXPECT_EQ(actuated().size(), 1U);
}

TEST_F(FoundUnreachable, ACommandWaitsForTheAnswerOfASlowNetwork) {
  rules().answer_time = 30s;
  begin();
  hall().answers = false;
  set(kFlapCommand, "open", 60s);
  ASSERT_EQ(actuated().size(), 1U);
  EXPECT_EQ(actuated()[0].time_to_live, 30s);
  time.run_for(29s);
  EXPECT_EQ(command()["state"], "queued");
  hall().say("7", Acknowledge{actuated()[0].request, Outcome::kSent, {}});
  time.run_ready();
  EXPECT_EQ(command()["state"], "sent");
  time.run_for(4900ms);
  EXPECT_EQ(command()["state"], "sent");
  time.run_for(200ms);
  EXPECT_EQ(command()["state"], "timed-out");
  EXPECT_EQ(command()["reason"], "no report of the device within 5 s");
  set(kFlapCommand, "open", 60s);
  time.run_for(31s);
  EXPECT_EQ(command()["reason"], "no acknowledgement within 30 s");
}

class Repeated : public Commands {
 protected:
  void repeat(Value value, WallTime when = {}, const PointId& point = sensor(kGlow)) {
    say("7", model::Updates{{{point, std::move(value), when}}, false});
  }
  double user_time(const std::string& point = kSilentGlow) const {
    const auto tuple = space->get(kIsland, point + ".value");
    return tuple ? base::to_seconds(tuple->user_time) : -1;
  }
};

TEST_F(Repeated, AValueThatTheNetworkRemembersIsStoredWithItsTimeAndNoSignOfLife) {
  start();
  auto message = lamp();
  message.heard = false;
  join("7", message);
  const auto when = time.wall_now() - 24h;
  repeat(12.5, when);
  EXPECT_EQ(text(kSilentGlow + ".value"), "12.5");
  EXPECT_EQ(quality(kSilentGlow), "stored");
  EXPECT_EQ(user_time(), base::to_seconds(when));
  EXPECT_EQ(json(kSilentGlow + ".status")["heard"], 0);
  EXPECT_EQ(json(kSilentLamp + ".status")["status"], "unknown");
  say("7", model::Unreachable{"gone"});
  repeat(13.5, when + 1s);
  EXPECT_EQ(json(kSilentLamp + ".status")["status"], "unreachable");
}

TEST_F(Repeated, ANewerValueStays) {
  begin();
  const auto now = time.wall_now();
  report("7", sensor(kGlow), 20.0, now);
  repeat(12.5, now - 1s);
  repeat(12.5, now);
  repeat(12.5);
  EXPECT_EQ(text(kSilentGlow + ".value"), "20");
  EXPECT_EQ(quality(kSilentGlow), "good");
  repeat(12.5, now + 1s);
  EXPECT_EQ(text(kSilentGlow + ".value"), "12.5");
  EXPECT_EQ(quality(kSilentGlow), "stored");
}

TEST_F(Repeated, AReadingWithoutATimeIsDatedByItsArrival) {
  begin();
  report("7", sensor(kGlow), 20.0);
  const auto heard = time.wall_now();
  repeat(12.5, heard - 1s);
  EXPECT_EQ(text(kSilentGlow + ".value"), "20");
  repeat(12.5, heard + 1s);
  EXPECT_EQ(text(kSilentGlow + ".value"), "12.5");
}

TEST_F(Repeated, TheSameValueStaysGood) {
  begin();
  const auto now = time.wall_now();
  report("7", sensor(kGlow), 20.0, now);
  repeat(20.0, now + 1s);
  EXPECT_EQ(quality(kSilentGlow), "good");
  EXPECT_EQ(user_time(), base::to_seconds(now));
}

TEST_F(Repeated, AfterARestartTheNewerOfFileAndNetworkIsShown) {
  remember();
  begin();
  const auto now = time.wall_now();
  report("7", sensor(kGlow), 20.0, now);
  time.run_for(20s);
  restart();
  ASSERT_EQ(quality(kSilentGlow), "stored");
  repeat(12.5, now - 1h);
  EXPECT_EQ(text(kSilentGlow + ".value"), "20");
  repeat(12.5, now + 1s);
  EXPECT_EQ(text(kSilentGlow + ".value"), "12.5");
  EXPECT_EQ(quality(kSilentGlow), "stored");
  report("7", sensor(kGlow), 12.5, now + 2s);
  EXPECT_EQ(quality(kSilentGlow), "good");
}

TEST_F(Repeated, ConfirmsNoCommand) {
  begin();
  set(kFlapCommand, "open");
  ASSERT_EQ(command()["state"], "sent");
  repeat(true, time.wall_now() + 1s, actuator(kFlap));
  EXPECT_EQ(command()["state"], "sent");
}

TEST_F(Repeated, WhatFitsNoPointIsIgnored) {
  begin();
  repeat(std::string("bright"), time.wall_now());
  repeat({}, time.wall_now());
  repeat(1.0, time.wall_now(), sensor(kGlow, "9"));
  EXPECT_EQ(quality(kSilentGlow), "unknown");
  EXPECT_FALSE(exists(kSilentLamp + ".sensor.glow-9.value"));
}

}  // namespace
}  // namespace rubicon::proxy
