#include "proxy/island.h"

namespace rubicon::proxy::admission {
namespace {

/// An inbox with room for three devices, and a rule that hides those whose address begins with s.
class InboxRoom : public Island {
 protected:
  void SetUp() override {
    remember();
    config.discovery.otherwise = DiscoveryAction::kAsk;
    config.discovery.rules = {{"", "", "s*", DiscoveryAction::kIgnore}};
    config.max_devices = 3;
  }
  nlohmann::json inbox() {
    time.run_for(1s);
    return json("proxy.inbox");
  }
};

TEST_F(InboxRoom, DevicesThatARuleHidesMakeRoomForThoseThatWait) {
  start();
  for (int i = 0; i < 10; ++i) join("s" + std::to_string(i), lamp());
  EXPECT_EQ(inbox()["ignored"], 3);
  for (int i = 0; i < 3; ++i) join(std::to_string(i), lamp());
  EXPECT_EQ(inbox()["count"], 3);
  EXPECT_EQ(inbox()["ignored"], 0);
}

TEST_F(InboxRoom, DevicesThatARuleHidesDoNotPushEachOtherOut) {
  start();
  for (int i = 0; i < 10; ++i) join("s" + std::to_string(i), lamp());
  time.run_for(2s);
  std::vector<std::string> listed;
  const auto ignored = json("proxy.inbox.ignored");
  for (const auto& one : ignored["devices"]) listed.push_back(one["address"]);
  EXPECT_THAT(listed, testing::ElementsAre("s0", "s1", "s2"));
}

TEST_F(InboxRoom, ADeviceThatAUserIgnoresFindsRoomAmongThoseThatARuleHides) {
  start();
  join("7", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.7", "ignore").verdict, Verdict::kApplied);
  time.run_for(1s);
  restart();
  for (int i = 0; i < 10; ++i) join("s" + std::to_string(i), lamp());
  join("7", lamp());
  time.run_for(2s);
  std::vector<std::string> by_user;
  const auto ignored = json("proxy.inbox.ignored");
  for (const auto& one : ignored["devices"]) {
    if (one["by"] == "user") by_user.push_back(one["address"]);
  }
  EXPECT_THAT(by_user, testing::ElementsAre("7")) << "so that it can be approved later";
}

TEST_F(InboxRoom, ADeviceThatNoRuleHidesAnyMoreIsNotListedAsIgnored) {
  start();
  join("s0", lamp());
  time.run_for(2s);
  EXPECT_EQ(json("proxy.inbox.ignored")["count"], 1);
  config.discovery.rules.clear();
  proxy->reconfigure(config);
  EXPECT_EQ(inbox()["count"], 1);
  time.run_for(2s);
  EXPECT_EQ(json("proxy.inbox.ignored")["count"], 0);
}

}  // namespace
}  // namespace rubicon::proxy::admission
