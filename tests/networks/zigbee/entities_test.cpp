#include "networks/zigbee/zigbee_house.h"

namespace rubicon::networks::zigbee {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

class ZigbeeEntities : public House {
 protected:
  void start_with_a_group() {
    start();
    say("bridge/groups",
        {{{"id", 7},
          {"friendly_name", "all"},
          {"scenes", json::array()},
          {"members", {{{"ieee_address", "0x00124b0010000002"}, {"endpoint", 1}}}}}},
        true);
    host.time.run_for(100ms);
  }
};

constexpr const char* kUnknown = "00124b0010000077";

/// The walking skeleton: a device of the list, its reading, a command.
TEST_F(ZigbeeEntities, ADeviceJoinsReportsAndObeys) {
  start();
  report("air", {{"temperature", 21.5}, {"humidity", 40}});
  EXPECT_THAT(values(kThermometer, "temperature"), ElementsAre("21.5"));
  EXPECT_THAT(values(kThermometer, "humidity"), ElementsAre("40"));
  ASSERT_TRUE(command(7, kPlug, "switch", true));
  host.time.run_for(10ms);
  EXPECT_THAT(sets("plug"), ElementsAre(R"({"state":"ON"})"));
  report("plug", {{"state", "ON"}});
  host.time.run_for(1s);
  ASSERT_TRUE(answer(7));
  EXPECT_EQ(answer(7)->outcome, model::Outcome::kSent);
}

TEST_F(ZigbeeEntities, Pitfall4_ARenameIsNoLeave) {
  start();
  list({plug("hall"), thermometer(), button()});
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty());
  EXPECT_EQ(joins().back(), "00124b0010000002 hall");
  EXPECT_THAT(broker.subscriptions(), Contains("zigbee2mqtt/hall"));
  EXPECT_THAT(broker.subscriptions(), Not(Contains("zigbee2mqtt/plug")));
  EXPECT_THAT(broker.subscriptions(), Not(Contains("zigbee2mqtt/plug/availability")));
  ASSERT_TRUE(command(1, kPlug, "switch", true));
  host.time.run_for(10ms);
  EXPECT_THAT(sets("hall"), SizeIs(1));
  EXPECT_EQ(counter("renames"), 1U);
}

TEST_F(ZigbeeEntities, TwoDevicesMaySwapTheirNames) {
  start();
  list({plug("air"), thermometer("plug"), button()});
  report("plug", {{"temperature", 18}});
  EXPECT_THAT(values(kThermometer, "temperature"), ElementsAre("18"));
  EXPECT_THAT(broker.subscriptions(), Contains("zigbee2mqtt/plug"));
  EXPECT_THAT(broker.subscriptions(), Contains("zigbee2mqtt/air/availability"));
  ASSERT_TRUE(command(1, kPlug, "switch", true));
  host.time.run_for(10ms);
  EXPECT_THAT(sets("air"), SizeIs(1));
  EXPECT_THAT(sets("plug"), IsEmpty());
}

TEST_F(ZigbeeEntities, Pitfall5_NamesMayHaveSlashesBlanksAndAnyCharacter) {
  make();
  bridge_starts({plug("ground floor/hall/plug"), thermometer("ground floor/hall"), button("Küche/ボタン")});
  open();
  report("ground floor/hall", {{"temperature", 19}});
  EXPECT_THAT(values(kThermometer, "temperature"), ElementsAre("19"));
  ASSERT_TRUE(command(1, kPlug, "switch", true));
  host.time.run_for(10ms);
  EXPECT_THAT(sets("ground floor/hall/plug"), SizeIs(1));
  report("Küche/ボタン", {{"action", "single"}});
  EXPECT_EQ(readings(), 2U);
}

TEST_F(ZigbeeEntities, ANameWhoseTopicIsThatOfAnotherDeviceIsReportedAndItsCommandsAreRefused) {
  make();
  bridge_starts({plug("a"), thermometer("a/set"), button()});
  open();
  ASSERT_TRUE(command(1, kPlug, "switch", true));
  host.time.run_for(10ms);
  EXPECT_THAT(values(kThermometer, "temperature"), IsEmpty());
  EXPECT_EQ(counter("unusable-names"), 1U);
  EXPECT_EQ(counter("unreadable-states"), 0U) << "the command to a is no state of a/set";
}

TEST_F(ZigbeeEntities, TheConflictOfANameDoesNotDependOnTheOrderOfTheDevices) {
  make();
  bridge_starts({plug("a/set"), thermometer("a"), button()});  // `a` comes later
  open();
  EXPECT_EQ(counter("unusable-names"), 1U);
  EXPECT_FALSE(command(1, kPlug, "switch", true));
  list({plug("a/set"), thermometer("b"), button()});
  EXPECT_EQ(counter("unusable-names"), 0U);
  EXPECT_TRUE(command(2, kPlug, "switch", true));
  list({plug("a/set"), thermometer("b"), button("a")});
  EXPECT_EQ(counter("unusable-names"), 1U);
  list({plug("a/set"), thermometer("b")});
  host.time.run_for(11s);
  EXPECT_EQ(counter("unusable-names"), 0U) << "the other one left";
}

TEST_F(ZigbeeEntities, WhatOfADefinitionIsNotUsedIsCounted) {
  auto strange = thermometer();
  strange["definition"]["exposes"].push_back(numeric("stickiness", 1, "gg"));
  strange["definition"]["exposes"].push_back({{"type", "hologram"}, {"name", "x"}, {"property", "x"}, {"access", 1}});
  make();
  bridge_starts({plug(), strange, button()});
  open();
  EXPECT_EQ(counter("unknown-units"), 1U);
  EXPECT_EQ(counter("skipped-exposes"), 1U);
  list({plug(), thermometer(), button()});
  EXPECT_EQ(counter("unknown-units"), 0U);
  EXPECT_EQ(counter("skipped-exposes"), 0U);
}

/// The proxy sends a Probe for each device that it remembers. The first list is a copy that the broker kept.
TEST_F(ZigbeeEntities, AProbeOfADeviceThatALiveListLacksIsAnsweredByItsLeave) {
  make();
  EXPECT_TRUE(send(kUnknown, model::Probe{}));
  bridge_starts({plug(), thermometer()});
  open();
  EXPECT_TRUE(send(kButton, model::Probe{}));
  host.time.run_for(1min);
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty()) << "the copy may be old";
  list({plug(), thermometer()});
  host.time.run_for(9s);
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty()) << "the list may be short for a moment";
  host.time.run_for(1s);
  ASSERT_THAT(host.all<model::Leave>(), SizeIs(2));
  EXPECT_EQ(host.all<model::Leave>()[0].first, kButton);
  EXPECT_EQ(host.all<model::Leave>()[1].first, kUnknown);
}

TEST_F(ZigbeeEntities, AProbedDeviceThatOnlyACopyOfTheListLacksLeavesAfter25Hours) {
  make();
  bridge_starts({plug(), thermometer()});
  open();
  EXPECT_TRUE(send(kButton, model::Probe{}));
  host.time.run_for(24h);
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty());
  host.time.run_for(1h);
  EXPECT_THAT(host.all<model::Leave>(), SizeIs(1));
}

TEST_F(ZigbeeEntities, AProbedGroupThatIsNotInTheListLeaves) {
  start();
  EXPECT_TRUE(send("group-9", model::Probe{}));
  EXPECT_TRUE(send("group-7", model::Probe{}));
  host.time.run_for(1min);
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty()) << "the list of groups is not there";
  say("bridge/groups", {{{"id", 7}, {"friendly_name", "all"}, {"members", json::array()}}}, true);
  host.time.run_for(100ms);
  ASSERT_THAT(host.all<model::Leave>(), SizeIs(1));
  EXPECT_EQ(host.all<model::Leave>()[0].first, "group-9");
  EXPECT_TRUE(send("group-3", model::Probe{}));
  host.time.run_for(100ms);
  EXPECT_THAT(host.all<model::Leave>(), SizeIs(2));
}

TEST_F(ZigbeeEntities, AProbedDeviceOfWhichTheBridgeHasAnyRecordStays) {
  make();
  auto pending = thermometer();
  pending["interview_state"] = "FAILED";
  auto unreadable = button();
  unreadable.erase("friendly_name");
  bridge_starts({pending, unreadable});
  open();
  for (const auto* device : {kPlug, kThermometer, kButton}) EXPECT_TRUE(send(device, model::Probe{}));
  list({plug(), pending, unreadable});
  host.time.run_for(48h);
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty());
}

TEST_F(ZigbeeEntities, AnIncompleteListOrALostBridgeRemovesNoProbedDevice) {
  start();
  EXPECT_TRUE(send(kUnknown, model::Probe{}));
  list({plug(), thermometer(), button(), json::object({{"friendly_name", "no address"}})});
  host.time.run_for(1min);
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty());
  list({plug(), thermometer(), button()});
  host.time.run_for(5s);
  online(false);
  host.time.run_for(1min);
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty());
  online();
  list({plug(), thermometer(), button()});
  host.time.run_for(11s);
  EXPECT_THAT(host.all<model::Leave>(), SizeIs(1));
}

/// Where the user configures `silence`, the proxy asks devices that are quiet.
TEST_F(ZigbeeEntities, AProbeAsksAKnownDeviceThatCanAnswer) {
  start();
  host.time.run_for(1min);
  const auto asked = gets("plug").size();
  EXPECT_TRUE(send(kPlug, model::Probe{}));
  EXPECT_FALSE(send(kThermometer, model::Probe{})) << "it sleeps";
  host.time.run_for(5s);
  EXPECT_EQ(gets("plug").size(), asked + 1);
  EXPECT_THAT(gets("air"), IsEmpty());
  EXPECT_TRUE(send(kPlug, model::Probe{}));
  host.time.run_for(5s);
  EXPECT_EQ(gets("plug").size(), asked + 1) << "the last question is not answered yet";
}

TEST_F(ZigbeeEntities, Pitfall13_RetainedTopicsOfDevicesThatAreNotInTheListAreIgnored) {
  availability = true;
  say("ghost/availability", {{"state", "online"}}, true);
  say("ghost", {{"temperature", 1}}, true);
  start();
  broker.publish("homeassistant/sensor/0x00124b0010000009/temperature/config", "{}", true);
  host.time.run_for(1s);
  EXPECT_THAT(host.all<model::KeepAlive>(), IsEmpty());
  EXPECT_EQ(readings(), 0U);
  EXPECT_THAT(joins(), SizeIs(3));
}

TEST_F(ZigbeeEntities, TheAvailabilityOfADeviceThatLeftIsNoLongerHeard) {
  availability = true;
  start();
  list({plug(), button()});
  list({plug(), button("knob")});
  host.time.run_for(11s);
  ASSERT_THAT(host.all<model::Leave>(), SizeIs(1));
  EXPECT_EQ(host.all<model::Leave>()[0].first, kThermometer);
  host.delivered.clear();
  say("air/availability", {{"state", "online"}}, true);
  report("air", {{"temperature", 21}});
  host.time.run_for(1s);
  for (const auto& message : host.delivered) EXPECT_NE(message.source.device, kThermometer);
  EXPECT_FALSE(send(kThermometer, model::Sample{9, {}, 0ms}));
}

/// Lists are short for a moment while the bridge starts or interviews.
TEST_F(ZigbeeEntities, Pitfall16_ADeviceThatOneListLacksStays) {
  start();
  list({plug(), button()});
  host.time.run_for(2s);
  list({plug(), thermometer(), button()});
  host.time.run_for(1min);
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty());
  list(json::array());
  host.time.run_for(2s);
  list({plug(), thermometer(), button()});
  host.time.run_for(1min);
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty());
  EXPECT_THAT(joins(), SizeIs(3));
}

TEST_F(ZigbeeEntities, ADeviceThatSaysThatItLeavesIsGoneWithTheNextList) {
  start();
  say("bridge/event",
      {{"type", "device_leave"}, {"data", {{"ieee_address", "0x00124b0010000003"}, {"friendly_name", "air"}}}});
  list({plug(), button()});
  host.time.run_for(100ms);
  ASSERT_THAT(host.all<model::Leave>(), SizeIs(1));
  EXPECT_THAT(broker.subscriptions(), Not(Contains("zigbee2mqtt/air")));
  list({plug(), thermometer(), button()});
  host.time.run_for(1s);
  EXPECT_THAT(joins(), SizeIs(4)) << "it came back";
}

TEST_F(ZigbeeEntities, ADeviceThatCannotBeUsedIsAnnouncedWithItsProblem) {
  auto pending = thermometer();
  pending["interview_state"] = "FAILED";
  pending.erase("definition");
  make();
  bridge_starts({plug(), pending});
  open();
  const auto all = host.all<model::Join>();
  const auto found = std::find_if(all.begin(), all.end(), [](const auto& one) { return one.first == kThermometer; });
  ASSERT_NE(found, all.end());
  EXPECT_NE(found->second.problem, "");
  EXPECT_THAT(found->second.capabilities, IsEmpty());
  EXPECT_FALSE(send(kThermometer, model::Sample{9, {}, 0ms}));
  list({plug(), thermometer()});
  host.time.run_for(100ms);
  const auto later = host.all<model::Join>().back();
  EXPECT_EQ(later.first, kThermometer);
  EXPECT_EQ(later.second.problem, "");
  EXPECT_THAT(later.second.capabilities, Not(IsEmpty()));
}

TEST_F(ZigbeeEntities, ADeviceThatIsDisabledTakesNoCommandsAndSaysWhy) {
  start();
  auto disabled = plug();
  disabled["disabled"] = true;
  ASSERT_TRUE(command(1, kPlug, "switch", true));
  list({disabled, thermometer(), button()});
  host.time.run_for(100ms);
  ASSERT_TRUE(answer(1)) << "what waited is answered";
  EXPECT_NE(answer(1)->outcome, model::Outcome::kSent);
  const auto refused = command(2, kPlug, "switch", true);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().text, HasSubstr("disabled"));
  list({plug(), thermometer(), button()});
  host.time.run_for(100ms);
  EXPECT_TRUE(command(3, kPlug, "switch", true));
}

TEST_F(ZigbeeEntities, ANewDefinitionIsAnnouncedAgain) {
  start();
  auto more = thermometer();
  more["definition"]["exposes"].push_back(numeric("pressure", 1, "hPa"));
  list({plug(), more, button()});
  host.time.run_for(100ms);
  EXPECT_THAT(joins(), SizeIs(4));
  report("air", {{"pressure", 1013}});
  EXPECT_EQ(readings(), 1U);
}

/// What is kept for the next alarm is shown, and goes with it.
TEST_F(ZigbeeEntities, ASirenSoundsAsLongAndAsLoudAsWasSet) {
  const auto part = [](const char* name, json more) {
    more.update({{"name", name}, {"property", name}, {"access", 2}});
    return more;
  };
  make();
  const json warning{{"type", "composite"},
                     {"name", "warning"},
                     {"property", "warning"},
                     {"access", 2},
                     {"features",
                      {part("mode", {{"type", "enum"}, {"values", {"stop", "emergency"}}}),
                       part("level", {{"type", "enum"}, {"values", {"low", "high"}}}),
                       part("duration", {{"type", "numeric"}, {"unit", "s"}})}}};
  bridge_starts(json::array({record(kPlug, "siren", json::array({warning}), false)}));
  open();
  const auto join = host.all<model::Join>().at(0).second;
  const auto id = [&](const std::string& type) {
    for (const auto& one : join.capabilities)
      if (one.type_name == type) return one.point;
    ADD_FAILURE() << type;
    return model::PointId{};
  };
  const auto sound = [&](std::uint64_t request, bool on) {
    EXPECT_TRUE(send(kPlug, model::Actuate{request, id("siren"), on, 20s}));
    host.time.run_for(3s);
    return json::parse(sets("siren").back())["warning"];
  };
  EXPECT_EQ(sound(1, true), json({{"mode", "emergency"}, {"level", "high"}, {"duration", 1800}}));
  ASSERT_TRUE(send(kPlug, model::SetProperty{2, id("siren_duration"), Value(20.0)}));
  ASSERT_TRUE(send(kPlug, model::SetProperty{3, id("alarmVolume"), Value("low")}));
  host.time.run_for(3s);
  EXPECT_THAT(sets("siren"), SizeIs(1)) << "they make no sound";
  EXPECT_EQ(answer(2)->outcome, model::Outcome::kSent);
  EXPECT_EQ(answer(3)->outcome, model::Outcome::kSent);
  EXPECT_EQ(sound(4, true), json({{"mode", "emergency"}, {"level", "low"}, {"duration", 20}}));
  EXPECT_EQ(sound(5, false), json({{"mode", "stop"}, {"level", "low"}, {"duration", 0}}));
  auto blinking = warning;
  blinking["features"].push_back(part("strobe", {{"type", "binary"}, {"value_on", true}, {"value_off", false}}));
  list(json::array({record(kPlug, "siren", json::array({blinking}), false)}));
  host.time.run_for(1s);
  EXPECT_EQ(sound(6, true), json({{"mode", "emergency"}, {"level", "high"}, {"duration", 1800}, {"strobe", true}}))
      << "what was kept for the former definition may not fit";
}

TEST_F(ZigbeeEntities, AGroupIsADevice) {
  start_with_a_group();
  EXPECT_THAT(joins(), Contains("group-7 all"));
  EXPECT_EQ(state().texts.at("groups"), fmt::format(R"([{{"address":"group-7","members":["{}"]}}])", kPlug));
  ASSERT_TRUE(command(3, "group-7", "switch", true));
  host.time.run_for(10ms);
  EXPECT_THAT(sets("all"), ElementsAre(R"({"state":"ON"})"));
  say("bridge/groups", json::array(), true);
  host.time.run_for(100ms);
  ASSERT_THAT(host.all<model::Leave>(), SizeIs(1));
  EXPECT_EQ(host.all<model::Leave>()[0].first, "group-7");
  EXPECT_THAT(broker.subscriptions(), Not(Contains("zigbee2mqtt/all")));
}

TEST_F(ZigbeeEntities, AGroupLosesWhatOnlyAnUnusableMemberHad) {
  start_with_a_group();
  EXPECT_TRUE(command(1, "group-7", "switch", true));
  auto disabled = plug();
  disabled["disabled"] = true;
  list({disabled, thermometer(), button()});
  host.time.run_for(100ms);
  EXPECT_FALSE(command(2, "group-7", "switch", true));
}

TEST_F(ZigbeeEntities, AvailabilityThatCannotBeReadIsCountedAndLogged) {
  availability = true;
  start();
  say("plug/availability", "maybe", true);
  EXPECT_EQ(counter("unreadable-states"), 1U);
  EXPECT_TRUE(host.words.contains("plug"));
}

TEST_F(ZigbeeEntities, TheBridgeSaysWhoIsThereWhereItOffersThat) {
  availability = true;
  start();
  say("plug/availability", {{"state", "offline"}}, true);
  ASSERT_THAT(host.all<model::Unreachable>(), SizeIs(1));
  EXPECT_EQ(host.all<model::Unreachable>()[0].first, kPlug);
  say("plug/availability", {{"state", "online"}}, true);
  EXPECT_THAT(host.all<model::KeepAlive>(), SizeIs(1));
  host.time.run_for(100h);
  EXPECT_THAT(host.all<model::Unreachable>(), SizeIs(1)) << "no limit of its own beside the bridge's";
}

/// A group is online if any member is (zigbee.md, section 6).
TEST_F(ZigbeeEntities, TheBridgeReportsWhetherAGroupIsThere) {
  availability = true;
  start();
  say("all/availability", {{"state", "offline"}}, true);
  say("bridge/groups",
      {{{"id", 7}, {"friendly_name", "all"}, {"members", {{{"ieee_address", "0x00124b0010000002"}, {"endpoint", 1}}}}}},
      true);
  host.time.run_for(100ms);
  ASSERT_THAT(host.all<model::Unreachable>(), SizeIs(1));
  EXPECT_EQ(host.all<model::Unreachable>()[0].first, "group-7");
  EXPECT_TRUE(command(1, "group-7", "switch", true)) << "a member may be back";
  host.time.run_for(10ms);
  EXPECT_THAT(sets("all"), SizeIs(1));
  say("all/availability", {{"state", "online"}}, true);
  ASSERT_THAT(host.all<model::KeepAlive>(), SizeIs(1));
  EXPECT_EQ(host.all<model::KeepAlive>()[0].first, "group-7");
  host.time.run_for(100h);
  EXPECT_THAT(gets("all"), IsEmpty());
  EXPECT_THAT(host.all<model::Unreachable>(), SizeIs(1));
}

/// zigbee.md, section 6: mains 1 h without configured reporting, battery 25 h.
TEST_F(ZigbeeEntities, WithoutAvailabilityADeviceThatIsSilentTooLongIsUnreachable) {
  start();
  host.time.run_for(59min);
  EXPECT_THAT(host.all<model::Unreachable>(), IsEmpty());
  report("plug", {{"state", "ON"}});
  host.time.run_for(59min);
  EXPECT_THAT(host.all<model::Unreachable>(), IsEmpty());
  host.time.run_for(2min);
  ASSERT_THAT(host.all<model::Unreachable>(), SizeIs(1));
  EXPECT_EQ(host.all<model::Unreachable>()[0].first, kPlug);
  host.time.run_for(24h);
  EXPECT_THAT(host.all<model::Unreachable>(), SizeIs(3)) << "the others have batteries: 25 h";
  report("air", {{"temperature", 20}});
  EXPECT_THAT(values(kThermometer, "temperature"), ElementsAre("20"));
}

TEST_F(ZigbeeEntities, TheTimeWithoutABridgeCountsAgainstNoDevice) {
  start();
  online(false);
  host.time.run_for(48h);
  online();
  host.time.run_for(50min);
  EXPECT_THAT(host.all<model::Unreachable>(), IsEmpty());
}

TEST_F(ZigbeeEntities, Pitfall8_WhatTheBridgeRepeatsAtItsStartIsOld) {
  start();
  online(false);
  host.time.run_for(1h);
  bridge_starts();
  say("air", {{"temperature", 17}, {"last_seen", "2026-01-01T00:00:05.000Z"}});
  host.time.run_for(1s);
  EXPECT_THAT(values(kThermometer, "temperature"), IsEmpty());
  EXPECT_THAT(values(kThermometer, "temperature", false), ElementsAre("17"));
  for (const auto& [from, updates] : host.all<model::Updates>()) {
    for (const auto& reading : updates.readings) EXPECT_LT(reading.user_time, host.time.wall_now() - 59min);
  }
}

TEST_F(ZigbeeEntities, ABridgeThatRanBeforeTheIslandRepeatsNothing) {
  start();
  say("air", {{"temperature", 17}});
  host.time.run_for(1s);
  EXPECT_THAT(values(kThermometer, "temperature"), ElementsAre("17"));
}

}  // namespace
}  // namespace rubicon::networks::zigbee
