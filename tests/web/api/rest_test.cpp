#include "support/collecting_log.h"
#include "web/api/site.h"

namespace rubicon::web::api {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class Rest : public Sites {
 protected:
  std::vector<std::unique_ptr<Exchange>> requests;
};

std::vector<std::string> keys_of(const Json& list) {
  std::vector<std::string> keys;
  for (const auto& one : list) keys.push_back(one["key"]);
  return keys;
}

TEST_F(Rest, TheSiteTellsWhatItIs) {
  EXPECT_EQ(get("/api/v1"), Json({{"version", "1"},
                                  {"name", "hall"},
                                  {"id", kSite},
                                  {"history", false},
                                  {"tokens", false},
                                  {"caller", {{"name", "local"}, {"role", "admin"}}},
                                  {"release", RUBICON_VERSION}}));
  EXPECT_EQ(ask("GET", "/healthz", "", {}, Role::kNone).body, "ok\n");
}

TEST_F(Rest, ASiteOfNoIslandTellsWhereItLooks) {
  options.place = "domain 7 on eth0";
  options.place_options = "--domain 7 --interfaces eth0";
  EXPECT_EQ(get("/api/v1")["place"], Json({{"text", "domain 7 on eth0"}, {"options", "--domain 7 --interfaces eth0"}}));
}

TEST_F(Rest, IslandsAreThoseThatArePresent) {
  site();
  start_island(1);
  start_island(2);
  component(70000);
  scheduler.run_for(1s);
  const auto islands = get("/api/v1/islands")["islands"];
  ASSERT_EQ(islands.size(), 2U);
  EXPECT_EQ(islands[0]["id"], 1);
  EXPECT_EQ(islands[0]["name"], "test");
}

TEST_F(Rest, DevicesComeInPagesInNaturalOrder) {
  start_island(1);
  start_island(2);
  for (const auto* device : {"10", "9", "2"}) devices_of(1).say(device, lamp());
  devices_of(2).say("1", lamp());
  scheduler.run_for(1s);
  const auto first = get("/api/v1/devices?limit=3");
  EXPECT_THAT(keys_of(first["devices"]),
              ElementsAre("proxy.scripted-1.2", "proxy.scripted-1.9", "proxy.scripted-1.10"));
  EXPECT_EQ(first["devices"][0]["status"], "reachable");
  EXPECT_EQ(first["devices"][0]["line"], "up");
  EXPECT_EQ(first["next"], "/api/v1/devices?limit=3&after=1:proxy.scripted-1.10");
  const auto second = get(first["next"]);
  EXPECT_THAT(keys_of(second["devices"]), ElementsAre("proxy.scripted-1.1"));
  EXPECT_FALSE(second.contains("next"));
  EXPECT_EQ(get("/api/v1/devices?island=2")["devices"].size(), 1U);
  EXPECT_EQ(get("/api/v1/devices?type=temperature&name=1*")["devices"].size(), 2U);
  EXPECT_THAT(get("/api/v1/devices?network=knx*")["devices"], IsEmpty());
}

TEST_F(Rest, TheLogNamesTheTokenThatSetATupleWhereNoRightsDo) {
  start_lamp();
  const auto lines_of = [this](bool tokens) {
    if (tokens) need_token();
    support::CollectingLog lines;
    Api api(scheduler, component(kSite), lines, *access, options);
    auto request = request_of("PUT", "/api/v1/tuples/1/" + std::string(kSwitch).substr(2) + "?wait=0s", "on");
    if (tokens) request.caller.name = "robot";
    const auto exchange = api.handle(request, [](const Response&) {});
    scheduler.run_for(1s);
    return lines.lines;
  };
  EXPECT_THAT(lines_of(false), IsEmpty());
  EXPECT_THAT(lines_of(true), ElementsAre(HasSubstr("token 'robot' of 127.0.0.1: "
                                                    "1:proxy.scripted-1.7.actuator.switch-1.command = 'on', applied")));
}

TEST_F(Rest, ADeviceHasItsPointsWithValueStatusAndDescription) {
  start_lamp();
  measure(20.5);
  const auto device = get("/api/v1/devices/1/scripted-1/7");
  EXPECT_EQ(device["name"], "Lamp");
  ASSERT_EQ(device["points"].size(), 3U);
  const auto& point = device["points"][0];
  EXPECT_EQ(point["kind"], "sensor");
  EXPECT_EQ(point["id"], "temperature-1");
  EXPECT_EQ(point["value"], "20.5");
  EXPECT_EQ(point["status"]["quality"], "good");
  EXPECT_EQ(point["description"]["unit"], "Cel");
  const auto none = ask("GET", "/api/v1/devices/1/scripted-1/8");
  EXPECT_EQ(none.status, 404U);
  EXPECT_EQ(Json::parse(none.body)["error"]["text"], "no device 1/scripted-1/8");
}

TEST_F(Rest, TuplesOfAPatternComeInPages) {
  auto& owner = component(70000);
  for (int i = 1; i <= 25; ++i) ASSERT_TRUE(owner.set("t" + std::to_string(i), "x"));
  std::vector<std::string> keys;
  int pages = 0;
  for (Json next = "/api/v1/tuples?pattern=70000:*&limit=10"; next.is_string();) {
    const auto page = get(next);
    for (auto& key : keys_of(page["tuples"])) keys.push_back(key);
    next = page.contains("next") ? page["next"] : Json();
    ASSERT_LE(++pages, 3);
  }
  EXPECT_EQ(pages, 3);
  ASSERT_EQ(keys.size(), 25U);
  EXPECT_EQ(keys.front(), "t1");
  EXPECT_EQ(keys.back(), "t25");
}

TEST_F(Rest, AnOwnerThatDoesNotReplyIsNotAwaitedLongerThanAsked) {
  start_lamp();
  const std::string lamp = "/api/v1/tuples/1/proxy.scripted-1.7.actuator.switch-1.command";
  ASSERT_EQ(ask("PUT", lamp + "?wait=0s", "on").status, 202U);
  std::optional<Response> response;
  const auto start = scheduler.now();
  const auto exchange = site().handle(request_of("PUT", lamp + "?ttl=1h&wait=20s", "off"),
                                      [&](Response answer) { response = std::move(answer); });
  ecology.cut(OwnerId(1), OwnerId(kSite));  // what is under way is lost
  ecology.mend(OwnerId(1), OwnerId(kSite));
  while (!response && scheduler.now() - start < 2h) scheduler.run_for(100ms);
  ASSERT_TRUE(response);
  EXPECT_LE(scheduler.now() - start, 21s);
  EXPECT_EQ(response->status, 202U);
  EXPECT_EQ(Json::parse(response->body)["state"], "sent");
  EXPECT_EQ(Json::parse(response->body)["reason"], "the owner has not replied yet");
}

TEST_F(Rest, APageOfLargeTuplesEndsAfterAMebibyte) {
  auto& owner = component(70000);
  for (int i = 1; i <= 25; ++i) ASSERT_TRUE(owner.set("t" + std::to_string(i), std::string(100'000, 'x')));
  std::vector<std::string> keys;
  for (Json next = "/api/v1/tuples?pattern=70000:*"; next.is_string();) {
    const auto response = ask("GET", next);
    EXPECT_LT(response.body.size(), 1'300'000U);
    const auto page = Json::parse(response.body);
    for (auto& key : keys_of(page["tuples"])) keys.push_back(key);
    next = page.contains("next") ? page["next"] : Json();
  }
  ASSERT_EQ(keys.size(), 25U);
  EXPECT_EQ(keys.front(), "t1");
  EXPECT_EQ(keys.back(), "t25");
}

TEST_F(Rest, ListsAreCountedByTheTuplesThatTheyRead) {
  auto& owner = component(70000);
  for (int i = 0; i < 20'000; ++i) ASSERT_TRUE(owner.set("t" + std::to_string(i), "x"));
  const std::string list = "/api/v1/tuples?pattern=70000:*&limit=1", one = "/api/v1/tuples/70000/t1";
  EXPECT_EQ(ask("GET", list).status, 200U);
  scheduler.run_for(1s);
  std::vector<unsigned> lists, singles;
  const auto read = [&](const std::string& target, std::vector<unsigned>& answers) {
    const auto request = request_of("GET", target);
    requests.push_back(
        site().handle(request, [&answers](const Response& response) { answers.push_back(response.status); }));
  };
  for (int i = 0; i < 40; ++i) read(list, lists);
  for (int i = 0; i < 100; ++i) read(one, singles);
  scheduler.run_for(100ms);
  EXPECT_EQ(std::count(lists.begin(), lists.end(), 429U), 40 - 30) << "each costs one, and one for 20,000 tuples";
  EXPECT_EQ(std::count(singles.begin(), singles.end(), 200U), 100);
  EXPECT_EQ(ask("GET", list).status, 429U) << "what was read counts, too";
  scheduler.run_for(2s);
  EXPECT_EQ(ask("GET", list).status, 200U);
}

TEST_F(Rest, ATupleHasTheNamesOfTheCommandLine) {
  auto& owner = component(70000);
  ASSERT_TRUE(owner.set("a", "1", tuples::SetOptions{"text/plain", WallTime(1500ms), Duration(0), {}}));
  auto tuple = get("/api/v1/tuples/70000/a");
  EXPECT_GT(tuple["write"].get<double>(), 0);
  tuple.erase("write");
  EXPECT_EQ(tuple, Json({{"owner", 70000},
                         {"key", "a"},
                         {"value", "1"},
                         {"media", "text/plain"},
                         {"creator", 70000},
                         {"sequence", 1},
                         {"user", 1.5},
                         {"expire", 0},
                         {"present", true}}));
  const auto none = ask("GET", "/api/v1/tuples/70000/b");
  EXPECT_EQ(none.status, 404U);
  EXPECT_EQ(Json::parse(none.body)["error"], Json({{"code", "not-found"}, {"text", "no tuple 70000:b"}}));
}

TEST_F(Rest, ValuesAloneHaveTheirOwnTypeUnlessABrowserWouldRunThem) {
  auto& owner = component(70000);
  const auto put = [&](const char* key, const char* type, const char* value) {
    ASSERT_TRUE(owner.set(key, value, tuples::SetOptions{type, {}, Duration(0), {}}));
  };
  put("note", "text/plain", "<b>hello</b>");
  put("photo", "image/png", "\x89PNG");
  put("drawing", "image/svg+xml", "<svg/>");
  put("page", "text/html", "<script>alert(1)</script>");
  put("script", "text/javascript", "alert(1)");
  put("bad", "text/html\r\nX: y", "x");
  struct Case {
    std::string key, accept, query, type;
    bool is_saved;
  };
  const std::vector<Case> cases{{"note", "text/plain", "", "text/plain", false},
                                {"photo", "", "?raw", "image/png", false},
                                {"photo", "image/avif,image/*,*/*;q=0.8", "", "image/png", false},
                                {"drawing", "", "?raw&sequence=7", "image/svg+xml", true},
                                {"page", "text/html", "", "application/octet-stream", true},
                                {"script", "", "?raw", "application/octet-stream", true},
                                {"bad", "", "?raw", "application/octet-stream", true},
                                {"page", "text/plain", "", "text/plain", false},
                                {"page", "text/html, application/json", "", "application/json", false}};
  for (const auto& one : cases) {
    const auto response = ask("GET", "/api/v1/tuples/70000/" + one.key + one.query, "", {{"accept", one.accept}});
    EXPECT_EQ(response.content_type, one.type) << one.key;
    EXPECT_EQ(!response.headers.empty(), one.is_saved) << one.key;
  }
  EXPECT_EQ(ask("GET", "/api/v1/tuples/70000/photo?raw").body, "\x89PNG");
}

TEST_F(Rest, APutOfACommandWaitsForItsOutcome) {
  start_lamp();
  site();
  scheduler.run_for(1s);
  const std::string target = "/api/v1/tuples/1/proxy.scripted-1.7.actuator.switch-1.command";
  std::optional<Response> response;
  const auto exchange = site().handle(request_of("PUT", target, "on"), [&](Response r) { response = std::move(r); });
  scheduler.run_for(1s);
  EXPECT_FALSE(response) << "it is sent, and no report has come";
  devices_of(1).say("7", reading(actuator("switch"), true));
  scheduler.run_for(1s);
  ASSERT_TRUE(response);
  EXPECT_EQ(response->status, 200U);
  const auto outcome = Json::parse(response->body);
  EXPECT_EQ(outcome["state"], "confirmed");
  EXPECT_EQ(outcome["key"], "proxy.scripted-1.7.actuator.switch-1.command");
  EXPECT_FALSE(outcome.contains("error"));
}

TEST_F(Rest, EachOutcomeOfAPutHasItsStatus) {
  start_lamp();
  site();
  scheduler.run_for(1s);
  const std::string lamp = "/api/v1/tuples/1/proxy.scripted-1.7.actuator.switch-1.command";
  const auto sent = ask("PUT", lamp + "?wait=0s", "on");
  EXPECT_EQ(sent.status, 202U);
  EXPECT_EQ(sent.headers, (Fields{{"Location", "/api/v1/tuples/1/proxy.scripted-1.7.actuator.switch-1.status"}}));
  const auto timed_out = ask("PUT", lamp, "off");
  EXPECT_EQ(timed_out.status, 504U);
  EXPECT_EQ(Json::parse(timed_out.body)["state"], "timed-out");
  EXPECT_EQ(Json::parse(timed_out.body)["error"]["code"], "expired");
  const auto refused = ask("PUT", lamp, "purple");
  EXPECT_EQ(refused.status, 400U);
  EXPECT_THAT(Json::parse(refused.body)["error"]["text"].get<std::string>(), HasSubstr("purple"));
  EXPECT_EQ(ask("PUT", "/api/v1/tuples/9/a", "1").status, 404U);
  EXPECT_EQ(ask("PUT", "/api/v1/tuples/1/proxy.scripted-1.nobody.actuator.switch-1.command", "on").status, 404U);
  EXPECT_EQ(ask("PUT", lamp, "on", {}, Role::kView).status, 403U);
  EXPECT_EQ(ask("PUT", "/api/v1/tuples/1/proxy.inbox", "approve x.*", {}, Role::kCommand).status, 403U);
}

TEST_F(Rest, APutOfANumberOutOfRangeIs400) {
  start_island(1);
  auto dimmer = lamp();
  auto level = dimmer.capabilities.back();
  level.point = actuator("dimmer");
  dimmer.capabilities.push_back(level);
  devices_of(1).say("7", dimmer);
  site();
  scheduler.run_for(1s);
  const auto refused = ask("PUT", "/api/v1/tuples/1/proxy.scripted-1.7.actuator.dimmer-1.command", "101");
  EXPECT_EQ(refused.status, 400U) << refused.body;
  EXPECT_EQ(Json::parse(refused.body)["error"]["code"], "out-of-range");
}

TEST_F(Rest, APutOfACommandThatFailsIs502) {
  start_island(1, "}\nrecorders: {all: {file: all.rec, patterns: [\"proxy.**\"]}");
  devices_of(1).say("7", lamp());
  site();
  scheduler.run_for(1s);
  const std::string recorder = "/api/v1/tuples/1/proxy.recorder.all.command";
  EXPECT_EQ(ask("PUT", recorder, "stop").status, 200U);
  transports.room(0);
  const auto failed = ask("PUT", recorder, "start");
  EXPECT_EQ(failed.status, 502U) << failed.body;
  const auto outcome = Json::parse(failed.body);
  EXPECT_EQ(outcome["state"], "failed");
  EXPECT_EQ(outcome["error"]["code"], "unreachable");
  EXPECT_THAT(outcome["error"]["text"].get<std::string>(), HasSubstr("it is tried again"));
  std::optional<Response> left;
  const auto exchange =
      site().handle(request_of("PUT", "/api/v1/tuples/1/proxy.scripted-1.7.actuator.switch-1.command", "on"),
                    [&](Response response) { left = std::move(response); });
  scheduler.run_for(100ms);
  devices_of(1).say("7", model::Leave{});
  scheduler.run_for(5s);
  ASSERT_TRUE(left);
  EXPECT_EQ(left->status, 502U) << left->body;
}

TEST_F(Rest, ACommandOfTheIslandItselfAnswersWithItsOutcome) {
  Result<std::vector<std::string>> outcome;
  start_island(1).settings().on_reload([&outcome](bool) { return outcome; });
  site();
  scheduler.run_for(1s);
  const std::string settings = "/api/v1/tuples/1/proxy.settings.command";
  const auto good = ask("PUT", settings, "try");
  EXPECT_EQ(good.status, 200U);
  EXPECT_EQ(Json::parse(good.body)["state"], "confirmed");
  outcome = fail(ErrorCode::kInvalid, "home.yaml:3:7: no such key");
  const auto refused = ask("PUT", settings, "reload");
  EXPECT_EQ(refused.status, 409U);
  EXPECT_EQ(Json::parse(refused.body)["state"], "refused");
  EXPECT_THAT(Json::parse(refused.body)["reason"].get<std::string>(), HasSubstr("no such key"));
}

TEST_F(Rest, ACommandWhoseOwnerReportsNoStatesIsApplied) {
  auto& robot = component(70000);
  ASSERT_TRUE(robot.set("robot.arm.command", ""));
  const auto policy =
      robot.add_policy({OwnerId(70000), "**"}, [](const auto&) { return tuples::SetDecision::applied(); });
  const auto answer = ask("PUT", "/api/v1/tuples/70000/robot.arm.command", "home");
  EXPECT_EQ(answer.status, 200U);
  EXPECT_EQ(Json::parse(answer.body)["state"], "applied");
  EXPECT_LT(Json::parse(answer.body)["seconds"], 1);
}

TEST_F(Rest, APutSetsATupleWithTypeAndSequence) {
  auto& owner = component(70000);
  const auto policy = owner.add_policy(
      {std::nullopt, "**"}, [](const tuples::RemoteSet&) { return tuples::SetDecision::applied(); },
      tuples::PolicyScope::kSetsAndAppends);
  const std::string target = "/api/v1/tuples/70000/note";
  const auto first = ask("PUT", target + "?sequence=0&expire=1h", "{}", {{"content-type", "Application/JSON; x=y"}});
  EXPECT_EQ(first.status, 200U) << first.body;
  EXPECT_EQ(Json::parse(first.body)["state"], "applied");
  EXPECT_EQ(owner.get(OwnerId(70000), "note")->media_type, "application/json");
  EXPECT_NE(owner.get(OwnerId(70000), "note")->expire_time, WallTime{});
  EXPECT_EQ(ask("PUT", target + "?sequence=0", "{}").status, 409U);
  EXPECT_EQ(ask("PUT", target + "?do=append", "!", {{"content-type", "application/x-www-form-urlencoded"}}).status,
            200U);
  EXPECT_EQ(value(owner, 70000, "note"), "{}!");
}

TEST_F(Rest, AClientThatLeavesCancelsItsRequest) {
  start_lamp();
  site();
  scheduler.run_for(1s);
  int answers = 0;
  const auto count = [&](const Response&) { ++answers; };
  for (const auto& [method, target, body] : std::vector<std::tuple<std::string, std::string, std::string>>{
           {"GET", "/api/v1/devices", ""},
           {"GET", "/api/v1/tuples/9/none", ""},
           {"PUT", "/api/v1/tuples/1/proxy.scripted-1.7.actuator.switch-1.command", "on"},
           {"PUT", "/api/v1/tuples/1/proxy.scripted-1.7.actuator.switch-1.command", "purple"},
           {"POST", "/api/v1/inbox", R"({"approve":"x.*"})"},
           {"GET", "/metrics", ""}}) {
    auto exchange = site().handle(request_of(method, target, body), count);
    exchange.reset();
  }
  scheduler.run_for(60s);
  EXPECT_EQ(answers, 0);
}

TEST_F(Rest, WrongRequestsAreAnsweredWithWhatWasExpected) {
  start_lamp();
  struct Case {
    std::string method, target, body;
    unsigned status;
    std::string text;
  };
  const std::vector<Case> cases{
      {"GET", "/api/v1/nothing", "", 404, "no resource"},
      {"GET", "/api/v2", "", 404, "no resource"},
      {"DELETE", "/api/v1/devices", "", 405, "expected GET"},
      {"POST", "/api/v1/tuples/1/a", "", 405, "expected GET, PUT"},
      {"GET", "/api/v1/devices?lmit=3", "", 400, "unknown member 'lmit'; did you mean 'limit'?"},
      {"GET", "/api/v1/devices?limit=0", "", 400, "limit is '0'; expected a whole number from 1 to 1000"},
      {"GET", "/api/v1/devices?limit=1001", "", 400, "limit is '1001'"},
      {"GET", "/api/v1/devices?island=home", "", 400, "island is 'home'; expected a whole number"},
      {"GET", "/api/v1/devices/home/a/b", "", 400, "expected the number of a component"},
      {"GET", "/api/v1/devices/1/a/b%20c", "", 400, "b c"},
      {"GET", "/api/v1/tuples", "", 400, "pattern is missing; expected OWNER:KEY or *:KEY"},
      {"GET", "/api/v1/tuples?pattern=a..b", "", 400, "pattern: "},
      {"GET", "/api/v1/tuples/1/a..b", "", 400, "a..b"},
      {"GET", "/api/v1/tuples/1/a?raw=maybe", "", 400, "raw is 'maybe'; expected true or false"},
      {"PUT", "/api/v1/tuples/1/a?ttl=soon", "x", 400, "ttl is 'soon'; expected seconds from 0"},
      {"PUT", "/api/v1/tuples/1/a?wait=1d", "x", 400, "wait is '1d'"},
      {"PUT", "/api/v1/tuples/x/a", "x", 404, "nothing is called 'x:a'"},
      {"POST", "/api/v1/inbox", "approve", 400, "expected a JSON object, got 'approve'"},
      {"POST", "/api/v1/inbox", R"({"aprove":"x"})", 400, "unknown member 'aprove'; did you mean 'approve'?"},
      {"POST", "/api/v1/inbox", R"({"island":1})", 400, "approve is missing; expected NETWORK.DEVICE"},
      {"POST", "/api/v1/inbox", R"({"approve":["x",7]})", 400, "or a list of 1 to 1000 of them"},
      {"POST", "/api/v1/inbox", R"({"ignore":[]})", 400, "or a list of 1 to 1000 of them"},
      {"POST", "/api/v1/inbox", R"({"approve":""})", 400, "expected NETWORK.DEVICE"},
      {"GET", "/api/v1/things/7", "", 400, "thing '7': expected an id such as 6541:proxy.wsn-1.7"},
      {"GET", "/api/v1/things/1:proxy.a.b", "", 404, "no thing 1:proxy.a.b"},
      {"GET", "/api/v1/history?key=a", "", 404, "nothing is called 'a'"},
      {"GET", "/api/v1/history?from=-1h", "", 400, "key is missing; expected OWNER:KEY"},
      {"GET", "/api/v1/history?key=1:a&from=yesterday", "", 400, "from is 'yesterday'; expected seconds since 1970"},
      {"GET", "/api/v1/history?key=1:a&from=-1h&to=-2h", "", 400, "from: expected a time before `to`"},
      {"GET", "/api/v1/history?key=1:a", "", 404, "rubicon web --history FILE"},
      {"GET", "/api/v1/history/series", "", 404, "history: {file: home.history}"},
      {"GET", "/metrics?all", "", 400, "unknown member 'all'"},
  };
  for (const auto& one : cases) {
    const auto response = ask(one.method, one.target, one.body);
    EXPECT_EQ(response.status, one.status) << one.method << " " << one.target << " " << response.body;
    EXPECT_EQ(response.content_type, "application/json");
    const auto error = Json::parse(response.body)["error"];
    EXPECT_THAT(error["text"].get<std::string>(), HasSubstr(one.text)) << one.target;
  }
}

TEST_F(Rest, WithoutATokenOnlyTheSignOfLifeIsAnswered) {
  need_token();
  for (const auto* path : {"/api/v1", "/api/v1/devices", "/metrics", "/api/v1/openapi.json"})
    EXPECT_EQ(ask("GET", path, "", {}, Role::kNone).status, 401U) << path;
  EXPECT_EQ(ask("GET", "/healthz", "", {}, Role::kNone).status, 200U);
}

TEST_F(Rest, MoreThan50CommandsInASecondAreBusy) {
  component(70000);
  std::vector<unsigned> statuses;
  std::vector<std::unique_ptr<Exchange>> exchanges;
  site();
  scheduler.run_for(1s);
  for (int i = 0; i < 60; ++i)
    exchanges.push_back(site().handle(request_of("PUT", "/api/v1/tuples/70000/a", "x"),
                                      [&](const Response& response) { statuses.push_back(response.status); }));
  EXPECT_THAT(statuses, testing::AllOf(testing::SizeIs(10), testing::Each(429U)));
}

TEST_F(Rest, MetricsTellLinesDevicesCountersAndTheServerItself) {
  options.metrics_patterns = {Pattern{std::nullopt, "proxy.*.*.sensor.temperature-1.value"}};
  start_lamp();
  measure(20.5);
  scheduler.run_for(2s);
  const auto response = ask("GET", "/metrics");
  EXPECT_EQ(response.content_type, "text/plain; version=0.0.4");
  for (const auto* line :
       {"# TYPE rubicon_network_line_up gauge\nrubicon_network_line_up{island=\"1\",network=\"scripted-1\"} 1\n",
        "rubicon_devices{island=\"1\",network=\"scripted-1\",status=\"reachable\"} 1\n",
        "# TYPE rubicon_dropped_readings_total counter\n",
        "rubicon_dropped_readings_total{island=\"1\",network=\"scripted-1\"} 0\n",
        "# TYPE rubicon_tuples_cached gauge\n", "rubicon_gateway_delivered_total{island=\"1\"} ",
        "rubicon_web_requests_total 1\n",
        "rubicon_value{island=\"1\",network=\"scripted-1\",device=\"7\",kind=\"sensor\",point=\"temperature-1\"} "
        "20.5\n"})
    EXPECT_THAT(response.body, HasSubstr(line));
  EXPECT_THAT(response.body, testing::Not(HasSubstr("light")));
}

TEST_F(Rest, AStreamTellsEachChangeAsAnEvent) {
  start_lamp();
  measure(20.5);
  site();
  scheduler.run_for(1s);
  const auto response = ask("GET", "/api/v1/tuples?pattern=1:proxy.*.*.sensor.temperature-1.value", "",
                            {{"accept", "text/event-stream"}});
  EXPECT_EQ(response.content_type, "text/event-stream");
  ASSERT_TRUE(response.stream);
  const auto stream = response.stream({[] {}, [](std::string_view) {}});
  std::string text;
  const auto run = [&](Duration time) {
    text.clear();
    for (Duration passed{0}; passed < time; passed += 50ms) {
      scheduler.run_for(50ms);
      while (const auto frame = stream->next()) text += *frame;
    }
  };
  run(100ms);
  EXPECT_THAT(text, testing::StartsWith("event: set\nid: 1\ndata: {\"owner\":1,\"key\":"));
  EXPECT_THAT(text, HasSubstr("\"value\":\"20.5\",\"media\":\"text/plain\""));
  EXPECT_THAT(text, testing::EndsWith("event: snapshot\nid: 2\ndata: {\"owner\":1}\n\n"));
  measure(21);
  run(1s);
  EXPECT_THAT(text, HasSubstr("event: set\nid: 3\n"));
  run(6s);
  EXPECT_EQ(text, ":\n\n");
  ecology.cut(OwnerId(1), OwnerId(kSite));
  run(1s);
  EXPECT_EQ(text, "event: absent\nid: 4\ndata: {\"owner\":1}\n\n");
}

}  // namespace
}  // namespace rubicon::web::api
