#include "web/api/site.h"

namespace rubicon::web::api {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

using InboxOfTheApi = Sites;

TEST_F(InboxOfTheApi, TheInboxIsListedAndDecided) {
  island::Island& island = start_island(1, "}\ndiscovery: {new-devices: ask");
  (void)island;
  devices_of(1).say("7", lamp());
  scheduler.run_for(1s);
  const auto inbox = get("/api/v1/inbox");
  ASSERT_EQ(inbox["devices"].size(), 1U);
  EXPECT_EQ(inbox["devices"][0]["key"], "scripted-1.7");
  EXPECT_EQ(inbox["devices"][0]["island"], 1);
  EXPECT_EQ(inbox["devices"][0]["state"], "waiting");
  EXPECT_EQ(inbox["waiting"], 1);
  EXPECT_EQ(inbox["ignored"], 0);
  EXPECT_EQ(ask("POST", "/api/v1/inbox", R"({"approve":"scripted-1.7"})", {}, Role::kCommand).status, 403U);
  const auto approved = ask("POST", "/api/v1/inbox", R"({"approve":"scripted-1.7"})");
  EXPECT_EQ(approved.status, 200U);
  EXPECT_EQ(
      Json::parse(approved.body),
      Json({{"island", 1}, {"decision", "approve"}, {"device", "scripted-1.7"}, {"state", "applied"}, {"reason", ""}}));
  scheduler.run_for(1s);
  EXPECT_THAT(get("/api/v1/inbox")["devices"], IsEmpty());
  EXPECT_EQ(get("/api/v1/devices")["devices"].size(), 1U);
  start_island(2);
  scheduler.run_for(1s);
  const auto which = ask("POST", "/api/v1/inbox", R"({"ignore":"scripted-1.7"})");
  EXPECT_EQ(which.status, 400U);
  EXPECT_THAT(which.body, HasSubstr("island is missing; expected one of 1, 2"));
  devices_of(1).say("8", lamp());
  scheduler.run_for(1s);
  EXPECT_EQ(ask("POST", "/api/v1/inbox", R"({"ignore":"scripted-1.8","island":1})").status, 200U);
  scheduler.run_for(1s);
  const auto ignored = get("/api/v1/inbox");
  EXPECT_EQ(ignored["ignored"], 1);
  ASSERT_EQ(ignored["devices"].size(), 1U) << ignored;
  EXPECT_EQ(ignored["devices"][0]["state"], "ignored");
  EXPECT_EQ(ignored["devices"][0]["by"], "user");
  EXPECT_EQ(ignored["devices"][0]["address"], "8");
  const Json back{{"island", 1}, {"approve", ignored["devices"][0]["key"]}};
  EXPECT_EQ(ask("POST", "/api/v1/inbox", back.dump()).status, 200U);
  scheduler.run_for(1s);
  EXPECT_EQ(get("/api/v1/devices")["devices"].size(), 2U);
}

TEST_F(InboxOfTheApi, AnApprovedDeviceMayBeIgnoredAgain) {
  start_island(1, "}\ndiscovery: {new-devices: ask");
  devices_of(1).say("7", lamp());
  scheduler.run_for(1s);
  EXPECT_EQ(ask("POST", "/api/v1/inbox", R"({"approve":"scripted-1.7"})").status, 200U);
  scheduler.run_for(1s);
  EXPECT_EQ(ask("POST", "/api/v1/inbox", R"({"ignore":"scripted-1.7"})").status, 200U);
  scheduler.run_for(1s);
  EXPECT_THAT(get("/api/v1/devices")["devices"], IsEmpty());
  const auto none = ask("POST", "/api/v1/inbox", R"({"ignore":"scripted-1.9"})");
  EXPECT_EQ(none.status, 404U) << none.body;
  EXPECT_EQ(Json::parse(none.body)["error"]["code"], "not-found");
}

TEST_F(InboxOfTheApi, AListOfTheInboxIsDecidedOneByOne) {
  start_island(1, "}\ndiscovery: {new-devices: ask");
  for (const auto* address : {"1", "2", "3"}) devices_of(1).say(address, lamp());
  scheduler.run_for(1s);
  const auto some = ask("POST", "/api/v1/inbox",
                        R"({"approve":["scripted-1.1","scripted-1.9"],"ignore":["scripted-1.2"],"island":1})");
  EXPECT_EQ(some.status, 200U) << some.body;
  const auto answer = Json::parse(some.body);
  ASSERT_EQ(answer["decisions"].size(), 3U);
  EXPECT_EQ(answer["decisions"][0]["state"], "applied");
  EXPECT_EQ(answer["decisions"][1]["state"], "refused");
  EXPECT_EQ(answer["decisions"][1]["device"], "scripted-1.9");
  EXPECT_EQ(answer["decisions"][1]["error"]["code"], "not-found");
  EXPECT_EQ(answer["decisions"][2]["decision"], "ignore");
  EXPECT_EQ(answer["decisions"][2]["state"], "applied");
  EXPECT_FALSE(answer.contains("error"));
  scheduler.run_for(1s);
  EXPECT_EQ(get("/api/v1/devices")["devices"].size(), 1U);
  const auto none = ask("POST", "/api/v1/inbox", R"({"approve":["scripted-1.9"]})");
  EXPECT_EQ(none.status, 404U);
  EXPECT_EQ(Json::parse(none.body)["error"]["code"], "not-found");
  EXPECT_EQ(Json::parse(none.body)["decisions"].size(), 1U);
}

TEST_F(InboxOfTheApi, AThousandAreDecidedByOneRequest) {
  start_island(1, "}\ndiscovery: {new-devices: ask");
  Json names = Json::array();
  for (int i = 1; i <= 1000; ++i) {
    devices_of(1).say(std::to_string(i), lamp());
    names.push_back("scripted-1." + std::to_string(i));
  }
  scheduler.run_for(2s);
  EXPECT_EQ(get("/api/v1/inbox")["waiting"], 1000);
  const auto all = ask("POST", "/api/v1/inbox", Json{{"approve", names}}.dump());
  EXPECT_EQ(all.status, 200U);
  scheduler.run_for(2s);
  EXPECT_EQ(get("/api/v1/inbox")["waiting"], 0);
  names.push_back("scripted-1.1001");
  const auto many = ask("POST", "/api/v1/inbox", Json{{"approve", names}}.dump());
  EXPECT_EQ(many.status, 400U);
  EXPECT_THAT(many.body, HasSubstr("a list of 1 to 1000"));
}

TEST_F(InboxOfTheApi, OnlyIslandsHaveInboxes) {
  start_island(1, "}\ndiscovery: {new-devices: ask");
  devices_of(1).say("7", lamp());
  auto& stranger = component(70001);
  for (const auto* key : {"proxy.inbox", "other.inbox"}) ASSERT_TRUE(stranger.set(key, R"({"count":5,"ignored":6})"));
  ASSERT_TRUE(stranger.set("proxy.inbox.scripted-1.8", R"({"key":"scripted-1.8"})"));
  scheduler.run_for(1s);
  const auto inbox = get("/api/v1/inbox");
  EXPECT_EQ(inbox["devices"].size(), 1U) << inbox;
  EXPECT_EQ(inbox["waiting"], 1);
  EXPECT_EQ(inbox["ignored"], 0);
  const auto approved = ask("POST", "/api/v1/inbox", R"({"approve":"scripted-1.7"})");
  EXPECT_EQ(approved.status, 200U) << approved.body;
}

TEST_F(InboxOfTheApi, ManyPatternsUseUpTheAllowanceOfCommands) {
  start_island(1, "}\ndiscovery: {new-devices: ask");
  scheduler.run_for(1s);
  const Json patterns(std::vector<std::string>(200, "*.nosuch"));
  const auto busy = [this] { return ask("POST", "/api/v1/inbox", R"({"approve":"scripted-1.1"})").status == 429U; };
  EXPECT_EQ(ask("POST", "/api/v1/inbox", Json{{"approve", patterns}}.dump()).status, 404U);
  EXPECT_TRUE(busy());
  scheduler.run_for(2s);
  EXPECT_TRUE(busy()) << "200 patterns are the commands of four seconds";
  scheduler.run_for(2s);
  EXPECT_FALSE(busy());
}

TEST_F(InboxOfTheApi, AThousandNamesCountAsTwentyCommands) {
  start_island(1, "}\ndiscovery: {new-devices: ask");
  scheduler.run_for(1s);
  Json names = Json::array();
  for (int i = 1; i <= 1000; ++i) names.push_back("scripted-1." + std::to_string(i));
  const auto request = request_of("POST", "/api/v1/inbox", Json{{"approve", names}}.dump());
  std::vector<unsigned> answers;
  std::vector<std::unique_ptr<Exchange>> open;
  for (int i = 0; i < 4; ++i)
    open.push_back(site().handle(request, [&](const Response& answer) { answers.push_back(answer.status); }));
  EXPECT_EQ(answers, std::vector{429U}) << "of four at once the last one is refused";
  scheduler.run_for(1s);
  EXPECT_EQ(answers, (std::vector{429U, 404U, 404U, 404U}));
}

}  // namespace
}  // namespace rubicon::web::api
