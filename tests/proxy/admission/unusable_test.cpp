#include "proxy/island.h"

// Devices that their network cannot use yet (Join::problem).

namespace rubicon::proxy::admission {
namespace {

class Unusable : public Island {
 protected:
  void SetUp() override { remember(); }
  Join unusable(const std::string& why = "interview failed") const {
    auto message = lamp();
    message.problem = why;
    return message;
  }
  nlohmann::json inbox() {
    time.run_for(1s);
    return json("proxy.inbox");
  }
};

TEST_F(Unusable, ADeviceStandsInTheInboxWithItsReasonAndHasNoTuples) {
  start();
  join("7", unusable());
  const auto all = inbox();
  EXPECT_EQ(all["count"], 1);
  EXPECT_EQ(all["waiting"][0]["address"], "7");
  EXPECT_EQ(all["waiting"][0]["why"], "interview failed");
  EXPECT_FALSE(exists("proxy.hall.7.status"));
  report("7", sensor(kGlow), 5.0);
  EXPECT_FALSE(exists("proxy.hall.7.sensor.glow-1.value"));
  join("7", unusable("interview in progress"));
  EXPECT_EQ(inbox()["waiting"][0]["why"], "interview in progress");
  EXPECT_EQ(inbox()["count"], 1);
}

TEST_F(Unusable, AUsableJoinListsItByTheRules) {
  start();
  join("7", unusable());
  join("7", lamp());
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "reachable");
  EXPECT_EQ(inbox()["count"], 0);
}

TEST_F(Unusable, WhereTheRulesAskItWaitsOnForApproval) {
  config.discovery.otherwise = DiscoveryAction::kAsk;
  start();
  join("7", unusable());
  join("7", lamp());
  EXPECT_EQ(inbox()["waiting"][0]["why"], "discovery.new-devices is ask");
  EXPECT_EQ(set("proxy.inbox.hall.7", "approve").verdict, Verdict::kApplied);
  EXPECT_TRUE(exists("proxy.hall.7.status"));
}

TEST_F(Unusable, ALeaveTakesItFromTheInbox) {
  start();
  join("7", unusable());
  say("7", model::Leave{"removed"});
  EXPECT_EQ(inbox()["count"], 0);
  EXPECT_FALSE(exists("proxy.inbox.hall.7"));
}

TEST_F(Unusable, ItCannotBeApproved) {
  start();
  join("7", unusable());
  const auto refused = set("proxy.inbox.hall.7", "approve");
  EXPECT_EQ(refused.verdict, Verdict::kRefused);
  EXPECT_EQ(refused.text, "hall.7 cannot be used: interview failed");
  EXPECT_EQ(set("proxy.inbox", "approve hall.*").verdict, Verdict::kRefused);
  EXPECT_FALSE(exists("proxy.hall.7.status"));
}

TEST_F(Unusable, APatternApprovesTheUsableOnes) {
  config.discovery.otherwise = DiscoveryAction::kAsk;
  start();
  join("7", unusable());
  join("8", lamp());
  EXPECT_EQ(set("proxy.inbox", "approve hall.*").verdict, Verdict::kApplied);
  EXPECT_TRUE(exists("proxy.hall.8.status"));
  EXPECT_FALSE(exists("proxy.hall.7.status"));
  EXPECT_EQ(inbox()["count"], 1);
}

TEST_F(Unusable, ItCanBeIgnoredAndShownAgain) {
  start();
  join("7", unusable());
  ASSERT_EQ(set("proxy.inbox.hall.7", "ignore").verdict, Verdict::kApplied);
  join("7", unusable("interview in progress"));
  EXPECT_EQ(inbox()["count"], 0);
  EXPECT_EQ(inbox()["ignored"], 1);
  ASSERT_EQ(set("proxy.inbox.hall.7", "approve").verdict, Verdict::kApplied);
  EXPECT_EQ(inbox()["waiting"][0]["why"], "interview in progress");
  EXPECT_FALSE(exists("proxy.hall.7.status"));
  join("7", lamp());
  EXPECT_TRUE(exists("proxy.hall.7.status"));
}

TEST_F(Unusable, ARuleThatIgnoresItIsFollowed) {
  config.discovery.rules = {{"hall", "", "9.*", DiscoveryAction::kIgnore}};
  start();
  join("9.1", unusable());
  EXPECT_EQ(inbox()["count"], 0);
}

TEST_F(Unusable, ANewRuleDoesNotMakeItUsable) {
  config.discovery.otherwise = DiscoveryAction::kAsk;
  start();
  join("7", unusable());
  auto next = config;
  next.discovery.otherwise = DiscoveryAction::kAuto;
  proxy->reconfigure(next);
  time.run_ready();
  EXPECT_FALSE(exists("proxy.hall.7.status"));
  EXPECT_EQ(inbox()["waiting"][0]["why"], "interview failed");
}

TEST_F(Unusable, ADeviceThatIsListedKeepsItsTuplesAndIsUnreachable) {
  start();
  join("7", lamp());
  report("7", sensor(kGlow), 5.0);
  join("7", unusable("interview in progress"));
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "unreachable");
  EXPECT_EQ(json("proxy.hall.7.status")["reason"], "interview in progress");
  EXPECT_EQ(text("proxy.hall.7.sensor.glow-1.value"), "5");
  EXPECT_EQ(inbox()["count"], 0);
  join("7", lamp());
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "reachable");
}

TEST_F(Unusable, AJoinThatWasNotHeardEndsTheProblemAndIsNoSignOfLife) {
  start();
  join("7", lamp());
  join("7", unusable("interview in progress"));
  auto listed = lamp();
  listed.heard = false;
  join("7", listed);
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "unknown");
  EXPECT_EQ(json("proxy.hall.7.status")["reason"], "");
  join("7", unusable());
  EXPECT_EQ(json("proxy.hall.7.status")["reason"], "interview failed");
  join("7", lamp());
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "reachable");
}

TEST_F(Unusable, AJoinThatWasNotHeardEndsNoOtherReason) {
  start();
  join("7", lamp());
  auto listed = lamp();
  listed.heard = false;
  say("7", model::Unreachable{"gone"});
  join("7", listed);
  EXPECT_EQ(json("proxy.hall.7.status")["reason"], "gone");
  join("7", unusable());
  say("7", model::Unreachable{"gone"});
  join("7", listed);
  EXPECT_EQ(json("proxy.hall.7.status")["reason"], "gone");
}

TEST_F(Unusable, AnIgnoredOneKeepsTheNameAndTheAreaOfTheUser) {
  start();
  join("7", lamp());
  ASSERT_EQ(set("proxy.hall.7.description", R"({"name":"Kitchen lamp","area":"Kitchen"})").verdict, Verdict::kApplied);
  ASSERT_EQ(set("proxy.inbox.hall.7", "ignore").verdict, Verdict::kApplied);
  join("7", unusable());
  ASSERT_EQ(set("proxy.inbox.hall.7", "approve").verdict, Verdict::kApplied);
  EXPECT_EQ(inbox()["waiting"][0]["why"], "interview failed");
  time.run_for(20s);
  restart();
  join("7", lamp());
  EXPECT_EQ(json("proxy.hall.7.description")["name"], "Kitchen lamp");
  EXPECT_EQ(json("proxy.hall.7.description")["area"], "Kitchen");
}

TEST_F(Unusable, IsNotRememberedOverARestart) {
  start();
  join("7", unusable());
  time.run_for(20s);
  restart();
  EXPECT_EQ(inbox()["count"], 0);
}

TEST_F(Unusable, OfADeviceThatLeftWhatIsStoredReturns) {
  start();
  join("7", lamp());
  report("7", sensor(kGlow), 5.0);
  time.run_for(20s);
  restart();
  ASSERT_EQ(quality("proxy.hall.7.sensor.glow-1"), "stored");
  join("7", unusable());
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "unreachable");
  join("7", lamp());
  EXPECT_EQ(quality("proxy.hall.7.sensor.glow-1"), "stored");
}

}  // namespace
}  // namespace rubicon::proxy::admission
