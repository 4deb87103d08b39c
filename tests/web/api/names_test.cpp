#include <gmock/gmock.h>

#include "support/rights.h"
#include "web/api/route.h"
#include "web/api/site.h"

namespace rubicon::web::api {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// What people call devices, in requests by REST and WebSocket.
class NamesInRequests : public Sites {
 protected:
  void start() {
    start_lamp();
    devices_of(1).say("7", reading(sensor("light"), 100.0));
    measure(20.5);
  }
  /// The key that a request by REST is about, or its error.
  std::string by_rest(const std::string& name, const std::string& method = "GET", const std::string& body = "") {
    const auto dot = name.find(':');
    const auto path = percent_encoded(dot == name.npos ? "*" : name.substr(0, dot)) + "/" +
                      percent_encoded(dot == name.npos ? name : name.substr(dot + 1));
    const auto answer = Json::parse(ask(method, "/api/v1/tuples/" + path, body).body);
    if (answer.contains("error") && !answer.contains("state"))
      return answer["error"]["code"].get<std::string>() + ": " + answer["error"]["text"].get<std::string>();
    return std::to_string(answer["owner"].get<int>()) + ":" + answer["key"].get<std::string>();
  }
  Json by_socket(Json request) {
    auto& page = Sites::page();
    const auto id = page.ask(std::move(request));
    scheduler.run_for(10s);
    Json first;
    for (const auto& frame : page.frames) {
      if (first.is_null() && frame.value("id", 0) == id) first = frame;
    }
    close(page);
    return first;
  }
};

TEST_F(NamesInRequests, AGetTakesTheNamesOfTheCommandLine) {
  start();
  for (const auto* name :
       {"Lamp.temperature", "lamp.TEMPERATURE-1", "7.temperature-1", "scripted-1.7.temperature-1", "1:7.temperature-1",
        "test:Lamp.temperature", "proxy.scripted-1.7.sensor.temperature-1", "1:proxy.scripted-1.7.sensor.temperature-1",
        "proxy.scripted-1.7.sensor.temperature-1.value", kTemperature}) {
    EXPECT_EQ(by_rest(name), kTemperature) << name;
    const auto answer = by_socket({{"do", "get"}, {"key", name}});
    EXPECT_EQ(answer["tuple"]["value"], "20.5") << name << answer;
  }
}

TEST_F(NamesInRequests, WhatIsAskedForByNameIsWholeTupleTextOrStream) {
  start();
  EXPECT_EQ(ask("GET", "/api/v1/tuples/*/Lamp.temperature", "", {{"accept", "text/plain"}}).body, "20.5");
  EXPECT_EQ(get("/api/v1/tuples?pattern=Lamp.temperature")["tuples"].size(), 1U);
  EXPECT_EQ(get("/api/v1/tuples?pattern=Lamp.*%20")["error"]["code"], "invalid");
  EXPECT_EQ(get("/api/v1/tuples?pattern=the%20Lamp.*")["error"]["code"], "not-found");
  EXPECT_TRUE(ask("GET", "/api/v1/tuples?pattern=Lamp.temperature", "", {{"accept", "text/event-stream"}}).stream);
}

TEST_F(NamesInRequests, ASetByNameCommandsThePointAndSaysWhich) {
  start();
  const auto by_name = by_socket({{"do", "set"}, {"key", "Lamp.switch"}, {"value", "on"}});
  EXPECT_EQ(by_name["ok"], true) << by_name;
  EXPECT_EQ(by_name["key"], kSwitch);
  const auto by_key = by_socket({{"do", "set"}, {"key", kSwitch}, {"value", "on"}});
  EXPECT_FALSE(by_key.contains("key")) << "who named it knows it";
  devices_of(1).say("7", reading(actuator("switch"), true));
  EXPECT_EQ(by_rest("Lamp.switch", "PUT", "off"), kSwitch);
  EXPECT_EQ(by_rest("Lamp.light", "PUT", "7"), "not-found: 'Lamp.light' can only be read");
}

TEST_F(NamesInRequests, ASubscriptionByNameSaysWhichPatternItIs) {
  start();
  auto& page = Sites::page();
  const auto one = page.ask({{"do", "subscribe"}, {"pattern", "Lamp.temperature"}});
  const auto all = page.ask({{"do", "subscribe"}, {"pattern", "7.nothing"}});
  scheduler.run_for(10s);
  EXPECT_EQ(page.answer(one)["pattern"], kTemperature);
  EXPECT_EQ(page.sets()[kTemperature][1], "20.5");
  EXPECT_EQ(page.answer(all)["ok"], true) << "it may come later, as the key of any owner";
}

TEST_F(NamesInRequests, SeveralAreListedAndNoneIsNotFound) {
  start();
  devices_of(1).say("8", lamp());
  scheduler.run_for(100ms);
  EXPECT_EQ(by_rest("Lamp.temperature"),
            "invalid: 'Lamp.temperature' is ambiguous; name one of 1:proxy.scripted-1.7.sensor.temperature-1.value, "
            "1:proxy.scripted-1.8.sensor.temperature-1.value");
  const auto none = by_socket({{"do", "get"}, {"key", "Lump.temperature"}});
  EXPECT_EQ(none["error"], Json({{"code", "not-found"},
                                 {"text", "nothing is called 'Lump.temperature'; did you mean 'Lamp.temperature'?"}}));
  EXPECT_EQ(ask("GET", "/api/v1/tuples/*/Nobody.temperature").status, 404U);
  EXPECT_EQ(by_socket({{"do", "get"}, {"key", "1:proxy.nothing"}})["error"]["text"], "no tuple 1:proxy.nothing");
}

TEST_F(NamesInRequests, TheyCountAsLists) {
  start();
  auto& page = Sites::page();
  std::vector<int> ids;
  for (unsigned i = 0; i < Context::kListsPerSecond + 5; ++i)
    ids.push_back(page.ask({{"do", "get"}, {"key", "Lamp.temperature"}}));
  scheduler.run_for(10s);
  EXPECT_EQ(page.answer(ids.front())["ok"], true);
  EXPECT_EQ(page.answer(ids.back())["error"]["code"], "busy");
}

TEST_F(NamesInRequests, WhatACallerMayNotReadHasNoNameForIt) {
  options.island = OwnerId(1);
  ecology.judge(OwnerId(kSite),
                support::judge_of({support::rule("local", {rights::Right::kRead}, {"proxy.scripted-1.8.**"})},
                                  std::make_shared<support::CollectingAudit>()));
  start();
  devices_of(1).say("8", lamp());
  devices_of(1).say("8", reading(sensor("temperature"), 7.0));
  scheduler.run_for(100ms);
  EXPECT_EQ(by_rest("Lamp.temperature"), "1:proxy.scripted-1.8.sensor.temperature-1.value");
  EXPECT_THAT(by_rest("7.temperature-1"), HasSubstr("nothing is called"));
}

TEST_F(NamesInRequests, NamesOfPointsNeedTheRoleAdmin) {
  start();
  const Json names{{"names", {{"scripted-1.7.sensor.light-1", "Window"}}}};
  const auto as_command = ask("PUT", "/api/v1/tuples/1/proxy.overview", names.dump(), {}, Role::kCommand);
  EXPECT_EQ(as_command.status, 403U);
  EXPECT_THAT(as_command.body, HasSubstr("may not set the names of points"));
  const auto as_admin = ask("PUT", "/api/v1/tuples/1/proxy.overview", names.dump());
  EXPECT_THAT(as_admin.body, HasSubstr("no state file")) << "the island decides";
  const auto pins = ask("PUT", "/api/v1/tuples/1/proxy.overview", R"({"pins":[]})", {}, Role::kCommand);
  EXPECT_THAT(pins.body, HasSubstr("no state file"));
  EXPECT_EQ(ask("PUT", "/api/v1/tuples/1/proxy.scripted-1.7.description", R"({"name":"X"})", {}, Role::kCommand).status,
            403U);
}

}  // namespace
}  // namespace rubicon::web::api
