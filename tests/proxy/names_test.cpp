#include "island.h"

namespace rubicon::proxy {
namespace {

/// Names and areas that users give devices.
class Names : public Island {
 protected:
  void begin(const std::string& name = {}) {
    if (!name.empty()) rules().devices["7"].name = name;
    remember();
    start();
    join("7", lamp());
  }
  Reply describe(const nlohmann::json& request) { return set(kKey, request.dump()); }
  nlohmann::json description() const { return json(kKey); }
  const std::string kKey = "proxy.hall.7.description";
};

TEST_F(Names, AreGivenBySettingTheDescription) {
  ASSERT_TRUE(robot->describe(R"({"name":"rubicon rename","program":"pid 4 of anna"})"));
  begin();
  EXPECT_EQ(description()["name"], "Lamp");
  EXPECT_FALSE(description().contains("area"));
  EXPECT_EQ(describe({{"name", "Kitchen lamp"}, {"area", "Kitchen"}}).verdict, Verdict::kApplied);
  EXPECT_EQ(description()["name"], "Kitchen lamp");
  EXPECT_EQ(description()["area"], "Kitchen");
  EXPECT_EQ(description()["model"], "ACME L1");
  EXPECT_TRUE(log.contain("proxy.hall.7 is called 'Kitchen lamp' in area 'Kitchen' by rubicon rename (pid 4 of anna)"));
}

TEST_F(Names, AreOnTheDiskWhenTheAnswerComes) {
  begin();
  ASSERT_EQ(describe({{"name", "Kitchen lamp"}, {"area", "Kitchen"}}).verdict, Verdict::kApplied);
  const auto known = store->find("hall", "7");  // no time has passed that could have written it
  ASSERT_TRUE(known && *known);
  EXPECT_EQ((*known)->given_name, "Kitchen lamp");
  EXPECT_EQ((*known)->area, "Kitchen");
}

TEST_F(Names, SurviveARestartARejoinAndAReload) {
  begin();
  describe({{"name", "Kitchen lamp"}, {"area", "Kitchen"}});
  join("7", lamp());
  EXPECT_EQ(description()["name"], "Kitchen lamp");
  restart();
  EXPECT_EQ(description()["name"], "Kitchen lamp");
  EXPECT_EQ(description()["area"], "Kitchen");
  auto next = config;
  next.networks["hall"].rate = 500ms;
  proxy->reconfigure(next);
  EXPECT_EQ(description()["name"], "Kitchen lamp");
  join("7", lamp());
  time.run_for(2s);
  restart();
  EXPECT_EQ(description()["area"], "Kitchen");
}

TEST_F(Names, TheAreaThatANetworkAnnouncesIsShownUntilAUserGivesAnother) {
  begin();
  auto placed = lamp();
  placed.area = "Cellar";
  join("7", placed);
  EXPECT_EQ(description()["area"], "Cellar");
  describe({{"area", "Kitchen"}});
  join("7", placed);
  EXPECT_EQ(description()["area"], "Kitchen");
  describe({{"area", ""}});
  EXPECT_EQ(description()["area"], "Cellar");
}

TEST_F(Names, AreTakenAwayByEmptyTexts) {
  begin();
  describe({{"name", "Kitchen lamp"}, {"area", "Kitchen"}});
  EXPECT_EQ(describe({{"name", ""}}).verdict, Verdict::kApplied);
  EXPECT_EQ(description()["name"], "Lamp");
  EXPECT_EQ(description()["area"], "Kitchen");
  describe({{"area", ""}});
  restart();
  EXPECT_EQ(description()["name"], "Lamp");
  EXPECT_FALSE(description().contains("area"));
}

TEST_F(Names, OfTheConfigurationGoBefore) {
  begin("Hall lamp");
  const auto reply = describe({{"name", "Kitchen lamp"}});
  EXPECT_EQ(reply.code, ErrorCode::kRefused);
  EXPECT_THAT(reply.text, ::testing::HasSubstr("networks.hall.devices.7.name"));
  EXPECT_EQ(description()["name"], "Hall lamp");
  EXPECT_EQ(describe({{"area", "Kitchen"}}).verdict, Verdict::kApplied) << "that one the configuration leaves open";
  auto next = config;
  next.networks["hall"].devices["7"].area = "Hall";
  proxy->reconfigure(next);
  EXPECT_EQ(description()["area"], "Hall");
  next.networks["hall"].devices["7"].area.clear();
  proxy->reconfigure(next);
  EXPECT_EQ(description()["area"], "Kitchen") << "what the user said is kept";
}

TEST_F(Names, AreRefusedWhereTheyWouldBeLost) {
  start();
  join("7", lamp());
  const auto reply = describe({{"name", "Kitchen lamp"}});
  EXPECT_EQ(reply.verdict, Verdict::kRefused);
  EXPECT_THAT(reply.text, ::testing::HasSubstr("no state file"));
  EXPECT_EQ(description()["name"], "Lamp");
}

TEST_F(Names, ThatAreNoneAreRefusedWithWhatWasExpected) {
  begin();
  const std::pair<std::string, ErrorCode> wrong[] = {
      {"Kitchen lamp", ErrorCode::kInvalid},
      {"{}", ErrorCode::kInvalid},
      {R"({"name":7})", ErrorCode::kInvalid},
      {R"({"name":"a\nb"})", ErrorCode::kInvalid},
      {R"({"name":"\xff"})", ErrorCode::kInvalid},
      {R"({"model":"x"})", ErrorCode::kRefused},
      {R"({"name":"x","model":"x"})", ErrorCode::kRefused},
      {R"({"name":")" + std::string(129, 'x') + "\"}", ErrorCode::kOutOfRange}};
  for (const auto& [text, code] : wrong) {
    const auto reply = set(kKey, text);
    EXPECT_EQ(reply.verdict, Verdict::kRefused) << text;
    EXPECT_EQ(reply.code, code) << text << ": " << reply.text;
  }
  EXPECT_EQ(set("proxy.hall.99.description", R"({"name":"x"})").code, ErrorCode::kNotFound);
  EXPECT_EQ(description()["name"], "Lamp");
}

TEST_F(Names, InAFloodAreRefusedBusyForTheDisksSake) {
  begin();
  int applied = 0;
  for (int i = 0; i < 100; ++i) applied += describe({{"name", std::to_string(i)}}).verdict == Verdict::kApplied;
  EXPECT_EQ(applied, 20);
  EXPECT_EQ(description()["name"], "19");
  time.run_for(1s);
  EXPECT_EQ(describe({{"name", "later"}}).verdict, Verdict::kApplied);
}

}  // namespace
}  // namespace rubicon::proxy
