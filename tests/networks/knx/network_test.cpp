#include <nlohmann/json.hpp>

#include "networks/knx/bench.h"

namespace rubicon::networks::knx {
namespace {

using model::Outcome;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class KnxPoints : public KnxBench {
 protected:
  Result<void> sample(const std::string& device, std::vector<PointId> points) {
    return send(model::Sample{9, std::move(points), 1s}, device);
  }
  Result<void> command(const std::string& device, const PointId& to, Value value) {
    return send(model::Actuate{5, to, std::move(value)}, device);
  }
  std::vector<std::string> outcomes() const {
    std::vector<std::string> words;
    for (const auto& [device, answer] : host.all<model::Acknowledge>())
      words.push_back(std::string(to_string(answer.outcome)) + (answer.text.empty() ? "" : ": " + answer.text));
    return words;
  }
};

TEST_F(KnxPoints, DevicesAreThereBeforeAnyContact) {
  server.stop();
  start();
  const auto joins = host.all<model::Join>();
  ASSERT_THAT(joins, SizeIs(5));
  EXPECT_EQ(joins[0].first, "1/0/1");
  EXPECT_EQ(joins[0].second.name, "Hall light");
  EXPECT_EQ(joins[0].second.model, "KNX 1/0/1, state 1/0/2, DPT 1.001");
  EXPECT_EQ(joins[4].second.model, "KNX 1/4/6, DPT 5.001; 1/4/7, DPT 9.004");
  EXPECT_FALSE(joins[0].second.heard);
  const auto& light = joins[0].second.capabilities.at(0);
  EXPECT_EQ(light.point, point(Kind::kActuator, "switch"));
  EXPECT_TRUE(light.reports);
  EXPECT_TRUE(light.sampled);
  EXPECT_FALSE(joins[1].second.capabilities.at(0).reports) << "no state address";
  EXPECT_EQ(joins[4].first, "living");
  EXPECT_EQ(joins[4].second.name, "Living room");
  EXPECT_THAT(joins[4].second.capabilities, SizeIs(2));
}

TEST_F(KnxPoints, TelegramsOfTheBusAreReadings) {
  start();
  server.inject(0x1105, group("1/2/7"), 0x80, {0x0c, 0x33});
  server.inject(0x1105, group("1/2/9"), 0x80, {0x0c, 0x65});
  server.inject(0x1106, group("1/0/2"), 0x80, {1}, true);
  host.time.run_for(1s);
  EXPECT_THAT(values_of("1/2/7"), ElementsAre("21.5", "22.5"));
  EXPECT_THAT(values_of("1/0/1"), ElementsAre("on"));
}

TEST_F(KnxPoints, ACommandOfAnotherIsNoReportOfAnActuatorThatReports) {
  start();
  server.inject(0x1106, group("1/0/1"), 0x80, {1}, true);
  server.inject(0x1106, group("1/0/3"), 0x80, {0xff});
  host.time.run_for(1s);
  EXPECT_THAT(values_of("1/0/1"), IsEmpty());
  EXPECT_THAT(values_of("1/0/3"), ElementsAre("100")) << "has no state address: what others command is all there is";
  EXPECT_EQ(last_state().counters.at("unassigned-addresses"), 0U);
}

TEST_F(KnxPoints, ValuesThatDoNotFitTheirTypeAreBadAndListed) {
  start();
  server.inject(0x1105, group("1/2/7"), 0x80, {0x0c});
  server.inject(0x1105, group("1/2/7"), 0x80, {0x7f, 0xff});
  host.time.run_for(2s);
  EXPECT_THAT(values_of("1/2/7"), ElementsAre("-", "-"));
  EXPECT_EQ(last_state().counters.at("undecodable-values"), 2U);
  EXPECT_FALSE(host.words.contains("1/2/7")) << "the proxy logs the reason of the reading";
  const auto listed = nlohmann::json::parse(last_state().texts.at("problems"));
  ASSERT_FALSE(listed.empty());
  EXPECT_EQ(listed[0]["address"], "1/2/7");
  EXPECT_EQ(listed[0]["what"], "value");
  EXPECT_EQ(listed[0]["count"], 2);
  EXPECT_THAT(listed[0]["reason"].get<std::string>(), HasSubstr("7fff means no valid value")) << "the last one";
}

TEST_F(KnxPoints, OnlyWhatIsWantedOrMarkedIsRead) {
  server.answers[group("1/2/7")] = {{0x0c, 0x33}, false};
  server.answers[group("1/2/8")] = {{0x0c, 0x33}, false};
  start();
  host.time.run_for(10s);
  EXPECT_EQ(reads_of("1/2/7"), 0);
  EXPECT_EQ(reads_of("1/2/8"), 1) << "read: init";
  ASSERT_TRUE(sample("1/2/7", {point(Kind::kSensor, "temperature")}));
  host.time.run_for(1s);
  EXPECT_EQ(reads_of("1/2/7"), 1);
  EXPECT_THAT(values_of("1/2/7"), ElementsAre("21.5"));
  ASSERT_TRUE(sample("1/2/7", {}));
  ASSERT_TRUE(sample("1/2/7", {point(Kind::kSensor, "temperature")}));
  host.time.run_for(10s);
  EXPECT_EQ(reads_of("1/2/7"), 1) << "its value is known";
}

TEST_F(KnxPoints, TheStateOfAnActuatorIsReadWhenWanted) {
  server.answers[group("1/0/2")] = {{1}, true};
  start();
  ASSERT_TRUE(sample("1/0/1", {point(Kind::kActuator, "switch")}));
  host.time.run_for(1s);
  EXPECT_EQ(reads_of("1/0/2"), 1);
  EXPECT_EQ(reads_of("1/0/1"), 0);
  EXPECT_THAT(values_of("1/0/1"), ElementsAre("on"));
}

TEST_F(KnxPoints, WhatIsReadEveryMinuteIsSoWhileWantedOnly) {
  server.answers[group("1/4/7")] = {{0x0c, 0x33}, false};
  start();
  host.time.run_for(5min);
  const auto before = reads_of("1/4/7");
  EXPECT_EQ(before, 1) << "marked: asked at start";
  ASSERT_TRUE(sample("living", {point(Kind::kSensor, "light")}));
  host.time.run_for(5min);
  EXPECT_EQ(reads_of("1/4/7"), before + 5);
  ASSERT_TRUE(sample("living", {}));
  host.time.run_for(5min);
  EXPECT_EQ(reads_of("1/4/7"), before + 5);
}

TEST_F(KnxPoints, AReadWithoutAnswerIsRepeatedOnceAndLogged) {
  start();
  ASSERT_TRUE(sample("1/2/7", {point(Kind::kSensor, "temperature")}));
  host.time.run_for(10s);
  EXPECT_EQ(reads_of("1/2/7"), 2);
  EXPECT_EQ(last_state().counters.at("unanswered-reads"), 3U) << "and two that are read at start";
  EXPECT_TRUE(host.words.contains("1/2/7: no device on the bus answers a read"));
}

TEST_F(KnxPoints, ACommandIsSentWhenTheBusHasIt) {
  server.confirm_time = 500ms;
  start();
  ASSERT_TRUE(command("1/0/1", point(Kind::kActuator, "switch"), true));
  host.time.run_for(400ms);
  EXPECT_EQ(telegrams("1/0/1", {0x00, 0x81}), 1);
  EXPECT_THAT(outcomes(), IsEmpty());
  host.time.run_for(200ms);
  EXPECT_THAT(outcomes(), ElementsAre("sent"));
}

TEST_F(KnxPoints, AReportOfTheCommandedBytesIsTheCommandedValue) {
  start(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "groups": {
    "1/0/3": {"dpt": "5.001", "kind": "actuator", "state": "1/0/4"}}})");
  const auto dimmer = point(Kind::kActuator, "percentage");
  for (const double percent : {50.0, 33.4, 0.3}) {
    server.on_heard = [this](const auto& heard) {
      if (heard.destination == group("1/0/3")) server.inject(0x1106, group("1/0/4"), 0x80, {heard.tpdu.back()});
    };
    ASSERT_TRUE(command("1/0/3", dimmer, percent));
    host.time.run_for(5s);
  }
  server.inject(0x1106, group("1/0/4"), 0x80, {0x80});
  host.time.run_for(1s);
  EXPECT_THAT(values_of("1/0/3"), ElementsAre("50", "33.4", "0.3", "50")) << "50 and not 50.19607843137255";
  EXPECT_EQ(reads_of("1/0/4"), 0);
}

TEST_F(KnxPoints, AFailedCommandDoesNotDisturbTheNewerOne) {
  start();
  server.confirms_negatively = true;
  ASSERT_TRUE(send(model::Actuate{5, point(Kind::kActuator, "switch"), false}, "1/0/1"));
  ASSERT_TRUE(send(model::Actuate{6, point(Kind::kActuator, "switch"), true}, "1/0/1"));
  server.on_heard = [this](const auto&) { server.confirms_negatively = false; };
  server.answers[group("1/0/2")] = {{1}, true};
  host.time.run_for(5s);
  EXPECT_EQ(reads_of("1/0/2"), 1) << "the state is asked for the newer one";
  EXPECT_THAT(values_of("1/0/1"), ElementsAre("on"));
}

TEST_F(KnxPoints, ACommandToACentralAddressIsHeardByThoseWhoListen) {
  start(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "groups": {
    "0/0/1": {"dpt": "1.001", "kind": "actuator"},
    "1/0/1": {"dpt": "1.001", "kind": "sensor", "listen": ["0/0/1"]}}})");
  ASSERT_TRUE(command("0/0/1", point(Kind::kActuator, "switch"), true));
  host.time.run_for(1s);
  EXPECT_THAT(values_of("1/0/1"), ElementsAre("on"));
}

TEST_F(KnxPoints, ACommandIsNoReportOfTheActuatorItself) {
  start();
  ASSERT_TRUE(command("1/0/3", point(Kind::kActuator, "percentage"), 50.0));
  host.time.run_for(5s);
  EXPECT_THAT(outcomes(), ElementsAre("sent"));
  EXPECT_THAT(values_of("1/0/3"), IsEmpty()) << "the island calls it assumed";
}

TEST_F(KnxPoints, VerificationDoesNotWaitForUnansweredReads) {
  std::string text = R"({"host": "10.0.0.9", "telegrams-per-second": 0, "groups": {)";
  for (int i = 1; i <= 100; ++i) text += "\"2/0/" + std::to_string(i) + R"(": {"dpt": "9.001", "read": "init"}, )";
  server.answers[group("1/0/2")] = {{1}, true};
  start(text + R"("1/0/1": {"dpt": "1.001", "kind": "actuator", "state": "1/0/2"}}})");
  ASSERT_TRUE(command("1/0/1", point(Kind::kActuator, "switch"), true));
  host.time.run_for(2s);
  EXPECT_THAT(values_of("1/0/1"), ElementsAre("on"));
}

TEST_F(KnxPoints, ATelegramOfTheWrongSizeSaysSoInItsReading) {
  start();
  server.inject(0x1105, group("1/2/7"), 0x80, {0x0c});
  server.inject(0x1105, group("1/2/7"), 0x80, {0x7f, 0xff});
  host.time.run_for(1s);
  std::vector<std::string> reasons;
  for (const auto& [device, updates] : host.all<model::Updates>()) {
    for (const auto& reading : updates.readings) reasons.push_back(reading.why);
  }
  EXPECT_THAT(reasons,
              ElementsAre("telegram 0c: 9.001 temperature: 1 octets, expected 2 octets (the length of the type)",
                          "telegram 7fff: 9.001 temperature: 7fff means no valid value"));
}

TEST_F(KnxPoints, TheCountersGoOnWhenOnlyWeSend) {
  start();
  ASSERT_TRUE(command("1/0/3", point(Kind::kActuator, "percentage"), 50.0));
  host.time.run_for(10s);
  EXPECT_EQ(last_state().counters.at("telegrams-sent"), server.heard().size());
  server.confirms = false;
  ASSERT_TRUE(command("1/0/3", point(Kind::kActuator, "percentage"), 60.0));
  host.time.run_for(6s);
  EXPECT_EQ(last_state().counters.at("unconfirmed"), 1U);
}

TEST_F(KnxPoints, ALineThatTheServerRefusesSaysSoAndCountsItsAttempts) {
  server.connect_status = 0x24;
  start();
  EXPECT_EQ(last_state().line, model::LineState::kRefused);
  EXPECT_THAT(last_state().reason, HasSubstr("status 24"));
  host.time.run_for(60s);
  EXPECT_EQ(last_state().line, model::LineState::kRefused);
  EXPECT_EQ(last_state().counters.at("attempts") + 1, server.counters.connects) << "the first was asked for";
  EXPECT_GE(server.counters.connects, 5U);
  server.connect_status = 0;
  host.time.run_for(80s);
  EXPECT_EQ(last_state().line, model::LineState::kUp);
  EXPECT_EQ(last_state().reason, "");
}

TEST_F(KnxPoints, AttemptsToConnectLoseNothing) {
  server.stop();
  start();
  for (int i = 0; i < 5; ++i) {
    std::ignore = network->open();
    host.time.run_for(15s);
  }
  for (const auto& [device, state] : host.all<model::State>()) {
    const auto count = state.counters.find("undelivered");
    EXPECT_TRUE(count == state.counters.end() || count->second == 0);
  }
}

TEST_F(KnxPoints, TextsHaveTheNotationOfTheProjectAndKeysDoNot) {
  start(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "notation": "two-level", "groups": {
    "0/10": {"dpt": "1.001", "kind": "actuator", "state": "0/11", "state-name": "Lamp status"}}})");
  const auto joins = host.all<model::Join>();
  ASSERT_THAT(joins, SizeIs(1));
  EXPECT_EQ(joins[0].first, "0/0/10") << "of which the key is made";
  EXPECT_EQ(joins[0].second.model, "KNX 0/10, state 0/11 (Lamp status), DPT 1.001");
  server.inject(0x1105, group("1/519"), 0x80, {0x0c, 0x33});
  server.inject(0x1105, group("0/11"), 0x80, {0x0c, 0x33});
  host.time.run_for(2s);
  EXPECT_THAT(last_state().texts.at("unassigned"), HasSubstr("\"1/519\""));
  EXPECT_THAT(last_state().texts.at("problems"), HasSubstr("\"0/11\""));
}

TEST_F(KnxPoints, AReloadAsksOnlyForWhatIsNew) {
  server.answers[group("1/2/8")] = {{0x0c, 0x33}, false};
  start();
  host.time.run_for(10s);
  ASSERT_EQ(reads_of("1/2/8"), 1);
  ASSERT_TRUE(change(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "groups": {
    "1/2/8": {"dpt": "9.007", "read": "init", "name": "another name"}, "1/2/9": {"dpt": "9.001", "read": "init"}}})"));
  host.time.run_for(10s);
  EXPECT_EQ(reads_of("1/2/8"), 1);
  EXPECT_EQ(reads_of("1/2/9"), 2) << "no answer";
}

TEST_F(KnxPoints, AnActuatorThatStaysSilentAfterACommandIsAsked) {
  server.answers[group("1/0/2")] = {{1}, true};
  start();
  ASSERT_TRUE(command("1/0/1", point(Kind::kActuator, "switch"), true));
  host.time.run_for(900ms);
  EXPECT_EQ(reads_of("1/0/2"), 0);
  host.time.run_for(1s);
  EXPECT_EQ(reads_of("1/0/2"), 1);
  EXPECT_THAT(values_of("1/0/1"), ElementsAre("on"));
}

TEST_F(KnxPoints, AnActuatorThatReportsIsNotAsked) {
  server.on_heard = [this](const auto& heard) {
    if (heard.destination == group("1/0/1")) server.inject(0x1106, group("1/0/2"), 0x80, {1}, true);
  };
  start();
  ASSERT_TRUE(command("1/0/1", point(Kind::kActuator, "switch"), true));
  host.time.run_for(5s);
  EXPECT_EQ(reads_of("1/0/2"), 0);
  EXPECT_THAT(values_of("1/0/1"), ElementsAre("on"));
}

TEST_F(KnxPoints, UnacknowledgedCommandsFail) {
  start();
  server.confirms_negatively = true;
  ASSERT_TRUE(command("1/0/1", point(Kind::kActuator, "switch"), true));
  host.time.run_for(1s);
  ASSERT_THAT(outcomes(), SizeIs(1));
  EXPECT_THAT(outcomes()[0], testing::StartsWith("failed"));
  EXPECT_FALSE(command("1/0/3", point(Kind::kActuator, "percentage"), 101.0)) << "out of range";
  EXPECT_FALSE(command("1/2/7", point(Kind::kSensor, "temperature"), 20.0)) << "a sensor";
  EXPECT_FALSE(command("9/9/9", point(Kind::kActuator, "switch"), true));
}

TEST_F(KnxPoints, ALostLineIsReportedAndSubscribedPointsAreReadAgain) {
  server.answers[group("1/2/7")] = {{0x0c, 0x33}, false};
  start();
  ASSERT_TRUE(sample("1/2/7", {point(Kind::kSensor, "temperature")}));
  host.time.run_for(1s);
  server.disconnect_all();
  host.time.run_for(1s);
  ASSERT_THAT(host.failures, SizeIs(1));
  ASSERT_TRUE(network->open());
  host.time.run_for(2s);
  EXPECT_EQ(last_state().line, model::LineState::kUp);
  EXPECT_EQ(reads_of("1/2/7"), 2);
  EXPECT_EQ(server.channels().size(), 1U);
}

TEST_F(KnxPoints, EachLossOfTheLineReadsEverythingWantedExactlyOnceThoughCommandsGoOn) {
  server.answers[group("1/2/7")] = {{0x0c, 0x33}, false};
  server.answers[group("1/0/2")] = {{1}, true};
  start();
  ASSERT_TRUE(sample("1/2/7", {point(Kind::kSensor, "temperature")}));
  ASSERT_TRUE(sample("1/0/1", {point(Kind::kActuator, "switch")}));
  host.time.run_for(1s);
  for (int round = 1; round <= 5; ++round) {
    server.disconnect_all();
    host.time.run_for(1s);
    ASSERT_TRUE(network->open());
    host.time.run_for(10ms);
    for (int i = 0; i < 100; ++i) {
      const auto sent = command("1/0/3", point(Kind::kActuator, "percentage"), static_cast<double>(i));
      ASSERT_TRUE(sent) << sent.error().text;
      host.time.run_for(100ms);
    }
    for (const auto* address : {"1/2/7", "1/0/2"}) EXPECT_EQ(reads_of(address), 1 + round) << address;
  }
}

TEST_F(KnxPoints, ACommandUnderWayWhenTheLineIsLostArrivesAfterwards) {
  start();
  server.acks = false;
  server.listens = false;
  ASSERT_TRUE(command("1/0/1", point(Kind::kActuator, "switch"), true));
  host.time.run_for(2500ms);
  ASSERT_THAT(host.failures, SizeIs(1));
  server.acks = server.listens = true;
  ASSERT_TRUE(network->open());
  host.time.run_for(2s);
  EXPECT_EQ(telegrams("1/0/1", {0x00, 0x81}), 1);
  EXPECT_THAT(outcomes(), ElementsAre("sent"));
}

TEST_F(KnxPoints, ACommandThatIsTooOldNeverReachesTheBus) {
  start();
  server.acks = false;
  server.listens = false;
  ASSERT_TRUE(send(model::Actuate{5, point(Kind::kActuator, "switch"), true, 1s}, "1/0/1"));
  host.time.run_for(2500ms);
  server.acks = server.listens = true;
  ASSERT_TRUE(network->open());
  host.time.run_for(10s);
  EXPECT_EQ(telegrams("1/0/1", {0x00, 0x81}), 0);
  ASSERT_THAT(outcomes(), SizeIs(1));
  EXPECT_THAT(outcomes()[0], testing::StartsWith("failed"));
}

TEST_F(KnxPoints, UnknownAddressesAreListedAndNoDevices) {
  start();
  server.inject(0x1105, group("3/3/3"), 0x80, {0x0c, 0x33});
  server.inject(0x1107, group("3/3/3"), 0x80, {0x0c, 0x65});
  host.time.run_for(2s);
  const auto table = nlohmann::json::parse(last_state().texts.at("unassigned"));
  ASSERT_TRUE(table.contains("3/3/3"));
  EXPECT_EQ(table["3/3/3"]["count"], 2);
  EXPECT_EQ(table["3/3/3"]["last"], "0c65");
  EXPECT_EQ(table["3/3/3"]["source"], "1.1.7");
  EXPECT_THAT(host.all<model::Join>(), SizeIs(5));
}

TEST_F(KnxPoints, TheUnassignedTableKeepsTheLatest) {
  start();
  for (int i = 1; i <= 300; ++i) server.inject(0x1105, static_cast<std::uint16_t>(0x5000 + i), 0x80, {1}, true);
  host.time.run_for(5s);
  EXPECT_EQ(last_state().counters.at("unassigned-addresses"), 256U);
  EXPECT_EQ(last_state().counters.at("dropped-unassigned"), 44U);
  EXPECT_THAT(last_state().texts.at("unassigned"), HasSubstr("10/1/44")) << "the last of them";
}

TEST_F(KnxPoints, RepetitionsOnTheBusCountOnce) {
  start();
  const Bytes first{0x29, 0x00, 0xbc, 0xe0, 0x11, 0x05, 0x0a, 0x07, 0x03, 0x00, 0x80, 0x0c, 0x33};
  Bytes again = first;
  again[2] = 0x9c;  // b5 = 0
  server.inject_cemi(first);
  server.inject_cemi(again);
  host.time.run_for(2s);
  EXPECT_THAT(values_of("1/2/7"), ElementsAre("21.5"));
  EXPECT_EQ(last_state().counters.at("bus-repetitions"), 1U);
  server.inject_cemi(again);
  host.time.run_for(2s);
  EXPECT_THAT(values_of("1/2/7"), SizeIs(2)) << "seconds later it is another telegram";
  auto of_another = again;
  of_another[5] = 0x06;
  server.inject_cemi(first);
  server.inject_cemi(of_another);
  host.time.run_for(2s);
  EXPECT_THAT(values_of("1/2/7"), SizeIs(4)) << "two senders of one value";
}

TEST_F(KnxPoints, OtherPointsAreTakenWithoutLosingTheTunnel) {
  start();
  ASSERT_TRUE(change(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "groups": {
    "1/2/7": {"dpt": "9.001", "name": "Hall temperature"}, "1/2/20": "9.001"}})"));
  host.time.run_for(1s);
  EXPECT_EQ(server.counters.connects, 1U);
  EXPECT_THAT(host.all<model::Leave>(), SizeIs(4));
  EXPECT_EQ(host.all<model::Join>().back().first, "1/2/7");
  server.inject(0x1105, group("1/2/20"), 0x80, {0x0c, 0x33});
  host.time.run_for(1s);
  EXPECT_THAT(values_of("1/2/20"), ElementsAre("21.5"));
  EXPECT_FALSE(change(R"({"host": "10.0.0.8"})")) << "another line";
}

TEST_F(KnxPoints, DevicesWithIndividualAddressesKeepTheirKeysApart) {
  start(R"({"host": "10.0.0.9", "groups": {"1/4/6": "9.001", "1/5/6": "9.001",
    "1/4/7": {"dpt": "9.001", "device": "1.4.6"}}})");
  const auto joins = host.all<model::Join>();
  ASSERT_THAT(joins, SizeIs(3));
  EXPECT_EQ(joins[2].second.id, "") << "no other has its key";
  EXPECT_EQ(joins[0].first, "1.4.6");
  EXPECT_EQ(joins[0].second.id, "");
  EXPECT_EQ(joins[1].second.id, "ga-1_4_6");
}

TEST_F(KnxPoints, AddressesWithoutATypeAreBytes) {
  start(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "groups": {
    "1/5/1": {"name": "raw"}, "1/5/2": {"kind": "actuator"}}})");
  server.inject(0x1105, group("1/5/1"), 0x80, {0xde, 0xad});
  ASSERT_TRUE(command("1/5/2", point(Kind::kActuator, "bytesOutput"), std::string("c0ffee")));
  host.time.run_for(1s);
  EXPECT_THAT(values_of("1/5/1"), ElementsAre("dead"));
  EXPECT_EQ(telegrams("1/5/2", {0x00, 0x80, 0xc0, 0xff, 0xee}), 1);
}

TEST_F(KnxPoints, WrongOptionsAreNamedWithTheirPlace) {
  const ConfigNode node =
      support::config_of(std::string_view(R"({"host": "x", "nat": "maybe", "tunnel-address": "1.1", "burst": 0,
    "groups": {"1/2/3": "9.001"}, "import": "missing.csv", "flavour": "plain",
    "expose": {"1/2/3": {"tuple": "proxy.**", "dpt": "777", "every": "5ms"}}})"));
  ConfigReader reader(node, "networks.knx", errors);
  EXPECT_FALSE(kType.make({"knx", IslandId{1}, reader, types, {}}, host));
  reader.finish();
  for (const auto* what :
       {"networks.knx.nat", "networks.knx.tunnel-address", "networks.knx.burst", "missing.csv", "unknown key 'flavour'",
        "expose.1/2/3.tuple", "expose.1/2/3.dpt", "expose.1/2/3.every", "1/2/3 is also an address under groups"})
    EXPECT_THAT(errors.text(), HasSubstr(what));
}

}  // namespace
}  // namespace rubicon::networks::knx
