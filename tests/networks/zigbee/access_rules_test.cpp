#include "networks/zigbee/zigbee_house.h"

namespace rubicon::networks::zigbee {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

/// A broker whose access rules hide or drop messages; it says so only where MQTT 5 lets it.
class BehindAccessRules : public House {
 protected:
  void start_with_a_group(const std::string& options = R"({"broker": "localhost"})") {
    make(options);
    bridge_starts();
    say("bridge/groups",
        {{{"id", 7}, {"friendly_name", "all"}, {"members", {{{"ieee_address", "0x00124b0010000002"}}}}}}, true);
    open();
  }
  json reply() const {
    const auto all = to_tools("zigbee.reply");
    return all.empty() ? json() : all.back();
  }
};

TEST_F(BehindAccessRules, ALineWithoutAnyStateIsNamedAfterAMinute) {
  start_with_a_group();
  host.time.run_for(50s);
  EXPECT_EQ(state().reason, "");
  host.time.run_for(15s);
  EXPECT_EQ(state().line, model::LineState::kUp);
  EXPECT_THAT(state().reason,
              AllOf(HasSubstr("no state of any of 3 devices"), HasSubstr("access rules"), HasSubstr("zigbee2mqtt/#")));
  EXPECT_TRUE(host.words.contains("no state of any of 3 devices"));
  report("plug", {{"state", "ON"}});
  host.time.run_for(2s);
  EXPECT_EQ(state().reason, "");
  host.time.run_for(2h);
  EXPECT_EQ(state().reason, "");
  broker.stop(true);
  host.time.run_for(1s);
  broker.start();
  reopen();
  host.time.run_for(65s);
  EXPECT_THAT(state().reason, HasSubstr("no state of any of 3 devices")) << "each connection is judged by itself";
}

/// What has a battery is not asked, and may be quiet for long.
TEST_F(BehindAccessRules, DevicesThatOnlyReportMayBeSilentForAnHour) {
  make();
  bridge_starts({thermometer(), button()});
  open();
  host.time.run_for(55min);
  EXPECT_EQ(state().reason, "");
  host.time.run_for(6min);
  EXPECT_THAT(state().reason, HasSubstr("no state of any of 2 devices"));
}

TEST_F(BehindAccessRules, AvailabilityShowsThatTheBrokerLetsUsRead) {
  availability = true;
  make();
  bridge_starts({thermometer(), button()});
  open();
  host.time.run_for(65s);
  EXPECT_THAT(state().reason, HasSubstr("no state of any of 2 devices")) << "the bridge publishes it at once";
  say("air/availability", {{"state", "offline"}}, true);
  host.time.run_for(2s);
  EXPECT_EQ(state().reason, "");
}

TEST_F(BehindAccessRules, AnOutputWithoutStatesIsAnotherTrouble) {
  make();
  bridge_starts();
  auto attributes = info();
  attributes["config"]["advanced"]["output"] = "attribute";
  say("bridge/info", attributes, true);
  open();
  host.time.run_for(5min);
  EXPECT_EQ(state().reason, "");
}

TEST_F(BehindAccessRules, AGroupCommandWaitsForItsEcho) {
  start_with_a_group();
  ASSERT_TRUE(command(1, "group-7", "switch", true));
  host.time.run_for(100ms);
  EXPECT_THAT(sets("all"), SizeIs(1));
  EXPECT_FALSE(answer(1)) << "nothing proves yet that Zigbee2MQTT got it";
  say("all", {{"state", "ON"}});
  ASSERT_TRUE(answer(1));
  EXPECT_EQ(answer(1)->outcome, model::Outcome::kSent);
  ASSERT_TRUE(command(2, "group-7", "switch", true));
  say("all", {{"state", "ON"}});
  ASSERT_TRUE(answer(2)) << "the state that the group has already";
  EXPECT_EQ(answer(2)->outcome, model::Outcome::kSent);
}

TEST_F(BehindAccessRules, AGroupCommandThatTheBrokerDropsFails) {
  broker.ignored_topics = {"zigbee2mqtt/all/set"};
  start_with_a_group();
  ASSERT_TRUE(command(1, "group-7", "switch", true));
  host.time.run_for(30s);
  ASSERT_TRUE(answer(1));
  EXPECT_EQ(answer(1)->outcome, model::Outcome::kUndeliverable);
  EXPECT_THAT(answer(1)->text, HasSubstr("the broker dropped it"));
}

TEST_F(BehindAccessRules, AGroupWithoutEchoesAnswersAsTheBrokerDoes) {
  start_with_a_group();
  auto pessimistic = info();
  pessimistic["config"]["device_options"]["optimistic"] = false;
  say("bridge/info", pessimistic, true);
  host.time.run_for(1s);
  ASSERT_TRUE(command(1, "group-7", "switch", true));
  host.time.run_for(10ms);
  ASSERT_TRUE(answer(1));
  EXPECT_EQ(answer(1)->outcome, model::Outcome::kSent);
  broker.refused_topics = {"zigbee2mqtt/all/set"};
  ASSERT_TRUE(command(2, "group-7", "switch", true));
  host.time.run_for(10ms);
  ASSERT_TRUE(answer(2));
  EXPECT_EQ(answer(2)->outcome, model::Outcome::kRefused);
  EXPECT_THAT(answer(2)->text, HasSubstr("0x87"));
  broker.acknowledges = false;
  ASSERT_TRUE(command(3, "group-7", "switch", true));
  host.time.run_for(14s);
  EXPECT_FALSE(answer(3));
  host.time.run_for(2s);
  ASSERT_TRUE(answer(3));
  EXPECT_EQ(answer(3)->outcome, model::Outcome::kSent);
}

/// MQTT 5, section 3.4.2.1: 0x87, not authorized.
TEST_F(BehindAccessRules, ARefusedPublicationEndsItsCommandWithTheReason) {
  broker.refused_topics = {"zigbee2mqtt/plug/set", "zigbee2mqtt/all/set"};
  start_with_a_group();
  for (const auto* device : {kPlug, "group-7"}) {
    const std::uint64_t request = device == kPlug ? 1 : 2;
    ASSERT_TRUE(command(request, device, "switch", true));
    host.time.run_for(10ms);
    ASSERT_TRUE(answer(request)) << device;
    EXPECT_EQ(answer(request)->outcome, model::Outcome::kRefused);
    EXPECT_THAT(answer(request)->text, AllOf(HasSubstr("0x87"), HasSubstr("not authorised"), HasSubstr("/set")));
  }
  report("plug", {{"state", "OFF"}});
  host.time.run_for(1s);
  EXPECT_THAT(state().reason, AllOf(HasSubstr("does not take messages to 'zigbee2mqtt/all/set' and 1 more"),
                                    HasSubstr("access rules")));
  EXPECT_EQ(counter("messages-not-taken"), 2U);
  EXPECT_TRUE(host.words.contains("0x87"));
  broker.stop(true);
  host.time.run_for(1s);
  broker.refused_topics.clear();
  broker.start();
  reopen();
  report("plug", {{"state", "ON"}});
  host.time.run_for(1s);
  EXPECT_EQ(state().reason, "") << "the broker may have other rules by now";
}

TEST_F(BehindAccessRules, ABrokerOfVersion311SaysNothing) {
  broker.refused_topics = {"zigbee2mqtt/plug/set"};
  start_with_a_group(R"({"broker": {"host": "localhost", "version": "3.1.1"}})");
  ASSERT_TRUE(command(1, kPlug, "switch", true));
  host.time.run_for(10s);
  EXPECT_FALSE(answer(1));
  host.time.run_for(10s);
  ASSERT_TRUE(answer(1));
  EXPECT_EQ(answer(1)->outcome, model::Outcome::kUndeliverable);
}

TEST_F(BehindAccessRules, ARefusedRequestOfAToolIsAnsweredAtOnce) {
  broker.refused_topics = {"zigbee2mqtt/bridge/request/#"};
  start_with_a_group();
  ask({{"id", "x"}, {"do", "remove"}, {"device", "air"}});
  ASSERT_THAT(to_tools("zigbee.reply"), SizeIs(1));
  EXPECT_EQ(reply()["ok"], false);
  EXPECT_THAT(reply().value("why", ""), HasSubstr("0x87"));
}

TEST_F(BehindAccessRules, ToolsSayThatNoListWasReceivedAndWhy) {
  make();
  online();
  say("bridge/groups", json::array(), true);
  open();
  ask({{"id", "a"}, {"do", "devices"}});
  EXPECT_EQ(reply()["listed"], false);
  EXPECT_THAT(reply().value("why", ""), HasSubstr("Zigbee2MQTT"));
  host.time.run_for(10s);
  ask({{"id", "b"}, {"do", "devices"}});
  EXPECT_EQ(reply()["listed"], false);
  EXPECT_THAT(reply().value("why", ""), HasSubstr("the broker limits the length of messages"));
  bridge_starts(json::array());
  host.time.run_for(1s);
  ask({{"id", "c"}, {"do", "devices"}});
  EXPECT_EQ(reply()["listed"], true) << "of no device";
  EXPECT_FALSE(reply().contains("why"));
}

}  // namespace
}  // namespace rubicon::networks::zigbee
