#include "proxy/island.h"

namespace rubicon::proxy::admission {
namespace {

class Discovery : public Island {
 protected:
  void SetUp() override {
    remember();
    config.discovery.otherwise = DiscoveryAction::kAsk;
  }
  nlohmann::json inbox() {
    time.run_for(1s);
    return json("proxy.inbox");
  }
};

TEST_F(Discovery, ANewDeviceWaitsWithWhatItAnnouncesAndWhy) {
  start();
  join("1.7", lamp());
  const auto all = inbox();
  EXPECT_EQ(all["count"], 1);
  const auto& waiting = all["waiting"][0];
  EXPECT_EQ(waiting["key"], "hall.1_7");
  EXPECT_EQ(waiting["network"], "hall");
  EXPECT_EQ(waiting["address"], "1.7");
  EXPECT_EQ(waiting["name"], "Lamp");
  EXPECT_EQ(waiting["sensors"], (std::vector<std::string>{"glow-1", "glow-2"}));
  EXPECT_EQ(waiting["actuators"], (std::vector<std::string>{"flap-1"}));
  EXPECT_EQ(waiting["why"], "discovery.new-devices is ask");
  EXPECT_EQ(json("proxy.inbox.hall.1_7"), waiting);
  EXPECT_FALSE(exists("proxy.hall.1_7.status"));
  report("1.7", sensor(kGlow), 5.0);
  EXPECT_FALSE(exists("proxy.hall.1_7.sensor.glow-1.value"));
}

TEST_F(Discovery, ADeviceThatWasNotHeardComesFromTheOptionsUnlessItsNetworkDiscovers) {
  rules().discovers = true;
  start();
  auto listed = lamp();
  listed.heard = false;
  join("7", listed);
  EXPECT_FALSE(exists("proxy.hall.7.status"));
  EXPECT_EQ(inbox()["waiting"][0]["why"], "discovery.new-devices is ask");
  rules().discovers = false;
  proxy->reconfigure(config);
  join("8", listed);
  EXPECT_TRUE(exists("proxy.hall.8.status"));
}

TEST_F(Discovery, TheInboxIsPublishedAtTheStartAndThenOncePerPause) {
  start();
  join("7", lamp());
  EXPECT_TRUE(exists("proxy.inbox.hall.7"));
  time.run_for(240ms);
  EXPECT_EQ(json("proxy.inbox")["count"], 0);
  time.run_for(10ms);
  EXPECT_EQ(json("proxy.inbox")["count"], 1);
}

TEST_F(Discovery, AnApprovedDeviceJoinsAndIsTrustedForEver) {
  start();
  join("7", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.7", "approve").verdict, Verdict::kApplied);
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "reachable");
  EXPECT_FALSE(exists("proxy.inbox.hall.7"));
  EXPECT_EQ(inbox()["count"], 0);
  restart();
  EXPECT_TRUE(exists("proxy.hall.7.status"));
  say("7", model::Leave{"battery"});
  EXPECT_FALSE(exists("proxy.hall.7.status"));
  join("7", lamp());
  EXPECT_TRUE(exists("proxy.hall.7.status"));
}

TEST_F(Discovery, AnIgnoredDeviceStaysHiddenOverRestartsAndMayBeApprovedLater) {
  start();
  join("7", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.7", "ignore").verdict, Verdict::kApplied);
  for (int i = 0; i < 2; ++i) {
    join("7", lamp());
    report("7", sensor(kGlow), 5.0);
    EXPECT_FALSE(exists("proxy.hall.7.status"));
    EXPECT_FALSE(exists("proxy.inbox.hall.7"));
    EXPECT_EQ(inbox()["ignored"], 1);
    EXPECT_EQ(inbox()["count"], 0);
    restart();
  }
  ASSERT_EQ(set("proxy.inbox.hall.7", "approve").verdict, Verdict::kApplied);
  EXPECT_TRUE(exists("proxy.hall.7.status"));
}

TEST_F(Discovery, AWaitingDeviceStillWaitsAfterARestart) {
  start();
  join("7", lamp());
  restart();
  EXPECT_EQ(inbox()["count"], 1);
  ASSERT_EQ(set("proxy.inbox.hall.7", "approve").verdict, Verdict::kApplied);
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "unknown");
  report("7", sensor(kGlow), 5.0);
  EXPECT_EQ(text("proxy.hall.7.sensor.glow-1.value"), "5");
}

TEST_F(Discovery, TheFirstRuleThatFitsDecides) {
  config.discovery.rules = {{"hall", "", "9.*", DiscoveryAction::kIgnore}, {"h*", "lamp", "", DiscoveryAction::kAuto}};
  start();
  auto typed = lamp();
  typed.device_type = "lamp";
  join("9.1", typed);
  join("8", typed);
  join("7", lamp());
  EXPECT_FALSE(exists("proxy.hall.9_1.status"));
  EXPECT_TRUE(exists("proxy.hall.8.status"));
  const auto all = inbox();
  EXPECT_EQ(all["count"], 1);
  EXPECT_EQ(all["ignored"], 1);
}

TEST_F(Discovery, WhatTheConfigurationNamesNeedsNoApproval) {
  rules().devices["7"].name = "Kitchen";
  start();
  join("7", lamp());
  auto listed = lamp();
  listed.heard = false;
  join("8", listed);
  EXPECT_TRUE(exists("proxy.hall.7.status"));
  EXPECT_TRUE(exists("proxy.hall.8.status"));
}

TEST_F(Discovery, AKnownDeviceCanBeIgnored) {
  config.discovery.otherwise = DiscoveryAction::kAuto;
  start();
  join("7", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.7", "ignore").verdict, Verdict::kApplied);
  EXPECT_FALSE(exists("proxy.hall.7.status"));
  restart();
  join("7", lamp());
  EXPECT_FALSE(exists("proxy.hall.7.status"));
}

TEST_F(Discovery, AKnownDeviceIsIgnoredByItsNameOrAddressButNotByAPattern) {
  config.discovery.otherwise = DiscoveryAction::kAuto;
  start();
  for (const auto* address : {"1.7", "1.8", "1.9"}) join(address, lamp());
  EXPECT_EQ(set("proxy.inbox", "ignore hall.*").code, ErrorCode::kNotFound) << "none waits";
  EXPECT_EQ(set("proxy.inbox", "ignore hall.1.5").code, ErrorCode::kNotFound);
  EXPECT_EQ(set("proxy.inbox", "ignore attic.1.7").code, ErrorCode::kNotFound);
  ASSERT_EQ(set("proxy.inbox", "ignore hall.1_7").verdict, Verdict::kApplied);
  ASSERT_EQ(set("proxy.inbox", "ignore hall.1.8").verdict, Verdict::kApplied);
  EXPECT_FALSE(exists("proxy.hall.1_7.status"));
  EXPECT_FALSE(exists("proxy.hall.1_8.status"));
  EXPECT_TRUE(exists("proxy.hall.1_9.status"));
}

TEST_F(Discovery, OneThatWasJustApprovedMayBeIgnored) {
  start();
  join("7", lamp());
  ASSERT_EQ(set("proxy.inbox", "approve hall.7").verdict, Verdict::kApplied);
  ASSERT_EQ(set("proxy.inbox", "ignore hall.7").verdict, Verdict::kApplied);
  EXPECT_FALSE(exists("proxy.hall.7.status"));
  EXPECT_EQ(inbox()["ignored"], 1);
}

TEST_F(Discovery, IgnoredDevicesAreListedSoThatTheyCanBeApproved) {
  DiscoveryRule rule;
  rule.address = "9";
  rule.action = DiscoveryAction::kIgnore;
  config.discovery.rules.push_back(rule);
  rules().devices["1.7"].id = "attic";
  start();
  EXPECT_EQ(json("proxy.inbox.ignored"), nlohmann::json({{"count", 0}, {"devices", nlohmann::json::array()}}));
  for (const auto* address : {"1.7", "9", "3"}) join(address, lamp());
  ASSERT_EQ(set("proxy.inbox.hall.attic", "ignore").verdict, Verdict::kApplied);
  time.run_for(1s);
  const auto ignored = json("proxy.inbox.ignored");
  ASSERT_EQ(ignored["devices"].size(), 2U) << ignored;
  EXPECT_EQ(ignored["count"], 2);
  EXPECT_EQ(ignored["devices"][0]["key"], "hall.attic");
  EXPECT_EQ(ignored["devices"][0]["address"], "1.7");
  EXPECT_EQ(ignored["devices"][0]["by"], "user");
  EXPECT_EQ(ignored["devices"][1]["by"], "rule");
  EXPECT_EQ(ignored["devices"][1]["name"], "Lamp");
  ASSERT_EQ(set("proxy.inbox", "approve hall.attic").verdict, Verdict::kApplied);
  time.run_for(1s);
  EXPECT_TRUE(exists("proxy.hall.attic.status"));
  EXPECT_EQ(json("proxy.inbox.ignored")["devices"].size(), 1U);
}

TEST_F(Discovery, ManyAreApprovedByPattern) {
  start();
  for (const auto* address : {"1.1", "1.2", "2.1"}) join(address, lamp());
  ASSERT_EQ(set("proxy.inbox", "approve hall.1_*").verdict, Verdict::kApplied);
  EXPECT_TRUE(exists("proxy.hall.1_1.status"));
  EXPECT_TRUE(exists("proxy.hall.1_2.status"));
  EXPECT_EQ(inbox()["count"], 1);
}

TEST_F(Discovery, APatternApprovesPendingDevicesAndNoIgnoredOnes) {
  start();
  for (const auto* address : {"1.1", "1.2"}) join(address, lamp());
  ASSERT_EQ(set("proxy.inbox.hall.1_2", "ignore").verdict, Verdict::kApplied);
  ASSERT_EQ(set("proxy.inbox", "approve *").verdict, Verdict::kApplied);
  EXPECT_TRUE(exists("proxy.hall.1_1.status"));
  EXPECT_FALSE(exists("proxy.hall.1_2.status"));
  EXPECT_EQ(inbox()["ignored"], 1);
}

TEST_F(Discovery, WrongWordsAndUnknownDevicesAreRefused) {
  start();
  join("7", lamp());
  EXPECT_EQ(set("proxy.inbox.hall.7", "yes").code, ErrorCode::kInvalid);
  EXPECT_EQ(set("proxy.inbox.hall.8", "approve").code, ErrorCode::kNotFound);
  EXPECT_EQ(set("proxy.inbox", "approve").code, ErrorCode::kInvalid);
  EXPECT_EQ(set("proxy.inbox", "approve wsn.*").code, ErrorCode::kNotFound);
  EXPECT_EQ(inbox()["count"], 1);
}

TEST_F(Discovery, TwoAddressesWithOneKeyWaitApart) {
  start();
  join("1.7", lamp());
  join("1_7", lamp());
  EXPECT_TRUE(exists("proxy.inbox.hall.1_7"));
  EXPECT_TRUE(exists("proxy.inbox.hall.1_7_2"));
  ASSERT_EQ(set("proxy.inbox.hall.1_7_2", "ignore").verdict, Verdict::kApplied);
  EXPECT_EQ(json("proxy.inbox.hall.1_7")["address"], "1.7");
}

TEST_F(Discovery, TheInboxIsBounded) {
  config.max_devices = 3;
  start();
  for (int i = 0; i < 10; ++i) join(std::to_string(i), lamp());
  EXPECT_EQ(inbox()["count"], 3);
  EXPECT_TRUE(log.contain("limit of 3 devices"));
}

TEST_F(Discovery, AWaitingDeviceThatLeavesIsGone) {
  start();
  join("7", lamp());
  say("7", model::Leave{"bye"});
  EXPECT_EQ(inbox()["count"], 0);
  EXPECT_FALSE(exists("proxy.inbox.hall.7"));
}

TEST_F(Discovery, NewRulesDecideAtOnceAboutPendingDevices) {
  start();
  join("7", lamp());
  join("8", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.8", "ignore").verdict, Verdict::kApplied);
  config.discovery.otherwise = DiscoveryAction::kAuto;
  proxy->reconfigure(config);
  time.run_ready();
  EXPECT_TRUE(exists("proxy.hall.7.status"));
  EXPECT_FALSE(exists("proxy.hall.8.status"));
}

TEST_F(Discovery, AReloadAfterARestartAdmitsNoPendingDevice) {
  start();
  join("7", lamp());
  time.run_for(2s);
  restart();
  proxy->reconfigure(config);
  time.run_ready();
  EXPECT_FALSE(exists("proxy.hall.7.status"));
  EXPECT_EQ(inbox()["count"], 1);
}

TEST_F(Discovery, ADeviceThatWasHeardSinceTheStartIsReachableOnceApproved) {
  start();
  join("7", lamp());
  time.run_for(2s);
  restart();
  join("7", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.7", "approve").verdict, Verdict::kApplied);
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "reachable");
}

TEST_F(Discovery, ACrowdIsApprovedAtOnceAndForGood) {
  constexpr int kCrowd = 1000;
  start();
  for (int i = 0; i < kCrowd; ++i) join(std::to_string(i), lamp());
  time.run_for(2s);
  const auto writes = store->stats().writes;
  ASSERT_EQ(set("proxy.inbox", "approve *").verdict, Verdict::kApplied);
  time.run_for(1s);
  EXPECT_EQ(inbox()["count"], 0);
  // One save and one set of values a device, and few commits.
  EXPECT_LT(store->stats().writes - writes, 2 * kCrowd + 50);
  restart();
  for (int i = 0; i < kCrowd; ++i) EXPECT_TRUE(exists("proxy.hall." + std::to_string(i) + ".status")) << i;
}

TEST_F(Discovery, AnApprovalWithoutRoomIsKeptUntilThereIsRoom) {
  config.max_devices = 2;
  start();
  for (const auto* address : {"1", "2"}) join(address, lamp());
  ASSERT_EQ(set("proxy.inbox", "approve *").verdict, Verdict::kApplied);
  join("3", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.3", "approve").verdict, Verdict::kApplied);
  EXPECT_THAT(json("proxy.inbox.hall.3")["why"].get<std::string>(), testing::HasSubstr("limit of 2 devices"));
  say("1", model::Leave{"broken"});
  join("3", lamp());
  EXPECT_TRUE(exists("proxy.hall.3.status"));
  EXPECT_FALSE(exists("proxy.inbox.hall.3"));
}

TEST_F(Discovery, AnApprovalWithoutRoomSurvivesARestart) {
  config.max_devices = 1;
  start();
  join("1", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.1", "approve").verdict, Verdict::kApplied);
  join("3", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.3", "approve").verdict, Verdict::kApplied);
  time.run_for(1s);
  config.max_devices = 2;
  restart();
  join("3", lamp());
  EXPECT_TRUE(exists("proxy.hall.3.status"));
}

TEST_F(Discovery, ADeviceWhoseKeyIsTakenIsInTheInboxWithTheReason) {
  config.discovery.otherwise = DiscoveryAction::kAuto;
  start();
  join("1.7", lamp());
  join("1_7", lamp());
  EXPECT_THAT(json("proxy.inbox.hall.1_7")["why"].get<std::string>(), testing::HasSubstr("give it an id"));
  rules().devices["1_7"].id = "other";
  proxy->reconfigure(config);
  time.run_ready();
  EXPECT_TRUE(exists("proxy.hall.other.status"));
  EXPECT_FALSE(exists("proxy.inbox.hall.1_7"));
}

TEST_F(Discovery, AnIgnoredDeviceStopsSamplingAndIsAsBeforeOnceApproved) {
  config.discovery.otherwise = DiscoveryAction::kAuto;
  start();
  auto message = lamp();
  message.capabilities.push_back(capability(Kind::kProperty, types.find("rate")->id, ""));
  join("7", message);
  ASSERT_EQ(set("proxy.hall.7.property.rate.command", "250").verdict, Verdict::kApplied);
  const auto request = robot->subscribe({kIsland, "proxy.hall.7.sensor.glow-1.value"}, {}, [](const Event&) {});
  time.run_ready();
  ASSERT_FALSE(hall().sampled["7"].points.empty());
  ASSERT_EQ(set("proxy.inbox.hall.7", "ignore").verdict, Verdict::kApplied);
  EXPECT_TRUE(hall().sampled["7"].points.empty());
  ASSERT_EQ(set("proxy.inbox.hall.7", "approve").verdict, Verdict::kApplied);
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "reachable");
  EXPECT_EQ(text("proxy.hall.7.property.rate.value"), "250");
  time.run_ready();
  EXPECT_FALSE(hall().sampled["7"].points.empty());
}

TEST_F(Discovery, AnIgnoredDeviceIsApprovedByTheKeyItWouldHave) {
  rules().devices["1.7"].id = "attic";
  start();
  join("1.7", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.attic", "ignore").verdict, Verdict::kApplied);
  EXPECT_FALSE(exists("proxy.hall.attic.status"));
  ASSERT_EQ(set("proxy.inbox.hall.attic", "approve").verdict, Verdict::kApplied);
  EXPECT_TRUE(exists("proxy.hall.attic.status"));
}

TEST_F(Discovery, ApprovingOneThatWaitsSparesItsIgnoredTwin) {
  start();
  join("1.7", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.1_7", "ignore").verdict, Verdict::kApplied);
  join("1_7", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.1_7", "approve").verdict, Verdict::kApplied);
  EXPECT_EQ(json("proxy.hall.1_7.description")["address"], "1_7");
  EXPECT_EQ(inbox()["ignored"], 1);
}

TEST_F(Discovery, AnApprovalMeansTheOneThatHasTheKey) {
  start();
  join("1.7", lamp());
  join("1_7", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.1_7", "approve").verdict, Verdict::kApplied);
  EXPECT_EQ(json("proxy.hall.1_7.description")["address"], "1.7");
  EXPECT_EQ(inbox()["count"], 1);
}

TEST_F(Discovery, OfTwoIgnoredWithOneKeyTheAddressDecides) {
  start();
  for (const auto* address : {"1.7", "1_7"}) {
    join(address, lamp());
    ASSERT_EQ(set("proxy.inbox.hall.1_7", "ignore").verdict, Verdict::kApplied);
  }
  const auto refused = set("proxy.inbox.hall.1_7", "approve");
  EXPECT_EQ(refused.code, ErrorCode::kDuplicate);
  EXPECT_THAT(refused.text, testing::HasSubstr("proxy.inbox to approve hall.<address>"));
  ASSERT_EQ(set("proxy.inbox", "approve hall.1.7").verdict, Verdict::kApplied);
  EXPECT_EQ(json("proxy.hall.1_7.description")["address"], "1.7");
}

/// A device that a user approved and set to 250 ms, and that finds no room after a restart.
class Parked : public Discovery {
 protected:
  Join patient() const {
    auto message = lamp();
    auto rate = capability(Kind::kProperty, types.find("rate")->id, "");
    rate.initial = std::int64_t{1000};
    message.capabilities.push_back(rate);
    return message;
  }
  void park() {
    start();
    join("0", lamp());
    ASSERT_EQ(set("proxy.inbox.hall.0", "approve").verdict, Verdict::kApplied);
    join("7", patient());
    ASSERT_EQ(set("proxy.inbox.hall.7", "approve").verdict, Verdict::kApplied);
    ASSERT_EQ(set("proxy.hall.7.property.rate.command", "250").verdict, Verdict::kApplied);
    time.run_for(1s);
    config.max_devices = 1;
    restart();
    ASSERT_TRUE(exists("proxy.inbox.hall.7"));
  }
};

TEST_F(Parked, IsListedAtItsFirstMessageOnceThereIsRoom) {
  park();
  say("0", model::Leave{"gone"});
  time.run_for(2s);
  report("7", sensor(kGlow), 5.0);
  EXPECT_EQ(text("proxy.hall.7.sensor.glow-1.value"), "5");
  EXPECT_EQ(text("proxy.hall.7.property.rate.value"), "250");
  EXPECT_FALSE(exists("proxy.inbox.hall.7"));
}

TEST_F(Parked, IsListedWithItsValuesWhenItJoins) {
  park();
  say("0", model::Leave{"gone"});
  join("7", patient());
  EXPECT_EQ(text("proxy.hall.7.property.rate.value"), "250");
  time.run_for(20s);
  restart();
  EXPECT_EQ(text("proxy.hall.7.property.rate.value"), "250");
}

TEST_F(Parked, StaysApprovedWhenItLeaves) {
  park();
  say("7", model::Leave{"battery"});
  time.run_for(1s);
  say("0", model::Leave{"gone"});
  join("7", patient());
  EXPECT_TRUE(exists("proxy.hall.7.status"));
}

TEST_F(Discovery, DecisionsUnderWayDoNotBringARemovedNetworkBack) {
  start();
  for (int i = 0; i < 1000; ++i) join(std::to_string(i), lamp());
  time.run_for(1s);
  auto reply = Reply{};
  robot->set_remote(kIsland, "proxy.inbox", "ignore hall.*", 5s, [&](const Reply& answer) { reply = answer; });
  const auto rules_before = config.networks;
  time.post([this] {
    time.post([this] {
      networks->remove("hall");
      config.networks.clear();
      proxy->reconfigure(config);
    });
  });
  time.run_for(1s);
  EXPECT_EQ(inbox()["ignored"], 0);
  config.networks = rules_before;
  config.networks["hall"].devices["3"].id = "three";
  proxy->reconfigure(config);
  time.run_for(1s);
  EXPECT_TRUE(exists("proxy.hall.status"));
}

}  // namespace
}  // namespace rubicon::proxy::admission
