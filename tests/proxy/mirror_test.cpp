#include "island.h"

namespace rubicon::proxy {
namespace {

const std::string kPoint = "proxy.hall.7.sensor.glow-1";

class Mirror : public Island {
 protected:
  void begin() {
    start();
    join("7", lamp());
  }
  double field(const std::string& name) const { return json(kPoint + ".status")[name]; }
};

TEST_F(Mirror, AReadingBecomesATextValue) {
  begin();
  report("7", sensor(kGlow), 686.6);
  EXPECT_EQ(text(kPoint + ".value"), "686.6");
  EXPECT_EQ(quality(kPoint), "good");
  EXPECT_EQ(space->get(kIsland, kPoint + ".value")->media_type, "text/plain");
}

class Chimes : public Island {
 protected:
  const std::string kChimes = "proxy.hall.7.sensor.chime-1";
  void chime(std::int64_t tune) { report("7", sensor(kChime), tune); }
  Join with_chime() const {
    auto device = lamp();
    device.capabilities.push_back(capability(Kind::kSensor, kChime));
    return device;
  }
};

TEST_F(Chimes, AnEventIsOverAfterTwoSecondsSoThatALaterSubscriberFindsNone) {
  start();
  join("7", with_chime());
  std::vector<std::string> seen, late;
  const auto ears = space->subscribe({kIsland, kChimes + ".value"}, {.passive = true},
                                     [&](const Event& event) { seen.emplace_back(event.tuple.value); });
  time.run_ready();
  seen.clear();
  chime(3);
  time.run_for(1500ms);
  chime(3);  // each of two equal ones counts
  const auto last = base::to_seconds(time.wall_now());
  time.run_for(1900ms);
  EXPECT_EQ(seen, (std::vector<std::string>{"3", "3"})) << "the second began the two seconds again";
  time.run_for(200ms);
  EXPECT_EQ(seen, (std::vector<std::string>{"3", "3", ""}));
  const auto later = space->subscribe({kIsland, kChimes + ".value"}, {.passive = true},
                                      [&](const Event& event) { late.emplace_back(event.tuple.value); });
  time.run_for(1s);
  EXPECT_EQ(late, std::vector<std::string>{""});
  EXPECT_EQ(quality(kChimes), "good");
  EXPECT_EQ(json(kChimes + ".status")["heard"], last);
  EXPECT_EQ(json(kChimes + ".status")["changed"], last);
  time.run_for(1h);
  EXPECT_EQ(seen.size(), 3U);
  chime(4);
  time.run_ready();
  EXPECT_EQ(seen.back(), "4");
}

TEST_F(Chimes, AnEventOfADeviceThatLeavesEndsWithIt) {
  start();
  join("7", with_chime());
  chime(3);
  say("7", model::Leave{});
  time.run_for(500ms);
  join("7", with_chime());
  EXPECT_EQ(text(kChimes + ".value"), "");
  time.run_for(1s);
  chime(5);
  time.run_for(1s);  // 2.5 s after the first one
  EXPECT_EQ(text(kChimes + ".value"), "5") << "the end of the first one is not that of this one";
}

TEST_F(Chimes, AnEventFromBeforeARestartIsNotThereButItsTimeIs) {
  remember();
  start();
  join("7", with_chime());
  chime(3);
  const auto heard = json(kChimes + ".status")["heard"].get<double>();
  restart();
  time.run_ready();
  EXPECT_EQ(text(kChimes + ".value"), "");
  EXPECT_DOUBLE_EQ(json(kChimes + ".status")["heard"].get<double>(), heard);
}

TEST_F(Chimes, AnEventThatANetworkRemembersIsNoNews) {
  start();
  join("7", with_chime());
  model::Updates remembered;
  remembered.heard = false;
  remembered.readings.push_back({sensor(kChime), std::int64_t{3}, time.wall_now(), {}});
  say("7", remembered);
  EXPECT_EQ(text(kChimes + ".value"), "");
  EXPECT_EQ(quality(kChimes), "unknown");
}

TEST_F(Mirror, ABooleanIsSpelledByTheWordsOfItsType) {
  begin();
  report("7", actuator(kFlap), true);
  EXPECT_EQ(text("proxy.hall.7.actuator.flap-1.value"), "open");
  report("7", actuator(kFlap), false);
  EXPECT_EQ(text("proxy.hall.7.actuator.flap-1.value"), "shut");
}

TEST_F(Mirror, TheUserTimeIsThatOfTheMeasurement) {
  begin();
  const auto measured = time.wall_now() - 3s;
  report("7", sensor(kGlow), 1.5, measured);
  EXPECT_EQ(space->get(kIsland, kPoint + ".value")->user_time, measured);
  report("7", sensor(kGlow), 1.5);
  EXPECT_EQ(space->get(kIsland, kPoint + ".value")->user_time, WallTime{});
}

TEST_F(Mirror, HeardAndChangedAreNeverConfused) {
  begin();
  EXPECT_EQ(field("heard"), 0);
  report("7", sensor(kGlow), 1.5);
  const auto first = base::to_seconds(time.wall_now());
  EXPECT_EQ(field("heard"), first);
  EXPECT_EQ(field("changed"), first);
  time.run_for(10s);
  const auto before = space->get(kIsland, kPoint + ".value")->sequence;
  report("7", sensor(kGlow), 1.5);
  time.run_for(1s);
  EXPECT_EQ(field("changed"), first);
  EXPECT_EQ(field("heard"), first + 10);
  EXPECT_EQ(field("since"), first);
  EXPECT_EQ(space->get(kIsland, kPoint + ".value")->sequence, before + 1);
}

TEST_F(Mirror, RefreshesOfHeardArePublishedAtMostOnceASecond) {
  begin();
  report("7", sensor(kGlow), 1.5);
  int sets = 0;
  const auto ears = space->subscribe({kIsland, kPoint + ".status"}, {.passive = true}, [&](const Event&) { ++sets; });
  time.run_for(1s);
  sets = 0;
  for (int i = 0; i < 100; ++i) {
    report("7", sensor(kGlow), 1.5 + i % 2);
    time.run_for(100ms);
  }
  EXPECT_GE(sets, 9);
  EXPECT_LE(sets, 11);
}

TEST_F(Mirror, AValueThatDoesNotFitIsBadAndTheLastGoodOneStays) {
  begin();
  report("7", sensor(kGlow), 1.5);
  report("7", sensor(kGlow), 5000.0);
  EXPECT_EQ(text(kPoint + ".value"), "1.5");
  EXPECT_EQ(quality(kPoint), "bad");
  EXPECT_NE(json(kPoint + ".status")["reason"], "");
  report("7", sensor(kGlow), std::string("hot"));
  EXPECT_EQ(quality(kPoint), "bad");
  report("7", sensor(kGlow), std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(quality(kPoint), "bad");
  report("7", sensor(kGlow), 2.5);
  EXPECT_EQ(quality(kPoint), "good");
  EXPECT_EQ(json(kPoint + ".status")["reason"], "");
  time.run_for(1s);
  EXPECT_EQ(text("proxy.hall.property.bad-values.value"), "3");
}

TEST_F(Mirror, AReadingWithoutAValueIsBad) {
  begin();
  report("7", sensor(kGlow), {});
  EXPECT_EQ(quality(kPoint), "bad");
}

TEST_F(Mirror, AReadingWithoutAValueMayGiveTheReason) {
  begin();
  model::Updates wrong;
  wrong.readings.push_back({sensor(kGlow), {}, {}, "telegram 0c: 1 octet, expected 2"});
  say("7", wrong);
  EXPECT_EQ(json(std::string(kPoint) + ".status")["reason"], "telegram 0c: 1 octet, expected 2");
  report("7", sensor(kGlow), {});
  EXPECT_EQ(json(std::string(kPoint) + ".status")["reason"], "the device has no value");
}

TEST_F(Mirror, ALineThatIsRefusedShowsNetworkDown) {
  begin();
  report("7", sensor(kGlow), 12.5);
  say("", model::State{model::LineState::kRefused, "all tunnels are in use (status 24)", {}});
  EXPECT_EQ(quality(kPoint), "network-down");
  EXPECT_EQ(json("proxy.hall.status")["line"], "refused");
  EXPECT_EQ(json("proxy.hall.status")["reason"], "all tunnels are in use (status 24)");
  EXPECT_EQ(text("proxy.hall.property.line.value"), "refused");
}

TEST_F(Mirror, StructuredValuesAreJson) {
  start();
  auto message = lamp();
  message.capabilities.push_back(capability(Kind::kSensor, TypeId{0x9000}));
  message.capabilities.back().type_name = "posture";
  join("7", message);
  report("7", sensor(TypeId{0x9000}), model::Json{R"({"x":1})"});
  const auto tuple = space->get(kIsland, "proxy.hall.7.sensor.posture-1.value");
  ASSERT_TRUE(tuple);
  EXPECT_EQ(tuple->value, R"({"x":1})");
  EXPECT_EQ(tuple->media_type, "application/json");
}

TEST_F(Mirror, ALostLineShowsNetworkDownAndComesBackStale) {
  begin();
  report("7", sensor(kGlow, "1"), 1.5);
  hall().lose_line();
  time.run_for(1s);
  EXPECT_EQ(quality(kPoint), "network-down");
  EXPECT_EQ(quality("proxy.hall.7.sensor.glow-2"), "network-down");
  EXPECT_NE(json("proxy.hall.status")["line"], "up");
  EXPECT_EQ(text(kPoint + ".value"), "1.5");
  hall().line_works = true;
  time.run_for(5s);
  EXPECT_EQ(json("proxy.hall.status")["line"], "up");
  EXPECT_EQ(quality(kPoint), "stale");
  EXPECT_EQ(quality("proxy.hall.7.sensor.glow-2"), "unknown");
  report("7", sensor(kGlow, "1"), 1.5);
  EXPECT_EQ(quality(kPoint), "good");
}

TEST_F(Mirror, AnEndedRecordingShowsNetworkDown) {
  begin();
  report("7", sensor(kGlow, "1"), 1.5);
  say("", model::State{model::LineState::kEnded, "end of file", {}});
  EXPECT_EQ(quality(kPoint), "network-down");
  EXPECT_EQ(json(kPoint + ".status")["reason"], "end of file");
  EXPECT_EQ(json("proxy.hall.status")["line"], "ended");
}

TEST_F(Mirror, ALineThatGoesDownUnderTenThousandPointsIsShownInSlices) {
  start();
  for (int device = 0; device < 5000; ++device) hall().say(std::to_string(device), lamp());
  time.run_ready();
  hall().lose_line();
  time.run_for(1s);
  int down = 0;
  space->list({kIsland, "proxy.hall.*.sensor.*.status"}, [&](const tuples::TupleView& tuple) {
    if (tuple.value.find("network-down") != tuple.value.npos) ++down;
  });
  EXPECT_EQ(down, 10000);
}

TEST_F(Mirror, AValueKnownAtTheJoinIsPublished) {
  start();
  auto message = lamp();
  message.capabilities.push_back(capability(Kind::kProperty, kKnob, ""));
  message.capabilities.back().initial = std::int64_t{12};
  join("7", message);
  EXPECT_EQ(text("proxy.hall.7.property.knob.value"), "12");
  EXPECT_EQ(quality("proxy.hall.7.property.knob"), "good");
  EXPECT_TRUE(exists("proxy.hall.7.property.knob.command"));
}

TEST_F(Mirror, APropertyStaysGoodThroughAnInterruptionOfTheLine) {
  start();
  auto message = lamp();
  message.capabilities.push_back(capability(Kind::kProperty, kKnob, ""));
  message.capabilities.back().initial = std::int64_t{12};
  join("7", message);
  report("7", sensor(kGlow), 1.5);
  hall().lose_line();
  time.run_for(1s);
  hall().line_works = true;
  time.run_for(5s);
  EXPECT_EQ(quality("proxy.hall.7.sensor.glow-1"), "stale");
  EXPECT_EQ(quality("proxy.hall.7.property.knob"), "good") << "nothing but a command changes it";
}

TEST_F(Mirror, AReadOnlyPropertyHasNoCommand) {
  start();
  auto message = lamp();
  message.capabilities.push_back(capability(Kind::kProperty, kKnob, "glow-1"));
  message.capabilities.back().access = Access::kRead;
  join("7", message);
  EXPECT_TRUE(exists("proxy.hall.7.property.knob-glow-1.value"));
  EXPECT_FALSE(exists("proxy.hall.7.property.knob-glow-1.command"));
  report("7", {Kind::kProperty, kKnob, "glow-1"}, std::int64_t{4});
  EXPECT_EQ(text("proxy.hall.7.property.knob-glow-1.value"), "4");
}

TEST_F(Mirror, TextsOfDevicesAreEscapedInJson) {
  start();
  auto message = lamp();
  message.name = "the \"big\"\n\xff lamp";
  join("7", message);
  EXPECT_EQ(json("proxy.hall.7.description")["name"], "the \"big\"\n\xef\xbf\xbd lamp");
}

}  // namespace
}  // namespace rubicon::proxy
