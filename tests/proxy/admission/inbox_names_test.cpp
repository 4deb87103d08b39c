#include "proxy/island.h"

// What a name without wildcards means when a user decides about devices of the inbox.

namespace rubicon::proxy::admission {
namespace {

class InboxNames : public Island {
 protected:
  void SetUp() override {
    remember();
    config.discovery.otherwise = DiscoveryAction::kAsk;
    start();
  }
  Reply decide(const std::string& text) { return set("proxy.inbox", text); }
  std::string listed(const std::string& device) {
    const auto key = "proxy.hall." + device + ".description";
    return exists(key) ? json(key)["address"].get<std::string>() : "(none)";
  }
};

TEST_F(InboxNames, TheKeyThatIsShownComesBeforeAnAddress) {
  join("1.7", lamp());
  join("1_7", lamp());
  ASSERT_EQ(decide("approve hall.1_7").verdict, Verdict::kApplied);
  EXPECT_EQ(listed("1_7"), "1.7");
  EXPECT_TRUE(exists("proxy.inbox.hall.1_7_2"));
}

TEST_F(InboxNames, AnAddressMeansAlsoAnIgnoredDevice) {
  join("1.4.6", lamp());
  ASSERT_EQ(decide("ignore hall.1.4.6").verdict, Verdict::kApplied);
  ASSERT_EQ(decide("approve hall.1.4.6").verdict, Verdict::kApplied);
  EXPECT_EQ(listed("1_4_6"), "1.4.6");
}

TEST_F(InboxNames, AnIdThatAReloadGaveToAnIgnoredDeviceNamesIt) {
  join("1.7", lamp());
  ASSERT_EQ(decide("ignore hall.1_7").verdict, Verdict::kApplied);
  rules().devices["1.7"].id = "attic";
  proxy->reconfigure(config);
  ASSERT_EQ(decide("approve hall.attic").verdict, Verdict::kApplied);
  EXPECT_EQ(listed("attic"), "1.7");
}

TEST_F(InboxNames, AnIdThatAReloadTookAwayNamesNoDevice) {
  rules().devices["1.7"].id = "attic";
  proxy->reconfigure(config);
  join("1.7", lamp());
  ASSERT_EQ(decide("ignore hall.attic").verdict, Verdict::kApplied);
  rules().devices.clear();
  proxy->reconfigure(config);
  EXPECT_EQ(decide("approve hall.attic").code, ErrorCode::kNotFound);
  ASSERT_EQ(decide("approve hall.1_7").verdict, Verdict::kApplied);
  EXPECT_EQ(decide("approve hall.1_7").code, ErrorCode::kNotFound) << "it is listed";
}

TEST_F(InboxNames, APatternMeansTheKeysThatFitItAndNoOthers) {
  for (const auto* address : {"1", "10", "11", "2", "21"}) join(address, lamp());
  ASSERT_EQ(decide("approve hall.1?").verdict, Verdict::kApplied);
  EXPECT_EQ(listed("1"), "(none)");
  EXPECT_EQ(listed("10"), "10");
  EXPECT_EQ(listed("11"), "11");
  ASSERT_EQ(decide("approve *1").verdict, Verdict::kApplied);
  EXPECT_EQ(listed("1"), "1");
  EXPECT_EQ(listed("2"), "(none)");
  EXPECT_EQ(listed("21"), "21");
  EXPECT_EQ(decide("approve hall.3*").code, ErrorCode::kNotFound);
}

TEST_F(InboxNames, AForgottenDeviceIsANewOne) {
  join("7", lamp());
  ASSERT_EQ(decide("approve hall.7").verdict, Verdict::kApplied);
  ASSERT_EQ(set("proxy.hall.7.description", R"({"name":"Kitchen lamp"})").verdict, Verdict::kApplied);
  ASSERT_EQ(decide("forget hall.7").verdict, Verdict::kApplied);
  time.run_for(2s);
  EXPECT_EQ(listed("7"), "(none)");
  EXPECT_FALSE(*store->find("hall", "7"));
  join("7", lamp());
  EXPECT_TRUE(exists("proxy.inbox.hall.7")) << "it waits for a decision as one that was never heard";
  ASSERT_EQ(decide("approve hall.7").verdict, Verdict::kApplied);
  EXPECT_EQ(json("proxy.hall.7.description")["name"], "Lamp");
}

TEST_F(InboxNames, AForgottenDeviceIsNoLongerIgnored) {
  join("7", lamp());
  ASSERT_EQ(decide("ignore hall.7").verdict, Verdict::kApplied);
  ASSERT_EQ(decide("forget hall.7").verdict, Verdict::kApplied);
  join("7", lamp());
  EXPECT_TRUE(exists("proxy.inbox.hall.7"));
}

}  // namespace
}  // namespace rubicon::proxy::admission
