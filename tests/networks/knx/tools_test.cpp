#include <nlohmann/json.hpp>

#include "networks/knx/bench.h"
#include "networks/knx/capture.h"
#include "networks/knx/tool_requests.h"

namespace rubicon::networks::knx {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::string_view kShown = R"({"host": "10.0.0.9", "telegrams-per-second": 0, "expose": {
  "6/0/1": {"tuple": "proxy.wsn-1.7.sensor.temperature-1.value", "dpt": "9.001", "every": "10min"},
  "6/0/2": {"tuple": "6543:proxy.dummy.x.sensor.switch-1.value", "dpt": "1.001"},
  "6/0/3": {"tuple": "proxy.wsn-1.7.sensor.light-1.value", "dpt": "9.004", "on-change": "no"}}})";

class KnxExposed : public KnxBench {
 protected:
  void set_tuple(const std::string& tuple, std::string_view value) {
    ASSERT_TRUE(host.followed.contains(tuple));
    host.followed[tuple](value);
    host.time.run_for(1s);
  }
  /// The entry of this kind in the list of problems; null if there is none.
  json problem(std::string_view what, std::string_view address = {}) const {
    for (const auto& one : json::parse(last_state().texts.at("problems")))
      if (one["what"] == what && (address.empty() || one["address"] == address)) return one;
    return {};
  }
  static constexpr const char* kWarm = "proxy.wsn-1.7.sensor.temperature-1.value";
  static constexpr const char* kLight = "proxy.wsn-1.7.sensor.light-1.value";
  const Bytes write_21_5{0x00, 0x80, 0x0c, 0x33};
};

TEST_F(KnxExposed, ChangesAreWrittenAndRepeatedInTheirPeriod) {
  start(kShown);
  EXPECT_THAT(host.followed, SizeIs(6)) << "each with its status";
  set_tuple(kWarm, "21.5");
  EXPECT_EQ(telegrams("6/0/1", write_21_5), 1);
  set_tuple(kWarm, "21.5");
  EXPECT_EQ(telegrams("6/0/1", write_21_5), 1) << "the same value is no change";
  host.time.run_for(30min);
  EXPECT_EQ(telegrams("6/0/1", write_21_5), 4);
  EXPECT_EQ(last_state().counters.at("telegrams-sent"), 4U) << "no other event caused a write";
  set_tuple("6543:proxy.dummy.x.sensor.switch-1.value", "on");
  host.time.run_for(1h);
  EXPECT_EQ(telegrams("6/0/2", {0x00, 0x81}), 1) << "no period";
}

TEST_F(KnxExposed, FastChangesAreThinnedOutAndTheLastOneIsWritten) {
  start(kShown);
  for (int i = 0; i < 50; ++i) {
    ASSERT_TRUE(host.followed.contains(kWarm));
    host.followed[kWarm](std::to_string(i));
    host.time.run_for(200ms);
  }
  const auto while_changing = server.heard().size();
  EXPECT_GE(while_changing, 2U);
  EXPECT_LE(while_changing, 3U) << "10 s of changes, one each 5 s";
  set_tuple(kWarm, "21.5");
  host.time.run_for(10s);
  EXPECT_EQ(server.heard().back().tpdu, write_21_5);
}

TEST_F(KnxExposed, ABusThatIsSlowerThanTheChangesGetsTheNewestValue) {
  server.confirm_time = 1s;
  start(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "expose": {
    "6/0/1": {"tuple": "proxy.wsn-1.7.sensor.temperature-1.value", "dpt": "9.001", "pause": "0s"}}})");
  for (int i = 0; i < 100; ++i) {
    host.followed[kWarm](std::to_string(i));
    host.time.run_for(100ms);
  }
  EXPECT_LE(last_state().counters.at("telegrams-waiting"), 1U);
  set_tuple(kWarm, "21.5");
  host.time.run_for(2s);
  EXPECT_EQ(server.heard().back().tpdu, write_21_5);
  EXPECT_LE(server.heard().size(), 13U) << "about one each second";
}

TEST_F(KnxExposed, AChangeIsWrittenOnceWhenItsPeriodIsNoLongerThanThePause) {
  start(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "expose": {
    "6/0/1": {"tuple": "proxy.wsn-1.7.sensor.temperature-1.value", "dpt": "9.001", "pause": "5s", "every": "3s"}}})");
  set_tuple(kWarm, "20");
  set_tuple(kWarm, "21.5");
  const auto when = [this](std::size_t place) { return server.heard().at(place).when - server.heard().at(0).when; };
  host.time.run_for(10s);
  ASSERT_GE(server.heard().size(), 4U);
  for (std::size_t i = 1; i < server.heard().size(); ++i) EXPECT_EQ((when(i) - when(i - 1)) / 1s, 3) << i;
}

TEST_F(KnxExposed, EveryWriteRestartsThePause) {
  start(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "expose": {
    "6/0/1": {"tuple": "proxy.wsn-1.7.sensor.temperature-1.value", "dpt": "9.001", "pause": "5s", "every": "20s"}}})");
  set_tuple(kWarm, "20");
  host.time.run_for(20s);
  ASSERT_THAT(server.heard(), SizeIs(2)) << "the repetition";
  set_tuple(kWarm, "21.5");
  EXPECT_THAT(server.heard(), SizeIs(2)) << "at most one in the pause";
  host.time.run_for(5s);
  EXPECT_THAT(server.heard(), SizeIs(3));
}

TEST_F(KnxExposed, TheBusCanReadThem) {
  start(kShown);
  server.inject_read(0x1105, group("6/0/3"));
  host.time.run_for(1s);
  EXPECT_THAT(server.heard(), IsEmpty()) << "nothing is known yet";
  set_tuple(kLight, "100");
  EXPECT_THAT(server.heard(), IsEmpty()) << "on-change: no";
  server.inject_read(0x1105, group("6/0/3"));
  host.time.run_for(1s);
  EXPECT_EQ(telegrams("6/0/3", {0x00, 0x40, 0x1c, 0xe2}), 1);
}

TEST_F(KnxExposed, TheyAreWrittenAgainWhenTheLineIsBack) {
  server.stop();
  start(kShown);
  set_tuple(kWarm, "20");
  set_tuple(kWarm, "21.5");
  server.start();
  for (int i = 0; i < 20; ++i) {
    if (!host.failures.empty()) static_cast<void>(network->open());
    host.time.run_for(1s);
  }
  EXPECT_EQ(telegrams("6/0/1", write_21_5), 1);
  EXPECT_THAT(server.heard(), SizeIs(1)) << "the older value is obsolete";
}

TEST_F(KnxExposed, AValueThatIsGoneOrBadIsNotShownAnyMore) {
  start(kShown);
  const std::string status = "proxy.wsn-1.7.sensor.temperature-1.status";
  set_tuple(kWarm, "21.5");
  set_tuple(status, R"({"quality":"device-offline","reason":"silent"})");
  server.inject_read(0x1105, group("6/0/1"));
  host.time.run_for(30min);
  EXPECT_THAT(server.heard(), SizeIs(1)) << "neither answered nor repeated";
  set_tuple(status, R"({"quality":"good"})");
  host.time.run_for(10s);
  EXPECT_EQ(telegrams("6/0/1", write_21_5), 2);
  set_tuple(kWarm, "");
  server.inject_read(0x1105, group("6/0/1"));
  host.time.run_for(30min);
  EXPECT_EQ(telegrams("6/0/1", write_21_5), 2);
}

TEST_F(KnxExposed, WhatTheBusDidNotTakeIsTriedAgain) {
  start(kShown);
  server.confirms_negatively = true;
  set_tuple(kWarm, "21.5");
  const auto first = server.heard().size();
  server.confirms_negatively = false;
  host.time.run_for(15s);
  EXPECT_EQ(server.heard().size(), first + 1);
  host.time.run_for(5min);
  EXPECT_EQ(server.heard().size(), first + 1);
}

TEST_F(KnxExposed, HundredsAreAllWrittenAfterAReconnect) {
  std::string text = R"({"host": "10.0.0.9", "expose": {)";
  for (int i = 1; i <= 250; ++i)
    text += (i > 1 ? ", " : "") + std::string("\"6/1/") + std::to_string(i) + R"(": {"tuple": "a.b)" +
            std::to_string(i) + R"(", "dpt": "1.001"})";
  start(text + "}}");
  for (int i = 1; i <= 250; ++i) host.followed["a.b" + std::to_string(i)]("on");
  host.time.run_for(20s);
  ASSERT_THAT(server.heard(), SizeIs(250));
  server.disconnect_all();
  host.time.run_for(1s);
  ASSERT_TRUE(network->open());
  host.time.run_for(20s);
  EXPECT_THAT(server.heard(), SizeIs(500));
}

TEST_F(KnxExposed, ValuesThatCannotBeEncodedAreReportedAndNotWritten) {
  start(kShown);
  set_tuple(kWarm, "very warm");
  set_tuple(kWarm, "");
  EXPECT_THAT(server.heard(), IsEmpty());
  EXPECT_TRUE(host.words.contains("6/0/1"));
}

TEST_F(KnxExposed, EveryRefusedValueIsCountedAndListedWithItsReason) {
  start(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "expose": {
    "6/0/4": {"tuple": "house.percent", "dpt": "5.001"}}})");
  set_tuple("house.percent", "250");
  set_tuple("house.percent", "251");
  EXPECT_EQ(last_state().counters.at("refused-exposures"), 2U);
  const auto entry = problem("exposure");
  EXPECT_EQ(entry["address"], "6/0/4");
  EXPECT_EQ(entry["count"], 2);
  EXPECT_THAT(entry["reason"].get<std::string>(), testing::AllOf(HasSubstr("house.percent"), HasSubstr("100")));
  host.time.run_for(2min);
  EXPECT_TRUE(problem("source").is_null()) << "it has a source";
}

TEST_F(KnxExposed, WhatHasNoSourceIsNamedAfterAMinuteAndUntilItHasOne) {
  start(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "expose": {
    "6/0/1": {"tuple": "proxy.wsn-1.7.sensor.temperature-1.value", "dpt": "9.001"},
    "6/0/2": {"tuple": "nothing.there", "dpt": "5.001", "every": "5s"},
    "6/0/3": {"tuple": "proxy.wsn-1.7.sensor.button-1.value", "dpt": "1.001"}}})");
  host.followed["proxy.wsn-1.7.sensor.button-1.status"](R"({"quality":"good"})");
  host.time.run_for(50s);
  EXPECT_EQ(last_state().counters.at("exposed-without-value"), 0U);
  host.followed["proxy.wsn-1.7.sensor.temperature-1.status"](R"({"quality":"bad","reason":"too warm"})");
  host.time.run_for(20s);
  EXPECT_EQ(last_state().counters.at("exposed-without-value"), 2U) << "a button is an event";
  EXPECT_EQ(problem("source", "6/0/2")["reason"], "nothing.there: no component has published this tuple");
  EXPECT_EQ(problem("source", "6/0/1")["reason"],
            "proxy.wsn-1.7.sensor.temperature-1.value: its value is bad: too warm");
  EXPECT_TRUE(host.words.contains("6/0/2: nothing.there: no component has published this tuple"));
  set_tuple("nothing.there", "12");
  EXPECT_EQ(last_state().counters.at("exposed-without-value"), 1U);
  EXPECT_TRUE(problem("source", "6/0/2").is_null());
  set_tuple("nothing.there", "");
  host.time.run_for(2min);
  EXPECT_EQ(problem("source", "6/0/2")["reason"], "nothing.there: the tuple is gone");
  ASSERT_TRUE(change(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "expose": {
    "6/0/2": {"tuple": "something.there", "dpt": "5.001"}}})"));
  set_tuple("something.there", "12");
  EXPECT_TRUE(problem("source", "6/0/2").is_null()) << "it has another source";
  ASSERT_TRUE(change(R"({"host": "10.0.0.9", "telegrams-per-second": 0})"));
  host.time.run_for(2s);
  EXPECT_EQ(last_state().texts.at("problems"), "[]") << "it is exposed no more";
}

TEST_F(KnxExposed, AValueThatIsBadForAMinuteIsNamedToo) {
  start(kShown);
  set_tuple(kWarm, "21.5");
  host.time.run_for(2min);
  EXPECT_TRUE(problem("source", "6/0/1").is_null());
  host.followed["proxy.wsn-1.7.sensor.temperature-1.status"](R"({"quality":"stale","reason":"silent"})");
  host.time.run_for(2min);
  EXPECT_EQ(problem("source", "6/0/1")["reason"], std::string(kWarm) + ": its value is stale: silent");
}

/// A tool's view: requests in, JSON out.
class KnxTools : public KnxBench {
 protected:
  std::vector<json> ask(const json& request, std::optional<model::Sender> sender = {}) {
    host.delivered.clear();
    const auto text = request.dump();
    const auto bytes = base::as_bytes(text);
    EXPECT_TRUE(
        send(model::Opaque{std::string(kRequestTag), Bytes(bytes.begin(), bytes.end())}, "", std::move(sender)));
    host.time.run_for(10s);
    return messages(kReplyTag);
  }
  std::vector<json> messages(std::string_view tag) const {
    std::vector<json> all;
    for (const auto& message : host.delivered) {
      const auto* opaque = std::get_if<model::Opaque>(&message.body);
      if (!opaque || opaque->type != tag) continue;
      EXPECT_EQ(message.destination.island, IslandId{70000});
      all.push_back(json::parse(opaque->bytes));
    }
    return all;
  }
};

TEST_F(KnxTools, ReadAnswersWithWhatTheBusSays) {
  server.answers[group("1/2/7")] = {{0x0c, 0x33}, false};
  start();
  const auto answers = ask({{"id", "1"}, {"do", "read"}, {"address", "1/2/7"}});
  ASSERT_THAT(answers, SizeIs(1));
  EXPECT_EQ(answers[0]["id"], "1");
  EXPECT_EQ(answers[0]["ok"], true);
  EXPECT_EQ(answers[0]["value"], "21.5");
  EXPECT_EQ(answers[0]["number"], 21.5);
  EXPECT_EQ(answers[0]["dpt"], "9.001");
  EXPECT_EQ(answers[0]["secured"], false);
  EXPECT_EQ(answers[0]["source"], "1.1.250");
}

TEST_F(KnxTools, ValuesAreShownAsPeopleWriteThem) {
  server.answers[group("1/0/3")] = {{0x80}, false};
  start();
  EXPECT_EQ(ask({{"id", "1"}, {"do", "read"}, {"address", "1/0/3"}}).at(0)["value"], "50");
  server.answers[group("1/0/3")] = {{0x41, 0xc2, 0x66, 0x66}, false};
  EXPECT_EQ(ask({{"id", "1"}, {"do", "read"}, {"address", "1/0/3"}, {"dpt", "14.068"}}).at(0)["value"], "24.3");
}

TEST_F(KnxTools, WordsAreNoNumbers) {
  server.answers[group("1/0/1")] = {{1}, true};
  start();
  const auto answer = ask({{"id", "1"}, {"do", "read"}, {"address", "1/0/1"}}).at(0);
  EXPECT_EQ(answer["value"], "on");
  EXPECT_FALSE(answer.contains("number"));
}

TEST_F(KnxTools, TheNameAndNotationOfAStateAddressAreItsOwn) {
  server.answers[group("1/0/2")] = {{1}, true};
  start(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "notation": "free", "groups": {
    "1/0/1": {"dpt": "1.001", "name": "Lamp", "state": "1/0/2", "state-name": "Lamp status"}}})");
  const auto answer = ask({{"id", "1"}, {"do", "read"}, {"address", "1/0/2"}}).at(0);
  EXPECT_EQ(answer["name"], "Lamp status");
  EXPECT_EQ(answer["address"], "2050");
}

TEST_F(KnxTools, AnUnansweredReadIsReportedOnce) {
  start();
  const auto answers = ask({{"id", "2"}, {"do", "read"}, {"address", "7/7/7"}});
  ASSERT_THAT(answers, SizeIs(1));
  EXPECT_EQ(answers[0]["ok"], false);
  EXPECT_THAT(answers[0]["why"].get<std::string>(), HasSubstr("7/7/7"));
}

TEST_F(KnxTools, WriteAnswersWhenTheBusHasIt) {
  start();
  const auto answers = ask({{"id", "3"}, {"do", "write"}, {"address", "5/5/5"}, {"dpt", "9.001"}, {"value", "21.5"}});
  ASSERT_THAT(answers, SizeIs(1));
  EXPECT_EQ(answers[0]["ok"], true);
  EXPECT_EQ(answers[0]["hex"], "0c33");
  EXPECT_EQ(telegrams("5/5/5", {0x00, 0x80, 0x0c, 0x33}), 1);
}

TEST_F(KnxTools, AMemberCannotWriteWhatCommandsAnActuator) {
  start(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "groups": {
    "1/0/1": {"dpt": "1.001", "kind": "actuator", "state": "1/0/2", "listen": ["0/0/1"]},
    "1/4/6": {"dpt": "5.001", "device": "living", "instance": "ceiling", "kind": "actuator"},
    "1/2/7": {"dpt": "9.001"}}})");
  const model::Sender robot{.name = "robot"};
  const auto why = [&](const char* address, const char* type) {
    const auto answer = ask({{"do", "write"}, {"address", address}, {"dpt", type}, {"value", "1"}}, robot).at(0);
    return answer["ok"] == true ? "written" : answer["why"].get<std::string>();
  };
  EXPECT_EQ(why("1/0/1", "1.001"),
            "messages cannot command actuators, and 1/0/1 commands one: set actuator.switch-1.command of device 1/0/1 "
            "instead");
  EXPECT_THAT(why("0/0/1", "1.001"), HasSubstr("device 1/0/1")) << "a central function";
  EXPECT_THAT(why("1/4/6", "5.001"), HasSubstr("-ceiling.command of device living"));
  EXPECT_THAT(server.heard(), IsEmpty());
  EXPECT_EQ(why("1/2/7", "9.001"), "written") << "a sensor";
  EXPECT_EQ(why("5/5/5", "9.001"), "written") << "no point has it";
}

TEST_F(KnxTools, WithoutMembersEverythingCanBeWritten) {
  start();
  EXPECT_EQ(ask({{"do", "write"}, {"address", "1/0/1"}, {"value", "on"}}).at(0)["ok"], true);
  EXPECT_EQ(telegrams("1/0/1", {0x00, 0x81}), 1);
}

TEST_F(KnxTools, NestedRubbishIsHarmless) {
  start();
  const std::string deep = R"({"id":)" + std::string(100'000, '[') + std::string(100'000, ']') + R"(,"do":"read"})";
  const auto bytes = base::as_bytes(deep);
  std::ignore = send(model::Opaque{std::string(kRequestTag), Bytes(bytes.begin(), bytes.end())}, "");
  host.time.run_for(1s);
  EXPECT_LE(messages(kReplyTag).size(), 1U);
}

TEST_F(KnxTools, AReadEndsWithTheLine) {
  start();
  host.delivered.clear();
  const auto bytes = base::as_bytes(std::string_view(R"({"id":"9","do":"read","address":"7/7/7"})"));
  ASSERT_TRUE(send(model::Opaque{std::string(kRequestTag), Bytes(bytes.begin(), bytes.end())}, ""));
  host.time.run_for(1s);
  server.disconnect_all();
  host.time.run_for(1s);
  ASSERT_THAT(messages(kReplyTag), SizeIs(1));
  EXPECT_THAT(messages(kReplyTag)[0]["why"].get<std::string>(), HasSubstr("lost"));
}

TEST_F(KnxTools, WhatIsWrittenIsHeardByOurOwnPointsToo) {
  start();
  ask({{"id", "w"}, {"do", "write"}, {"address", "1/2/7"}, {"dpt", "9.001"}, {"value", "21.5"}});
  EXPECT_THAT(values_of("1/2/7"), ElementsAre("21.5"));
}

TEST_F(KnxTools, WrongRequestsAreRefusedInWords) {
  start();
  const std::pair<json, const char*> wrong[] = {
      {{{"do", "fly"}}, "expected read, write, monitor or capture"},
      {{{"do", "read"}, {"address", "1/2"}, {"dpt", "x"}}, "x"},
      {{{"do", "read"}, {"address", "32/0/0"}}, "main group"},
      {{{"do", "write"}, {"address", "1/2/7"}, {"dpt", "9.001"}, {"value", "warm"}}, "warm"},
      {{{"do", "write"}, {"address", "5/5/5"}, {"value", "1"}}, "name one"},
      {{{"do", "write"}, {"address", "5/5/5"}, {"dpt", "999.1"}, {"value", "1"}}, "999.001"}};
  for (const auto& [request, why] : wrong) {
    const auto answers = ask(request);
    ASSERT_THAT(answers, SizeIs(1)) << request;
    EXPECT_THAT(answers[0]["why"].get<std::string>(), HasSubstr(why));
  }
  EXPECT_FALSE(send(model::Opaque{std::string(kRequestTag), {0xff, 0x00}}, ""));
  EXPECT_FALSE(send(model::Opaque{"chat", {'x'}}, "")) << "not a request";
}

TEST_F(KnxTools, WithoutALineOnlyWhatNeedsItIsRefused) {
  server.stop();
  start();
  EXPECT_EQ(ask({{"do", "read"}, {"address", "1/2/7"}})[0]["ok"], false);
  EXPECT_EQ(ask({{"do", "capture"}})[0]["ok"], true);
  EXPECT_EQ(ask({{"do", "monitor"}})[0]["ok"], true);
}

TEST_F(KnxTools, AMonitorHearsEverythingUntilItsLeaseEnds) {
  start();
  ask({{"id", "m"}, {"do", "monitor"}, {"seconds", 30}});
  host.delivered.clear();
  server.inject(0x1105, group("1/2/7"), 0x80, {0x0c, 0x33});
  host.time.run_for(100ms);
  ASSERT_TRUE(send(model::Actuate{5, point(Kind::kActuator, "switch"), true}, "1/0/1"));
  host.time.run_for(100ms);
  const auto telegrams_seen = messages(kTelegramTag);
  ASSERT_THAT(telegrams_seen, SizeIs(2));
  EXPECT_EQ(telegrams_seen[0]["value"], "21.5");
  EXPECT_EQ(telegrams_seen[0]["name"], "Hall temperature");
  EXPECT_EQ(telegrams_seen[0]["own"], false);
  EXPECT_EQ(telegrams_seen[1]["address"], "1/0/1");
  EXPECT_EQ(telegrams_seen[1]["own"], true);
  host.time.run_for(30s);
  host.delivered.clear();
  server.inject(0x1105, group("1/2/7"), 0x80, {0x0c, 0x65});
  host.time.run_for(1s);
  EXPECT_THAT(messages(kTelegramTag), IsEmpty());
}

TEST_F(KnxTools, MonitorsAreBounded) {
  start();
  std::vector<json> last;
  for (std::size_t i = 0; i <= network::Monitors::kMaxCount; ++i) {
    last = ask({{"id", std::to_string(i)}, {"do", "monitor"}, {"seconds", 600}});
  }
  EXPECT_EQ(last.at(0)["ok"], false);
  EXPECT_EQ(ask({{"id", "0"}, {"do", "monitor"}, {"seconds", 600}})[0]["ok"], true) << "renewed";
}

TEST_F(KnxTools, CaptureGivesTheFramesInPieces) {
  start();
  for (int i = 0; i < 700; ++i) server.inject(0x1105, group("1/2/7"), 0x80, {0x0c, static_cast<std::uint8_t>(i % 200)});
  host.time.run_for(10s);
  const auto first = ask({{"id", "c"}, {"do", "capture"}});
  ASSERT_THAT(first, SizeIs(1));
  EXPECT_EQ(first[0]["more"], true);
  const auto next = first[0]["frames"].back()["number"].get<std::uint64_t>() + 1;
  const auto second = ask({{"id", "c"}, {"do", "capture"}, {"from", next}});
  EXPECT_EQ(second.at(0)["more"], false);
  EXPECT_GE(first[0]["frames"].size() + second[0]["frames"].size(), 700U);
  EXPECT_EQ(second[0]["frames"][0]["number"], next);
}

TEST(KnxCapture, IsBoundedInTimeAndMemory) {
  Capture capture({1min, 1000});
  const Bytes frame(36, 0x29);
  const WallTime start{1'800'000'000'000'000us};
  for (int i = 0; i < 50; ++i) capture.add(frame, false, start + i * 1s);
  EXPECT_THAT(capture.frames(), SizeIs(10));
  capture.add(frame, false, start + 1h);
  EXPECT_THAT(capture.frames(), SizeIs(1));
}

TEST(KnxCapture, IsWrittenAsPacketsOfRouting) {
  const Capture::Frame frame{1, WallTime{1'700'000'000'500'000us}, false,
                             base::from_hex("2900bcd011c80a070300800c33").value()};
  EXPECT_EQ(base::to_hex(pcap_file_header()), "d4c3b2a1020004000000000000000000ffff000065000000");
  const auto hex = base::to_hex(pcap_record(frame));
  EXPECT_EQ(hex.substr(0, 32), "00f1536520a107002f0000002f000000");
  EXPECT_THAT(hex, testing::EndsWith("0e570e57001b0000061005300013"
                                     "2900bcd011c80a070300800c33"));
  // The checksum over the IP head with itself is 0 (RFC 1071).
  const auto record = pcap_record(frame);
  std::uint32_t sum = 0;
  for (std::size_t i = 16; i < 36; i += 2) sum += static_cast<std::uint32_t>(record[i] << 8 | record[i + 1]);
  EXPECT_EQ((sum & 0xffff) + (sum >> 16), 0xffffU);
}

}  // namespace
}  // namespace rubicon::networks::knx
