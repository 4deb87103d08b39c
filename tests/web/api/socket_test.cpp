#include "web/api/socket.h"
#include "client/message_client.h"
#include "web/api/site.h"

namespace rubicon::web::api {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using Sockets = Sites;

std::string error_text(const Json& answer) {
  return answer.value("ok", true) ? "(no error) " + answer.dump() : answer["error"]["text"].get<std::string>();
}

TEST_F(Sockets, ACommandIsAnsweredAndItsStatesFollow) {
  start_lamp();
  auto& page = Sites::page();
  const auto id = page.ask({{"do", "set"}, {"key", kSwitch}, {"value", "on"}, {"ttl", 5}});
  scheduler.run_for(100ms);
  ASSERT_GE(page.frames.size(), 2U);
  const auto ok = page.frames[0];
  EXPECT_EQ(ok["id"], id);
  EXPECT_EQ(ok["ok"], true);
  EXPECT_EQ(ok["verdict"], "applied");
  EXPECT_EQ(page.frames.back()["state"], "sent");
  EXPECT_EQ(page.frames.back()["request"], ok["request"]);
  EXPECT_GT(page.frames.back()["until"].get<double>(), 0);
  EXPECT_FALSE(page.frames.back().contains("final"));
  devices_of(1).say("7", reading(actuator("switch"), true));
  scheduler.run_for(100ms);
  EXPECT_EQ(page.frames.back(),
            Json({{"id", id}, {"state", "confirmed"}, {"reason", ""}, {"request", ok["request"]}, {"final", true}}));
}

TEST_F(Sockets, ACommandWithoutAReportEndsAsTimedOut) {
  start_lamp();
  auto& page = Sites::page();
  page.ask({{"do", "set"}, {"key", kSwitch}, {"value", "on"}});
  scheduler.run_for(60s);
  std::vector<Json> ends;
  for (const auto& frame : page.frames) {
    if (frame.contains("final")) ends.push_back(frame);
  }
  ASSERT_EQ(ends.size(), 1U);
  EXPECT_EQ(ends[0]["state"], "timed-out");
  EXPECT_NE(ends[0]["reason"], "");
}

TEST_F(Sockets, ACommandOfTheIslandItselfHasItsOutcomeAsFinalState) {
  start_island(1).settings().on_reload(
      [](bool) { return Result<std::vector<std::string>>(fail(ErrorCode::kInvalid, "home.yaml:3:7: no such key")); });
  auto& page = Sites::page();
  scheduler.run_for(1s);
  page.ask({{"do", "set"}, {"key", "1:proxy.settings.command"}, {"value", "reload"}});
  scheduler.run_for(1s);
  EXPECT_EQ(page.frames.back()["state"], "refused");
  EXPECT_EQ(page.frames.back()["final"], true);
}

TEST_F(Sockets, ARefusedSetSaysWhy) {
  start_lamp();
  auto& page = Sites::page();
  const auto bad = page.ask({{"do", "set"}, {"key", kSwitch}, {"value", "purple"}});
  const auto none = page.ask({{"do", "set"}, {"key", "9:a"}, {"value", "1"}});
  const auto read_only = page.ask({{"do", "set"}, {"key", "1:proxy.island"}, {"value", "1"}});
  scheduler.run_for(10s);
  EXPECT_THAT(error_text(page.answer(bad)), HasSubstr("purple"));
  EXPECT_EQ(page.answer(bad)["verdict"], "refused");
  EXPECT_EQ(page.answer(none)["error"], Json({{"code", "not-found"}, {"text", "no component 9 is present"}}));
  EXPECT_EQ(page.answer(none)["verdict"], "no-such-owner");
  EXPECT_EQ(page.answer(read_only)["error"]["code"], "refused");
}

TEST_F(Sockets, ASetCarriesTypeTimesAndSequence) {
  auto& owner = component(70000);
  const auto policy =
      owner.add_policy({std::nullopt, "**"}, [](const tuples::RemoteSet&) { return tuples::SetDecision::applied(); });
  auto& page = Sites::page();
  const auto expire = base::to_seconds(scheduler.wall_now()) + 100;
  const auto first = page.ask({{"do", "set"},
                               {"key", "70000:note"},
                               {"b64", "/w=="},
                               {"media", "application/octet-stream"},
                               {"user", 1000.5},
                               {"expire", expire},
                               {"sequence", 0}});
  scheduler.run_for(100ms);
  EXPECT_EQ(page.answer(first)["verdict"], "applied");
  EXPECT_EQ(page.answer(first)["sequence"], 1);
  const auto there = owner.get(OwnerId(70000), "note");
  ASSERT_TRUE(there);
  EXPECT_EQ(there->value, "\xff");
  EXPECT_EQ(there->media_type, "application/octet-stream");
  EXPECT_EQ(there->user_time, WallTime(1000500ms));
  EXPECT_NEAR(base::to_seconds(there->expire_time), expire, 0.1);
  const auto again = page.ask({{"do", "set"}, {"key", "70000:note"}, {"value", "x"}, {"sequence", 0}});
  scheduler.run_for(100ms);
  EXPECT_EQ(page.answer(again)["error"]["code"], "refused");
}

TEST_F(Sockets, AnAppendAddsToAValue) {
  auto& owner = component(70000);
  ASSERT_TRUE(owner.set("log", "a"));
  const auto policy = owner.add_policy(
      {std::nullopt, "log"}, [](const tuples::RemoteSet&) { return tuples::SetDecision::applied(); },
      tuples::PolicyScope::kSetsAndAppends);
  auto& page = Sites::page();
  const auto id = page.ask({{"do", "append"}, {"key", "70000:log"}, {"value", "b"}});
  scheduler.run_for(100ms);
  EXPECT_EQ(page.answer(id)["ok"], true) << page.answer(id);
  EXPECT_EQ(value(owner, 70000, "log"), "ab");
}

TEST_F(Sockets, AGetTellsTheWholeTuple) {
  auto& owner = component(70000);
  ASSERT_TRUE(owner.set("a", "1", {.user_time = WallTime(1500ms)}));
  ASSERT_TRUE(owner.set("bytes", "\xff", {.media_type = "image/png"}));
  auto& page = Sites::page();
  const auto text = page.ask({{"do", "get"}, {"key", "70000:a"}});
  const auto bytes = page.ask({{"do", "get"}, {"key", "70000:bytes"}});
  const auto none = page.ask({{"do", "get"}, {"key", "70000:none"}});
  scheduler.run_for(3s);
  auto tuple = page.answer(text)["tuple"];
  EXPECT_NEAR(tuple["write"].get<double>(), base::to_seconds(scheduler.wall_now()), 4);
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
  EXPECT_EQ(page.answer(bytes)["tuple"]["b64"], "/w==");
  EXPECT_EQ(page.answer(none)["error"], Json({{"code", "not-found"}, {"text", "no tuple 70000:none"}}));
}

TEST_F(Sockets, MessagesGoBothWays) {
  auto& other = component(70000);
  client::MessageClient office(scheduler, other, log);
  std::vector<std::string> received;
  const auto listening =
      office.on_message("note", [&](const client::UserMessage& message) { received.push_back(message.bytes); });
  auto& page = Sites::page();
  const auto sent = page.ask({{"do", "send"}, {"to", 70000}, {"type", "note"}, {"value", "hello"}});
  const auto unknown = page.ask({{"do", "send"}, {"to", 70000}, {"type", "other"}, {"value", "hello"}});
  page.ask({{"do", "listen"}, {"type", "news"}});
  scheduler.run_for(2s);
  EXPECT_EQ(page.answer(sent)["ok"], true);
  EXPECT_EQ(page.answer(unknown)["ok"], false);
  EXPECT_THAT(received, ElementsAre("hello"));
  page.take_frames();
  office.send(OwnerId(kSite), "news", "42", {});
  office.send(OwnerId(kSite), "news", "\xff", {});
  scheduler.run_for(1s);
  ASSERT_EQ(page.frames.size(), 2U);
  EXPECT_EQ(page.frames[0]["message"],
            Json({{"from", 70000}, {"network", ""}, {"device", ""}, {"type", "news"}, {"value", "42"}}));
  EXPECT_EQ(page.frames[1]["message"]["b64"], "/w==");
  page.take_frames();
  page.ask({{"do", "unlisten"}, {"type", "news"}});
  office.send(OwnerId(kSite), "news", "43", {});
  scheduler.run_for(1s);
  EXPECT_EQ(page.frames.size(), 1U);
}

TEST_F(Sockets, IslandsAndComponentsArePushedAtOnceAndAtEachChange) {
  start_island(1);
  auto& page = Sites::page();
  page.ask({{"do", "islands"}});
  page.ask({{"do", "components"}});
  scheduler.run_for(1s);
  page.take_frames();
  ASSERT_TRUE(component(70000).describe(R"({"name":"robot","host":"lab","program":"walker 2.1","since":5})"));
  scheduler.run_for(1s);
  const auto& seen = page.frames.back()["components"];
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_EQ(seen[1], Json({{"id", 70000},
                           {"name", "robot"},
                           {"host", "lab"},
                           {"program", "walker"},
                           {"version", "2.1"},
                           {"since", 5.0}}));
  start_island(2);
  scheduler.run_for(1s);
  std::vector<Json> lists;
  for (const auto& frame : page.frames) {
    if (frame.contains("islands")) lists.push_back(frame["islands"]);
  }
  ASSERT_FALSE(lists.empty());
  ASSERT_EQ(lists.back().size(), 2U);
  EXPECT_EQ(lists.back()[1]["id"], 2);
  EXPECT_EQ(lists.back()[1]["prefix"], "proxy");
}

TEST_F(Sockets, SilenceIsBrokenByASignOfLife) {
  auto& page = Sites::page();
  scheduler.run_for(4900ms);
  EXPECT_THAT(page.frames, IsEmpty());
  scheduler.run_for(200ms);
  ASSERT_EQ(page.frames.size(), 1U);
  EXPECT_NEAR(page.frames[0]["alive"].get<double>(), base::to_seconds(scheduler.wall_now()), 1);
  scheduler.run_for(60s);
  EXPECT_EQ(page.frames.size(), 13U);
}

TEST_F(Sockets, WrongRequestsAreAnsweredWithWhatWasExpected) {
  auto& page = Sites::page();
  const std::vector<std::pair<std::string, std::string>> cases{
      {R"(hello)", "expected a JSON object, got 'hello'"},
      {R"([1])", "expected a JSON object"},
      {R"({"do":"get"})", "id: expected a whole number above 0"},
      {R"({"id":-1,"do":"get"})", "id is '-1'; expected a whole number"},
      {R"({"id":1})", "do is missing; expected a verb, such as subscribe"},
      {R"({"id":2,"do":"subscibe"})", "do: unknown verb 'subscibe'; did you mean 'subscribe'"},
      {R"({"id":3,"do":"set","key":"1:a","value":1})", "value is '1'; expected"},
      {R"({"id":4,"do":"set","key":"1:a","b64":"?"})", "b64: base 64: 1 characters"},
      {R"({"id":5,"do":"send","to":0,"type":"a","value":""})", "to: expected the id of a component"},
      {R"({"id":6,"do":"unlisten","type":"x"})", "does not listen for 'x'"},
      {R"({"id":6,"do":"islands"})", "id: expected a whole number above 6, the last one"},
      {R"({"id":7,"do":"islands","of":[[[[[[[[[1]]]]]]]]]})", "JSON: nested deeper than 8 levels"},
  };
  for (const auto& [frame, text] : cases) {
    page.say(frame);
    ASSERT_EQ(page.frames.size(), 1U) << frame;
    EXPECT_THAT(error_text(page.frames[0]), HasSubstr(text)) << frame;
    EXPECT_EQ(page.frames[0]["error"]["code"] == "invalid" || page.frames[0]["error"]["code"] == "not-found" ||
                  page.frames[0]["error"]["code"] == "out-of-range",
              true)
        << frame;
    page.take_frames();
  }
  EXPECT_EQ(page.closed, "");
}

TEST_F(Sockets, ARoleThatMayOnlyViewSetsAndSendsNothing) {
  start_lamp();
  auto& page = Sites::page(Role::kView);
  const auto set = page.ask({{"do", "set"}, {"key", kSwitch}, {"value", "on"}});
  const auto append = page.ask({{"do", "append"}, {"key", kSwitch}, {"value", "on"}});
  const auto send = page.ask({{"do", "send"}, {"to", 1}, {"type", "knx"}, {"value", "on"}});
  for (const auto id : {set, append, send}) EXPECT_EQ(page.answer(id)["error"]["code"], "refused");
  EXPECT_EQ(error_text(page.answer(send)), "'local' has the role view, which may not send messages of type knx");
  const std::string target = "/api/v1/tuples/1/proxy.scripted-1.7.actuator.switch-1.command";
  EXPECT_EQ(ask("PUT", target, "on", {}, Role::kView).status, 403U);
  EXPECT_EQ(ask("PUT", target + "?do=append", "on", {}, Role::kView).status, 403U);
  EXPECT_EQ(ask("POST", "/api/v1/inbox", R"({"ignore":"scripted-1.*"})", {}, Role::kView).status, 403U);
  scheduler.run_for(1s);
  EXPECT_THAT(devices_of(1).commands, IsEmpty());
}

TEST_F(Sockets, KeysThatSteerTheIslandNeedAnAdministrator) {
  start_lamp();
  auto& page = Sites::page(Role::kCommand);
  const auto id = page.ask({{"do", "set"}, {"key", "1:proxy.inbox"}, {"value", "approve x.*"}});
  EXPECT_EQ(page.answer(id)["error"]["code"], "refused");
}

TEST_F(Sockets, MessagesThatChangeAnInstallationNeedAnAdministrator) {
  start_lamp();
  const Json request{{"do", "send"}, {"to", 1}, {"network", "scripted-1"}, {"type", "zigbee.admin"}, {"value", "{}"}};
  auto& operator_page = Sites::page(Role::kCommand);
  const auto refused = operator_page.ask(request);
  EXPECT_EQ(error_text(operator_page.answer(refused)),
            "'local' has the role command, which may not send messages of type zigbee.admin");
  auto& page = Sites::page(Role::kAdmin);
  page.ask(request);
  scheduler.run_for(1s);
  ASSERT_EQ(devices_of(1).sent.size(), 1U);
  EXPECT_EQ(std::get<model::Opaque>(devices_of(1).sent[0].body).type, "zigbee.admin");
}

TEST_F(Sockets, WithoutATokenNothingIsAnsweredAndTheTimeIsLimited) {
  need_token();
  auto& page = Sites::page(Role::kNone);
  const auto id = page.ask({{"do", "islands"}});
  EXPECT_THAT(error_text(page.answer(id)), HasSubstr("the first frame must be"));
  EXPECT_EQ(page.closed, "");
  scheduler.run_for(11s);
  EXPECT_EQ(page.closed, "no hello with a token within 10 s");
}

TEST_F(Sockets, AHelloWithTheTokenGivesTheRole) {
  need_token();
  auto& page = Sites::page(Role::kNone);
  const auto id = page.ask({{"do", "hello"}, {"token", "secret"}});
  EXPECT_EQ(page.answer(id)["caller"], Json({{"name", "robot"}, {"role", "command"}}));
  page.ask({{"do", "islands"}});
  scheduler.run_for(20s);
  EXPECT_EQ(page.closed, "");
  EXPECT_EQ(page.frames.at(1)["ok"], true);
}

TEST_F(Sockets, AWrongTokenEndsTheConversation) {
  need_token();
  auto& page = Sites::page(Role::kNone);
  const auto id = page.ask({{"do", "hello"}, {"token", "guess"}});
  EXPECT_EQ(page.answer(id)["error"]["code"], "refused");
  EXPECT_EQ(page.closed, "the token was not accepted");
}

TEST_F(Sockets, MoreThan50CommandsInASecondAreBusy) {
  start_lamp();
  auto& page = Sites::page();
  for (int i = 0; i < 60; ++i) page.ask({{"do", "set"}, {"key", "1:proxy.island"}, {"value", "x"}});
  scheduler.run_ready();
  const auto busy = [&] {
    return std::count_if(page.frames.begin(), page.frames.end(),
                         [](const Json& frame) { return frame["error"]["code"] == "busy"; });
  };
  EXPECT_EQ(busy(), 10);
  page.take_frames();
  scheduler.run_for(1s);
  page.take_frames();
  page.ask({{"do", "set"}, {"key", "1:proxy.island"}, {"value", "x"}});
  scheduler.run_ready();
  EXPECT_EQ(busy(), 0);
}

TEST_F(Sockets, AClientThatAsksAndNeverReadsIsClosed) {
  auto& owner = component(70000);
  ASSERT_TRUE(owner.set("a", std::string(100'000, 'x')));
  auto& page = Sites::page();
  page.read(false);
  for (int i = 0; i < 20; ++i) page.ask({{"do", "get"}, {"key", "70000:a"}});
  scheduler.run_for(2s);
  EXPECT_THAT(page.closed, HasSubstr("does not read"));
}

TEST_F(Sockets, TheEndOfAConnectionLeavesNothingBehind) {
  start_lamp();
  auto& page = Sites::page();
  page.ask({{"do", "set"}, {"key", kSwitch}, {"value", "on"}});
  page.ask({{"do", "get"}, {"key", kTemperature}});
  page.ask({{"do", "get"}, {"key", "9:none"}});
  page.ask({{"do", "send"}, {"to", 1}, {"type", "x"}, {"value", "y"}});
  page.ask({{"do", "listen"}, {"type", "x"}});
  close(page);
  scheduler.run_for(30s);
  EXPECT_EQ(devices_of(1).commands.size(), 1U) << "what was accepted is executed";
}

TEST_F(Sockets, AValueOfTheLargestSizeIsAnswered) {
  auto& owner = component(70000);
  ASSERT_TRUE(owner.set("big", std::string(1'000'000, '\xff')));
  auto& page = Sites::page();
  scheduler.run_for(1s);
  const auto id = page.ask({{"do", "get"}, {"key", "70000:big"}});
  scheduler.run_for(1s);
  EXPECT_EQ(page.closed, "");
  EXPECT_EQ(page.answer(id)["tuple"]["b64"].get<std::string>().size(), 1'333'336U);
}

}  // namespace
}  // namespace rubicon::web::api
