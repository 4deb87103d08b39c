#include "island.h"

namespace rubicon::proxy {
namespace {

class Discovery : public Island {
 protected:
  void SetUp() override {
    remember();
    config.discovery.otherwise = Admission::kAsk;
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
  config.discovery.rules = {{"hall", "", "9.*", Admission::kIgnore}, {"h*", "lamp", "", Admission::kAuto}};
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
  config.discovery.otherwise = Admission::kAuto;
  start();
  join("7", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.7", "ignore").verdict, Verdict::kApplied);
  EXPECT_FALSE(exists("proxy.hall.7.status"));
  restart();
  join("7", lamp());
  EXPECT_FALSE(exists("proxy.hall.7.status"));
}

TEST_F(Discovery, ManyAreApprovedByPattern) {
  start();
  for (const auto* address : {"1.1", "1.2", "2.1"}) join(address, lamp());
  ASSERT_EQ(set("proxy.inbox", "approve hall.1_*").verdict, Verdict::kApplied);
  EXPECT_TRUE(exists("proxy.hall.1_1.status"));
  EXPECT_TRUE(exists("proxy.hall.1_2.status"));
  EXPECT_EQ(inbox()["count"], 1);
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

TEST_F(Discovery, NewRulesAreAskedAtOnceForThoseWhoWait) {
  start();
  join("7", lamp());
  join("8", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.8", "ignore").verdict, Verdict::kApplied);
  config.discovery.otherwise = Admission::kAuto;
  proxy->reconfigure(config);
  time.run_ready();
  EXPECT_TRUE(exists("proxy.hall.7.status"));
  EXPECT_FALSE(exists("proxy.hall.8.status"));
}

}  // namespace
}  // namespace rubicon::proxy
