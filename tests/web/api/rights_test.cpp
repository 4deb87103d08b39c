#include "support/rights.h"
#include "web/api/fake_history.h"
#include "web/api/feed.h"
#include "web/api/site.h"

namespace rubicon::web::api {
namespace {

using support::Right;
using support::rule;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kTemperatureKey = "proxy.scripted-1.7.sensor.temperature-1.value";
constexpr const char* kLightKey = "proxy.scripted-1.7.sensor.light-1.value";
constexpr const char* kSwitchKey = "proxy.scripted-1.7.actuator.switch-1.command";

/// A site with rights: callers are judged by the name and the roles of their token.
class RightsOfCallers : public Sites {
 protected:
  RightsOfCallers() {
    options.island = OwnerId(1);
    options.history = &history;
  }
  void judge_by(std::vector<rights::Rule> rules) {
    ecology.judge(OwnerId(kSite), support::judge_of(std::move(rules), audit));
    start_lamp();
    devices_of(1).say("7", reading(sensor("light"), 100.0));
    measure(20.5);
  }
  Caller tablet(Role role = Role::kCommand, std::vector<std::string> roles = {}) const {
    return {"tablet", role, "10.0.0.9", 0, std::move(roles)};
  }
  Response ask_as(const Caller& caller, const std::string& method, const std::string& target,
                  const std::string& body = "", Fields headers = {}) {
    auto request = request_of(method, target, body, std::move(headers));
    request.caller = caller;
    std::optional<Response> response;
    const auto exchange = site().handle(request, [&](Response answer) { response = std::move(answer); });
    for (int i = 0; i < 1200 && !response; ++i) scheduler.run_for(50ms);
    EXPECT_TRUE(response) << method << " " << target;
    return response.value_or(Response{0});
  }
  std::vector<std::string> keys_of(const Caller& caller, const std::string& target) {
    std::vector<std::string> keys;
    const auto answer = Json::parse(ask_as(caller, "GET", target).body);
    for (const auto& tuple : answer.value("tuples", Json::array())) keys.push_back(tuple["key"]);
    return keys;
  }
  /// The keys that a WebSocket's subscription brings.
  std::vector<std::string> keys_of_subscription(const Caller& caller, const Json& subscribe) {
    Page page(scheduler, site(), caller);
    page.ask(subscribe);
    scheduler.run_for(1s);
    std::vector<std::string> keys;
    for (const auto& frame : page.frames) {
      const auto introduced = frame.value("k", Json::object());
      for (const auto& [number, key] : introduced.items()) keys.push_back(key);
    }
    return keys;
  }
  Json answer_of(const Caller& caller, const Json& request) {
    Page page(scheduler, site(), caller);
    const auto id = page.ask(request);
    scheduler.run_for(10s);
    for (const auto& frame : page.frames) {
      if (frame.value("id", 0) == id) return frame;
    }
    return {};
  }

  std::shared_ptr<support::CollectingAudit> audit = std::make_shared<support::CollectingAudit>();
  FakeHistory history{scheduler};
};

TEST_F(RightsOfCallers, AListHasWhatTheCallerMayRead) {
  judge_by({rule("tablet", {Right::kRead}, {"proxy.*.*.sensor.**"}, {"proxy.*.*.sensor.light-1.**"})});
  const auto keys = keys_of(tablet(), "/api/v1/tuples?pattern=1:proxy.scripted-1.7.**&limit=1000");
  EXPECT_THAT(keys, Contains(kTemperatureKey));
  for (const auto& key : keys) {
    EXPECT_THAT(key, HasSubstr(".sensor."));
    EXPECT_THAT(key, testing::Not(HasSubstr("light-1")));
  }
  EXPECT_THAT(audit->lines, IsEmpty());
}

TEST_F(RightsOfCallers, WithoutARuleAllListsAreEmptyAndTuplesRefused) {
  judge_by({});
  EXPECT_THAT(keys_of(tablet(), "/api/v1/tuples?pattern=*:**"), IsEmpty());
  EXPECT_EQ(Json::parse(ask_as(tablet(), "GET", "/api/v1/devices").body)["devices"], Json::array());
  EXPECT_EQ(Json::parse(ask_as(tablet(), "GET", "/api/v1/things").body)["things"], Json::array());
  EXPECT_EQ(Json::parse(ask_as(tablet(Role::kAdmin), "GET", "/api/v1/inbox").body)["devices"], Json::array());
  EXPECT_EQ(ask_as(tablet(), "GET", "/api/v1/devices/1/scripted-1/7").status, 404U);
  EXPECT_THAT(ask_as(tablet(), "GET", "/metrics").body, testing::Not(HasSubstr("scripted-1")));
  const auto one = ask_as(tablet(), "GET", std::string("/api/v1/tuples/1/") + kTemperatureKey);
  EXPECT_EQ(one.status, 403U);
  EXPECT_THAT(one.body, HasSubstr("tablet may not read"));
  EXPECT_THAT(audit->lines, ElementsAre(std::string("tablet read ") + kTemperatureKey + ": refused"));
  EXPECT_THAT(audit->hosts, ElementsAre("10.0.0.9"));
}

/// It may let the page vouch for its tokens.
TEST_F(RightsOfCallers, TheOwnerLearnsWhoseWishASetIs) {
  judge_by({rule("tablet", {Right::kSet}, {"lamp", "lamp.command", "log"})});
  const auto link = std::move(*ecology.join(OwnerId(70000)));
  tuples::TupleSpace owner(OwnerId(70000), scheduler, *link);
  std::vector<std::string> askers;
  for (const auto* key : {"lamp", "lamp.command", "log"}) ASSERT_TRUE(owner.set(key, "a"));
  const auto policy = owner.add_policy(
      *Pattern::parse("**"),
      [&](const tuples::RemoteSet& set) {
        askers.push_back(set.asker);
        return tuples::SetDecision::applied();
      },
      tuples::PolicyScope::kSetsAndAppends);
  scheduler.run_for(1s);
  EXPECT_EQ(ask_as(tablet(), "PUT", "/api/v1/tuples/70000/lamp", "on").status, 200U);
  EXPECT_EQ(ask_as(tablet(), "PUT", "/api/v1/tuples/70000/lamp.command", "on").status, 200U);
  EXPECT_THAT(askers, ElementsAre("token:tablet", "token:tablet"));
}

TEST_F(RightsOfCallers, ASubscriptionBringsWhatTheCallerMayRead) {
  judge_by({rule("tablet", {Right::kRead}, {"proxy.*.*.sensor.temperature-1.*"})});
  const Json all{{"do", "subscribe"}, {"pattern", "*:**"}};
  EXPECT_THAT(keys_of_subscription(tablet(), all), Contains(HasSubstr(kTemperatureKey)));
  for (const auto& key : keys_of_subscription(tablet(), all)) EXPECT_THAT(key, HasSubstr("temperature-1"));
  EXPECT_THAT(keys_of_subscription({"other", Role::kAdmin, "10.0.0.8"}, all), IsEmpty());
}

TEST_F(RightsOfCallers, AnEventStreamBringsWhatTheCallerMayRead) {
  judge_by({rule("tablet", {Right::kRead}, {"proxy.*.*.sensor.temperature-1.*"})});
  const auto response = ask_as(tablet(), "GET", "/api/v1/tuples?pattern=*:**", "", {{"accept", "text/event-stream"}});
  ASSERT_TRUE(response.stream);
  auto stream = response.stream({[] {}, [](std::string_view) {}});
  std::string text;
  for (int i = 0; i < 20; ++i) {
    scheduler.run_for(100ms);
    while (const auto frame = stream->next()) text += *frame;
  }
  EXPECT_THAT(text, HasSubstr(kTemperatureKey));
  EXPECT_THAT(text, testing::Not(HasSubstr("light-1")));
}

TEST_F(RightsOfCallers, AnActiveSubscriptionWakesOnlyWhatTheCallerMayWake) {
  judge_by({rule("tablet", {Right::kRead}), rule("tablet", {Right::kDemand}, {kTemperatureKey})});
  Page page(scheduler, site(), tablet());
  page.ask({{"do", "subscribe"}, {"pattern", "1:proxy.scripted-1.7.sensor.*.value"}, {"active", true}});
  scheduler.run_for(1s);
  EXPECT_EQ(devices_of(1).sampled["7"].points, std::vector{sensor("temperature")});
  page.end();
  scheduler.run_for(1s);
  EXPECT_TRUE(devices_of(1).sampled["7"].points.empty());
  const auto one =
      answer_of(tablet(), {{"do", "subscribe"}, {"pattern", std::string("1:") + kLightKey}, {"active", true}});
  EXPECT_EQ(one["ok"], false);
  EXPECT_THAT(audit->lines, ElementsAre(std::string("tablet demand ") + kLightKey + ": refused"));
}

TEST_F(RightsOfCallers, WhatTheCallerMayNotReadCountsNowhere) {
  judge_by({rule("tablet", {Right::kRead}, {"a.*"})});
  auto& owner = component(70000);
  for (int i = 0; i < 50; ++i) {
    ASSERT_TRUE(owner.set("a." + std::to_string(i), "1"));
    ASSERT_TRUE(owner.set("b." + std::to_string(i), "1"));
  }
  Context context(scheduler, component(kSite), log, *access, options);
  EventStock stock;
  const Feed::Callbacks calls{[] {}, [] {}, [](const char*) {}};
  std::optional<Feed> feed(std::in_place, context, tablet(), stock, verbs::Subscription{*Pattern::parse("70000:**")},
                           std::make_unique<SocketWriter>(1, false), calls);
  scheduler.run_for(1s);
  EXPECT_EQ(stock.tuples, 50U);
  EXPECT_EQ(stock.hidden, 50U);
  owner.erase(*Pattern::parse("b.*"));
  scheduler.run_for(1s);
  EXPECT_EQ(stock.hidden, 0U);
  feed.reset();
  EXPECT_EQ(stock.tuples, 0U);
}

TEST_F(RightsOfCallers, ManyConnectionsShareTheDemandForATuple) {
  judge_by({rule("tablet", {Right::kRead, Right::kDemand}, {"a.*"})});
  auto& owner = component(70000);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(owner.set("a." + std::to_string(i), "1"));
  const auto before = owner.stats().subscriptions;
  const Json all{{"do", "subscribe"}, {"pattern", "70000:**"}, {"active", true}};
  Page one(scheduler, site(), tablet()), two(scheduler, site(), tablet());
  one.ask(all);
  scheduler.run_for(1s);
  const auto of_one = owner.stats().subscriptions - before;
  EXPECT_GE(of_one, 100U);
  two.ask(all);
  scheduler.run_for(1s);
  EXPECT_LT(owner.stats().subscriptions - before, of_one + 10);
  one.end();
  scheduler.run_for(1s);
  EXPECT_GE(owner.stats().subscriptions - before, 100U);
  two.end();
  scheduler.run_for(1s);
  EXPECT_LT(owner.stats().subscriptions - before, 10U);
}

TEST_F(RightsOfCallers, AnActiveSubscriptionOfTooManyTuplesEndsWithTheReason) {
  judge_by({rule("tablet", {Right::kRead, Right::kDemand}, {"a.*"})});
  auto& owner = component(70000);
  for (std::size_t i = 0; i < EventStock::kMaxDemands; ++i) ASSERT_TRUE(owner.set("a." + std::to_string(i), "1"));
  Page page(scheduler, site(), tablet());
  page.ask({{"do", "subscribe"}, {"pattern", "70000:**"}, {"active", true}});
  scheduler.run_for(2s);
  EXPECT_EQ(page.closed, "");
  ASSERT_TRUE(owner.set("a.more", "1"));
  scheduler.run_for(1s);
  EXPECT_THAT(page.closed, HasSubstr("more than 1,000 tuples in active subscriptions of this connection"));
}

TEST_F(RightsOfCallers, ASetNeedsTheRoleAndTheRight) {
  judge_by({rule("tablet", {Right::kSet}, {kSwitchKey})});
  const auto target = std::string("/api/v1/tuples/1/") + kSwitchKey;
  EXPECT_EQ(ask_as(tablet(), "PUT", target + "?wait=1ms", "on").status, 202U);
  EXPECT_EQ(ask_as(tablet(Role::kView), "PUT", target, "off").status, 403U);
  EXPECT_EQ(ask_as({"other", Role::kAdmin, "10.0.0.8"}, "PUT", target, "off").status, 403U);
  const auto socket = answer_of({"other", Role::kAdmin, "10.0.0.8"},
                                {{"do", "set"}, {"key", std::string("1:") + kSwitchKey}, {"value", "off"}});
  EXPECT_THAT(socket["error"]["text"].dump(), HasSubstr("other may not set"));
  EXPECT_EQ(devices_of(1).commands.size(), 1U);
  const std::string line = std::string(" set ") + kSwitchKey;
  EXPECT_THAT(audit->lines, ElementsAre("tablet" + line + ": accepted", "tablet" + line + ": refused",
                                        "other" + line + ": refused", "other" + line + ": refused"));
}

TEST_F(RightsOfCallers, AMessageCannotBeSetAroundItsRight) {
  judge_by({rule("tablet", {Right::kSet, Right::kRead}, {"**"})});
  const auto admin = tablet(Role::kAdmin);
  for (const std::string key : {"GATEWAY", "RUBICON_GATEWAY.DEVICE"}) {
    for (const std::uint32_t owner : {1U, kSite, 2U})
      EXPECT_EQ(ask_as(admin, "PUT", "/api/v1/tuples/" + std::to_string(owner) + "/" + key, "x").status, 403U)
          << owner << " " << key;
  }
  const auto socket = answer_of(admin, {{"do", "set"}, {"key", "1:GATEWAY"}, {"value", "x"}});
  EXPECT_THAT(socket["error"]["text"].dump(), HasSubstr("expected the verb `send`"));
  const auto appended = answer_of(admin, {{"do", "append"}, {"key", "1:GATEWAY"}, {"value", "x"}});
  EXPECT_EQ(appended["ok"], false);
  ASSERT_EQ(audit->lines.size(), 8U);
  EXPECT_EQ(audit->lines[0], "tablet send GATEWAY: refused");
  EXPECT_TRUE(devices_of(1).commands.empty());
}

TEST_F(RightsOfCallers, WhatTheOwnerRefusesIsOneRefusedLine) {
  judge_by({rule("tablet", {Right::kSet})});
  EXPECT_EQ(ask_as(tablet(), "PUT", std::string("/api/v1/tuples/1/") + kTemperatureKey, "1").status, 409U);
  EXPECT_THAT(audit->lines, ElementsAre(std::string("tablet set ") + kTemperatureKey + ": refused"));
}

TEST_F(RightsOfCallers, ASetWhoseCallerLeavesHasItsLineToo) {
  judge_by({rule("tablet", {Right::kSet})});
  {
    Page page(scheduler, site(), tablet());
    page.ask({{"do", "set"}, {"key", std::string("1:") + kSwitchKey}, {"value", "on"}});
  }
  {
    Page page(scheduler, site(), tablet());
    page.ask({{"do", "set"}, {"key", std::string("1:") + kTemperatureKey}, {"value", "1"}});
  }
  scheduler.run_for(1s);
  EXPECT_THAT(audit->lines, ElementsAre(std::string("tablet set ") + kSwitchKey + ": accepted",
                                        std::string("tablet set ") + kTemperatureKey + ": refused"))
      << "what the owner said";
}

TEST_F(RightsOfCallers, WhatTheServerHasNoTimeForIsARefusedLine) {
  judge_by({rule("tablet", {Right::kSet, Right::kSend})});
  const auto target = std::string("/api/v1/tuples/1/") + kSwitchKey + "?wait=1ms";
  unsigned busy = 0;
  for (unsigned i = 0; i < 2 * Context::kCommandsPerSecond; ++i) {
    auto request = request_of("PUT", target, "on", {});
    request.caller = tablet();
    const auto exchange = site().handle(request, [&](const Response& answer) { busy += answer.status == 429 ? 1 : 0; });
  }
  Page page(scheduler, site(), tablet());
  for (unsigned i = 0; i < 2 * Context::kCommandsPerSecond; ++i)
    page.ask({{"do", "send"}, {"to", 1}, {"network", "scripted-1"}, {"device", "7"}, {"type", "note"}, {"value", "x"}});
  const auto inbox = ask_as(tablet(Role::kAdmin), "POST", "/api/v1/inbox", R"({"approve": "scripted-1.7"})");
  scheduler.run_for(1s);
  EXPECT_GT(busy, 0U);
  const auto count = [this](std::string_view line) {
    return static_cast<unsigned>(std::count(audit->lines.begin(), audit->lines.end(), line));
  };
  EXPECT_GE(count(std::string("tablet set ") + kSwitchKey + ": refused"), busy);
  EXPECT_GT(count("tablet send scripted-1.7: refused"), 0U);
  EXPECT_EQ(audit->lines.size(), 4 * Context::kCommandsPerSecond + 1) << "each has one line";
}

TEST_F(RightsOfCallers, WhatTheRoleRefusesIsARefusedLine) {
  judge_by({rule("tablet", {Right::kSet, Right::kRead, Right::kApprove})});
  EXPECT_EQ(ask_as(tablet(), "POST", "/api/v1/inbox", R"({"approve": "scripted-1.7"})").status, 403U);
  EXPECT_THAT(audit->lines, ElementsAre("tablet approve proxy.inbox: refused"));
}

TEST_F(RightsOfCallers, DecisionsAboutTheInboxNeedApproveAndNotSet) {
  const std::vector<rights::Rule> rules{rule("tablet", {Right::kSet}, {"proxy.**"}), rule("warden", {Right::kApprove})};
  ecology.judge(OwnerId(kSite), support::judge_of(rules, audit));
  start_island(1, "}\ndiscovery: {new-devices: ask");
  devices_of(1).say("7", lamp());
  const std::string order = R"({"approve": "scripted-1.7"})";
  EXPECT_NE(ask_as(tablet(Role::kAdmin), "POST", "/api/v1/inbox", order).status, 200U);
  EXPECT_EQ(ask_as({"warden", Role::kAdmin, ""}, "POST", "/api/v1/inbox", order).status, 200U);
  EXPECT_THAT(audit->lines, ElementsAre("tablet approve proxy.inbox: refused", "warden approve proxy.inbox: accepted"));
}

TEST_F(RightsOfCallers, ADecisionAboutManyLeavesOutTheDevicesThatARuleExcepts) {
  const auto judge =
      support::judge_of({rule("warden", {Right::kApprove}, {"proxy.inbox.**"}, {"proxy.inbox.scripted-1.8"})}, audit);
  ecology.judge(OwnerId(kSite), judge);
  ecology.judge(OwnerId(1), judge);
  start_island(1, "}\ndiscovery: {new-devices: ask");
  for (const auto* device : {"7", "8"}) devices_of(1).say(device, lamp());
  const Caller warden{"warden", Role::kAdmin, ""};
  const auto one = ask_as(warden, "POST", "/api/v1/inbox", R"({"approve": "scripted-1.8"})");
  EXPECT_NE(one.status, 200U);
  EXPECT_THAT(one.body, HasSubstr("warden may not approve proxy.inbox.scripted-1.8"));
  const auto all = ask_as(warden, "POST", "/api/v1/inbox", R"({"approve": "*"})");
  EXPECT_EQ(all.status, 200U);
  EXPECT_THAT(all.body, HasSubstr("1 of 2 devices left out: warden may not approve proxy.inbox.scripted-1.8"));
  scheduler.run_for(1s);
  EXPECT_NE(value(islands[1]->space(), 1, "proxy.scripted-1.7.status"), "(none)");
  EXPECT_EQ(value(islands[1]->space(), 1, "proxy.scripted-1.8.status"), "(none)");
}

TEST_F(RightsOfCallers, MessagesNeedTheRightToSendThere) {
  judge_by({rule("tablet", {Right::kSend}, {"scripted-1.7"})});
  const auto send = [&](std::uint32_t to, const std::string& device) {
    return answer_of(tablet(), {{"do", "send"},
                                {"to", to},
                                {"network", "scripted-1"},
                                {"device", device},
                                {"type", "note"},
                                {"value", "hello"}})["ok"];
  };
  EXPECT_EQ(send(1, "7"), true);
  EXPECT_EQ(send(1, "8"), false);
  EXPECT_EQ(send(2, "7"), false);
  EXPECT_EQ(devices_of(1).sent.size(), 1U);
  EXPECT_THAT(audit->lines, ElementsAre("tablet send scripted-1.7: accepted", "tablet send scripted-1.8: refused",
                                        "tablet send island:2: refused"));
}

TEST_F(RightsOfCallers, AMessageThatCannotBeDeliveredIsNotAccepted) {
  judge_by({rule("tablet", {Right::kSend})});
  const Json request{{"do", "send"},  {"to", 1},        {"network", "no-such"},
                     {"device", "7"}, {"type", "note"}, {"value", "x"}};
  EXPECT_EQ(answer_of(tablet(), request)["ok"], false);
  EXPECT_THAT(audit->lines, ElementsAre("tablet send no-such.7: refused"));
}

TEST_F(RightsOfCallers, AMessageToADeviceNamesItsNetwork) {
  judge_by({rule("tablet", {Right::kSend}, {"**"}, {"scripted-1.7"})});
  const auto answer =
      answer_of(tablet(), {{"do", "send"}, {"to", 1}, {"device", "7"}, {"type", "note"}, {"value", "hello"}});
  EXPECT_EQ(answer["ok"], false);
  EXPECT_THAT(answer.dump(), HasSubstr("expected the id of the network that has device '7'"));
  EXPECT_THAT(devices_of(1).sent, IsEmpty());
  EXPECT_THAT(audit->lines, ElementsAre("tablet send own: refused"));
}

TEST_F(RightsOfCallers, ListeningForMessagesNeedsToReadGateway) {
  judge_by({rule("ear", {Right::kRead}, {"GATEWAY"})});
  const Json listen{{"do", "listen"}, {"type", "note"}};
  EXPECT_EQ(answer_of(tablet(), listen)["ok"], false);
  EXPECT_EQ(answer_of({"ear", Role::kView, ""}, listen)["ok"], true);
}

TEST_F(RightsOfCallers, TheRolesOfATokenAreThoseOfRules) {
  judge_by({rule("command", {Right::kRead}, {kTemperatureKey}), rule("night", {Right::kRead}, {kLightKey})});
  const std::string all = "/api/v1/tuples?pattern=1:**&limit=1000";
  EXPECT_THAT(keys_of(tablet(), all), ElementsAre(kTemperatureKey));
  EXPECT_THAT(keys_of(tablet(Role::kView), all), IsEmpty());
  EXPECT_THAT(keys_of(tablet(Role::kView, {"night"}), all), ElementsAre(kLightKey));
}

TEST_F(RightsOfCallers, TheHistoryAnswersForWhatTheCallerMayRead) {
  judge_by({rule("tablet", {Right::kRead}, {kTemperatureKey})});
  history::SeriesEntry readable, other;
  readable.name = {OwnerId(1), kTemperatureKey};
  other.name = {OwnerId(1), kLightKey};
  history.known = {other, readable};
  const auto page = Json::parse(ask_as(tablet(), "GET", "/api/v1/history/series").body);
  ASSERT_EQ(page["series"].size(), 1U);
  EXPECT_EQ(page["series"][0]["key"], std::string("1:") + kTemperatureKey);
  EXPECT_EQ(ask_as(tablet(), "GET", std::string("/api/v1/history?key=1:") + kLightKey).status, 403U);
  const auto first = Json::parse(ask_as(tablet(), "GET", "/api/v1/history/series?limit=1").body);
  EXPECT_EQ(first, page) << "no series that it may not read is named as the next";
  EXPECT_EQ(ask_as(tablet(), "GET", std::string("/api/v1/history?key=1:") + kTemperatureKey).status, 200U);
}

TEST_F(RightsOfCallers, APageOfSeriesHasItsLimitOfReadableOnes) {
  judge_by({rule("tablet", {Right::kRead}, {"open.*"})});
  for (int i = 0; i < 2500; ++i) {
    history::SeriesEntry one;
    one.name = {OwnerId(1), (i % 1000 == 0 ? "open." : "hidden.") + std::to_string(i)};
    history.known.push_back(one);
  }
  std::vector<std::string> names;
  std::string target = "/api/v1/history/series?limit=2";
  for (int pages = 0; pages < 4 && !target.empty(); ++pages) {
    const auto text = ask_as(tablet(), "GET", target).body;
    EXPECT_THAT(text, testing::Not(HasSubstr("hidden")));
    const auto page = Json::parse(text);
    for (const auto& one : page["series"]) names.push_back(one["key"]);
    target = page.value("next", "");
  }
  EXPECT_THAT(names, ElementsAre("1:open.0", "1:open.1000", "1:open.2000"));
}

}  // namespace
}  // namespace rubicon::web::api
