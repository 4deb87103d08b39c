#include "networks/zigbee/zigbee_house.h"

namespace rubicon::networks::zigbee {
namespace {

using model::LineState;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

using LineOfTheBridge = House;

TEST_F(LineOfTheBridge, Pitfall1And19_ItSubscribesToWhatItNeedsAndToNothingElse) {
  start();
  EXPECT_THAT(broker.subscriptions(),
              UnorderedElementsAre("zigbee2mqtt/bridge/state", "zigbee2mqtt/bridge/info", "zigbee2mqtt/bridge/devices",
                                   "zigbee2mqtt/bridge/groups", "zigbee2mqtt/bridge/event", "zigbee2mqtt/bridge/health",
                                   "zigbee2mqtt/bridge/response/#", "zigbee2mqtt/plug", "zigbee2mqtt/plug/availability",
                                   "zigbee2mqtt/air", "zigbee2mqtt/air/availability", "zigbee2mqtt/button",
                                   "zigbee2mqtt/button/availability"));
}

TEST_F(LineOfTheBridge, IsUpWhenTheBridgeIsOnline) {
  make();
  open();
  EXPECT_EQ(state().line, LineState::kConnecting);
  bridge_starts();
  host.time.run_for(1s);
  EXPECT_EQ(state().line, LineState::kUp);
  EXPECT_EQ(state().reason, "");
  EXPECT_THAT(joins(),
              UnorderedElementsAre("00124b0010000002 plug", "00124b0010000003 air", "00124b0010000004 button"));
  EXPECT_THAT(host.failures, IsEmpty());
}

TEST_F(LineOfTheBridge, IsDownWhileTheBridgeIsOfflineAndItsDevicesStay) {
  start();
  online(false);
  EXPECT_EQ(state().line, LineState::kDown);
  EXPECT_THAT(state().reason, HasSubstr("offline"));
  const auto refused = command(1, kPlug, "switch", true);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().text, HasSubstr("offline"));
  online();
  EXPECT_EQ(state().line, LineState::kUp);
  EXPECT_THAT(joins(), SizeIs(3));
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty());
  EXPECT_TRUE(command(2, kPlug, "switch", true));
}

TEST_F(LineOfTheBridge, ReportsThatNoBridgeIsThere) {
  make();
  open();
  host.time.run_for(5s);
  EXPECT_EQ(state().line, LineState::kDown);
  EXPECT_THAT(state().reason, HasSubstr("zigbee2mqtt/bridge/state"));
}

TEST_F(LineOfTheBridge, RefusesABridgeOfVersionOneWithTheReason) {
  make();
  say("bridge/info", info("1.40.2"), true);
  list(json::array({plug()}));
  online();
  open();
  EXPECT_EQ(state().line, LineState::kRefused);
  EXPECT_THAT(state().reason, HasSubstr("1.40.2"));
  EXPECT_THAT(joins(), IsEmpty());
  EXPECT_FALSE(command(1, kPlug, "switch", true));
  say("bridge/info", info("2.0.0"), true);
  list(json::array({plug()}));
  EXPECT_EQ(state().line, LineState::kUp) << "it was updated";
  EXPECT_THAT(joins(), SizeIs(1));
}

TEST_F(LineOfTheBridge, ALostBrokerIsTheSupervisorsCase) {
  start();
  broker.stop(true);
  host.time.run_for(1s);
  ASSERT_THAT(host.failures, SizeIs(1));
  EXPECT_NE(host.failures[0].code, ErrorCode::kRefused);
  EXPECT_FALSE(command(1, kPlug, "switch", true));
  broker.start();
  reopen();
  EXPECT_EQ(state().line, LineState::kUp);
  EXPECT_THAT(joins(), SizeIs(3));
}

TEST_F(LineOfTheBridge, WithTheBrokerWhatWaitsIsAnsweredAndTheSupervisorReportsTheLine) {
  start();
  host.time.run_for(10s);
  ASSERT_TRUE(command(1, kPlug, "switch", true));
  ask({{"id", "x"}, {"do", "remove"}, {"device", "air"}});
  const auto states = host.all<model::State>().size();
  broker.stop(true);
  host.time.run_for(10s);
  ASSERT_THAT(host.failures, SizeIs(1));
  const auto why = host.failures[0].text;
  ASSERT_TRUE(answer(1));
  EXPECT_EQ(answer(1)->outcome, model::Outcome::kUndeliverable);
  EXPECT_EQ(answer(1)->text, why);
  ASSERT_THAT(to_tools("zigbee.reply"), SizeIs(1));
  EXPECT_THAT(to_tools("zigbee.reply")[0].value("why", ""), HasSubstr(why));
  const auto refused = command(2, kPlug, "switch", true);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().text, why);
  EXPECT_THAT(host.all<model::State>(), SizeIs(states)) << "the supervisor reports a failed line";
  broker.start();
  reopen();
  EXPECT_EQ(state().line, LineState::kUp);
  EXPECT_THAT(sets("plug"), SizeIs(1)) << "nothing is sent twice";
}

/// zigbee.md, section 2, 4: Zigbee2MQTT then publishes nothing but bridge/state.
TEST_F(LineOfTheBridge, KeepsItsDevicesIfTheBrokerForgetsTheLists) {
  start();
  broker.stop(false);
  host.time.run_for(1s);
  broker.start();
  reopen();
  online();
  EXPECT_EQ(state().line, LineState::kUp);
  EXPECT_THAT(joins(), SizeIs(3));
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty());
  report("air", {{"temperature", 21.5}});
  EXPECT_THAT(values(kThermometer, "temperature"), ElementsAre("21.5"));
}

/// mosquitto saves its retained messages each half hour: after a kill it has a list that lacks the newest devices.
TEST_F(LineOfTheBridge, KeepsItsDevicesIfTheBrokerComesBackWithAnOlderList) {
  make();
  bridge_starts({plug(), thermometer()});
  const auto saved = broker.retained();
  open();
  list({plug(), thermometer(), button()});
  EXPECT_THAT(joins(), SizeIs(3));
  broker.restart(saved);
  host.time.run_for(1s);
  reopen();
  online();
  EXPECT_EQ(state().line, LineState::kUp);
  host.time.run_for(24h);
  report("button", {{"action", "single"}});
  EXPECT_THAT(values(kButton, "action"), ElementsAre("single"));
  host.time.run_for(24h);
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty());
  list({plug(), thermometer()});
  host.time.run_for(10s);
  EXPECT_THAT(host.all<model::Leave>(), SizeIs(1)) << "a live list counts";
}

TEST_F(LineOfTheBridge, ReportsThatTheBrokerHasNoListOfDevicesIfItDoesNotComeSoon) {
  make();
  online();
  open();
  host.time.run_for(3s);
  EXPECT_EQ(state().line, LineState::kUp);
  EXPECT_EQ(state().reason, "") << "the list follows bridge/state";
  host.time.run_for(5s);
  EXPECT_THAT(state().reason, HasSubstr("list of devices"));
  bridge_starts();
  host.time.run_for(2s);
  EXPECT_EQ(state().reason, "");
}

TEST_F(LineOfTheBridge, SaysWhyThereIsNoListOfDevices) {
  make(R"({"broker": {"host": "localhost", "version": "3.1.1", "largest-packet": "64KiB"}})");
  online();
  say("bridge/groups", json::array(), true);
  open();
  host.time.run_for(8s);
  EXPECT_THAT(state().reason, AllOf(HasSubstr("message_size_limit"), HasSubstr("65536")));
  auto kept_back = info();
  kept_back["config"]["mqtt"]["force_disable_retain"] = true;
  say("bridge/info", kept_back, true);
  host.time.run_for(2s);
  EXPECT_THAT(state().reason, HasSubstr("mqtt.force_disable_retain"));
  auto large = plug();
  large["definition"]["description"] = std::string(70'000, 'x');
  list(json::array({large}));
  host.time.run_for(2s);
  EXPECT_THAT(state().reason, AllOf(HasSubstr("raise largest-packet"), HasSubstr("65536")));
  list(json::array({plug()}));
  host.time.run_for(2s);
  EXPECT_EQ(state().reason, "");
}

/// mqtt.md, section 2, h: one report, slow attempts.
TEST_F(LineOfTheBridge, AWrongPasswordIsReportedOnceForEachAttemptAndTriedAgainAfterHalfAMinute) {
  broker.users = {{"rubicon", "right"}};
  host.files.put("/secret", Bytes{'w', 'r', 'o', 'n', 'g'});
  make(R"({"broker": {"host": "localhost", "user": "rubicon", "password-file": "/secret"}})");
  bridge_starts();
  open();
  EXPECT_EQ(state().line, LineState::kRefused);
  EXPECT_EQ(state().counters.at("attempts"), 0U);
  EXPECT_GT(state().counters.at("next-attempt"), 0U);
  host.files.open_to_all("/secret");
  const auto reported = host.all<model::State>().size();
  host.time.run_for(65s);
  EXPECT_EQ(state().counters.at("attempts"), 2U);
  EXPECT_LE(host.all<model::State>().size(), reported + 2) << "one for each attempt";
  EXPECT_THAT(host.failures, IsEmpty());
  for (const auto& [from, one] : host.all<model::State>()) EXPECT_THAT(one.reason, Not(HasSubstr("wrong")));
  EXPECT_EQ(std::ranges::count_if(
                host.words.lines,
                [](const auto& line) { return line.find("all users of this machine can read") != line.npos; }),
            1)
      << "not at each attempt";
  host.files.put("/secret", Bytes{'r', 'i', 'g', 'h', 't'});
  host.time.run_for(30s);
  EXPECT_EQ(state().line, LineState::kUp);
}

TEST_F(LineOfTheBridge, AUserEndsThePauseAfterARefusal) {
  broker.users = {{"rubicon", "right"}};
  host.files.put("/secret", Bytes{'w', 'r', 'o', 'n', 'g'});
  make(R"({"broker": {"host": "localhost", "user": "rubicon", "password-file": "/secret"}})");
  bridge_starts();
  open();
  ASSERT_EQ(state().line, LineState::kRefused);
  EXPECT_TRUE(network->reopen());
  host.time.run_for(1s);
  EXPECT_EQ(state().line, LineState::kRefused);
  EXPECT_EQ(state().counters.at("attempts"), 1U);
  host.files.put("/secret", Bytes{'r', 'i', 'g', 'h', 't'});
  EXPECT_TRUE(network->reopen());
  host.time.run_for(1s);
  EXPECT_EQ(state().line, LineState::kUp);
  EXPECT_EQ(network->reopen().error().code, ErrorCode::kUnsupported) << "there is no pause";
}

TEST_F(LineOfTheBridge, ATopicThatTheBrokerForbidsIsNamedAndCounted) {
  broker.refused_filters = {"zigbee2mqtt/bridge/event"};
  start();
  EXPECT_EQ(state().line, LineState::kUp);
  EXPECT_THAT(state().reason, HasSubstr("zigbee2mqtt/bridge/event"));
  EXPECT_EQ(state().counters.at("forbidden-topics"), 1U);
  EXPECT_TRUE(host.words.contains("forbids"));
  report("air", {{"temperature", 21.5}});
  EXPECT_THAT(values(kThermometer, "temperature"), ElementsAre("21.5"));
}

TEST_F(LineOfTheBridge, ATopicThatIsNotWantedAnyMoreIsNotForbidden) {
  broker.refused_filters = {"zigbee2mqtt/air"};
  start();
  EXPECT_EQ(counter("forbidden-topics"), 1U);
  list({plug(), button()});
  host.time.run_for(10s);
  ASSERT_THAT(host.all<model::Leave>(), SizeIs(1));
  EXPECT_EQ(counter("forbidden-topics"), 0U);
  EXPECT_EQ(state().reason, "");
}

TEST_F(LineOfTheBridge, AHundredForbiddenTopicsAreRemembered) {
  make();
  auto all = json::array();
  for (int i = 0; i < 120; ++i) {
    const auto name = "air " + std::to_string(i);
    all.push_back(thermometer(name));
    all.back()["ieee_address"] = fmt::format("0x00124b002{:07x}", i);
    broker.refused_filters.insert("zigbee2mqtt/" + name);
  }
  bridge_starts(all);
  open();
  EXPECT_EQ(counter("forbidden-topics"), 100U);
  EXPECT_THAT(state().reason, HasSubstr("and 99 more"));
}

/// 300 devices have a list of 1.1 MB.
TEST_F(LineOfTheBridge, Pitfall2_ListsMayHaveMegabytes) {
  make();
  auto all = json::array();
  for (int i = 0; i < 1000; ++i) {
    auto one = thermometer("air " + std::to_string(i));
    one["ieee_address"] = fmt::format("0x00124b002{:07x}", i);
    one["definition"]["description"] = std::string(3000, 'x');
    all.push_back(std::move(one));
  }
  ASSERT_GT(all.dump().size(), 3'000'000U);
  bridge_starts(all);
  open();
  host.time.run_for(5s);
  EXPECT_THAT(joins(), SizeIs(1000));
  EXPECT_EQ(state().counters.at("dropped-too-long"), 0U);
}

TEST_F(LineOfTheBridge, PacketsThatAreTooLongAreNamedAndCountedOn311) {
  make(R"({"broker": {"host": "localhost", "version": "3.1.1", "largest-packet": "64KiB"}})");
  bridge_starts();
  open();
  EXPECT_EQ(state().counters.at("messages-not-taken"), 0U);
  for (int i = 0; i < 3; ++i) say("air", {{"text", std::string(70'000, 'x')}});
  host.time.run_for(2s);
  EXPECT_EQ(state().counters.at("dropped-too-long"), 3U);
  std::vector<std::string> warnings;
  for (const auto& line : host.words.lines)
    if (line.find("largest-packet") != line.npos) warnings.push_back(line);
  ASSERT_THAT(warnings, SizeIs(1)) << "once a minute";
  EXPECT_THAT(warnings[0], AllOf(HasSubstr("zigbee2mqtt/air"), HasSubstr("7003"), HasSubstr("65536")));
  host.time.run_for(61s);
  EXPECT_EQ(state().line, LineState::kUp);
}

TEST_F(LineOfTheBridge, WhatCannotBeReadIsCountedAndSurvived) {
  start();
  for (const auto* topic : {"bridge/state", "bridge/info", "bridge/devices", "bridge/groups", "bridge/event",
                            "bridge/response/permit_join", "plug", "plug/availability"}) {
    for (const auto* payload : {"", "{", "null", "[[[[", "\"x\"", "{\"state\":[1]}", "\xff\xfe", "1e999"}) {
      broker.publish(std::string("zigbee2mqtt/") + topic, payload);
      host.time.run_for(10ms);
    }
  }
  host.time.run_for(20s);
  EXPECT_EQ(state().line, LineState::kUp);
  EXPECT_THAT(joins(), SizeIs(3));
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty());
  EXPECT_GT(counter("unreadable-messages") + counter("unreadable-states") + counter("unreadable-lists"), 0U);
  report("air", {{"temperature", 21.5}});
  EXPECT_THAT(values(kThermometer, "temperature"), ElementsAre("21.5"));
}

TEST_F(LineOfTheBridge, TwoBridgesAreTwoNetworks) {
  make(R"({"broker": "localhost", "base": "home/cellar"})");
  bridge_starts();
  open();
  host.time.run_for(5s);
  EXPECT_THAT(joins(), IsEmpty()) << "that is the bridge of zigbee2mqtt";
  broker.publish("home/cellar/bridge/info", info().dump(), true);
  broker.publish("home/cellar/bridge/devices", json{plug("lamp")}.dump(), true);
  broker.publish("home/cellar/bridge/state", R"({"state":"online"})", true);
  host.time.run_for(1s);
  EXPECT_THAT(joins(), ElementsAre("00124b0010000002 lamp"));
  EXPECT_THAT(broker.subscriptions(), Contains("home/cellar/lamp"));
}

TEST_F(LineOfTheBridge, AReloadKeepsTheLineIfOnlyLimitsChanged) {
  start();
  const auto reload = [this](const std::string& options) {
    const auto node = support::config_of(std::string_view(options));
    ConfigErrors errors;
    ConfigReader reader(node, "networks.zigbee", errors);
    return network->change({"zigbee", IslandId{1}, reader, types, {}});
  };
  EXPECT_TRUE(reload(R"({"broker": "localhost", "polls-per-second": 2})"));
  EXPECT_FALSE(reload(R"({"broker": "localhost", "base": "other"})"));
  EXPECT_FALSE(reload(R"({"broker": "localhost:1884"})"));
  EXPECT_FALSE(reload(R"({"broker": ""})"));
  EXPECT_EQ(state().line, LineState::kUp);
  EXPECT_THAT(joins(), SizeIs(3));
}

TEST_F(LineOfTheBridge, EndsWithADisconnect) {
  start();
  ASSERT_THAT(broker.clients(), SizeIs(1));
  network.reset();
  host.time.run_for(1s);
  EXPECT_THAT(broker.clients(), IsEmpty());
}

/// A broker may send a message of QoS 1 twice.
TEST_F(LineOfTheBridge, AMessageThatArrivesTwiceIsOneMessage) {
  broker.repeats = true;
  start();
  const auto asked = gets("plug").size();
  broker.publish("zigbee2mqtt/bridge/state", R"({"state":"online"})", true, 1);
  host.time.run_for(20ms);
  EXPECT_EQ(state().line, LineState::kUp);
  EXPECT_EQ(gets("plug").size(), asked);
  EXPECT_THAT(joins(), SizeIs(3));
}

}  // namespace
}  // namespace rubicon::networks::zigbee
