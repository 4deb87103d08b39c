#include "networks/salad/salad_network.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "network/supervisor.h"
#include "networks/salad/salad_codec.h"
#include "networks/salad/salad_room.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::salad {
namespace {

using namespace std::chrono_literals;
using model::LineState;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

TEST_F(Salad, AllDevicesOfTheFlatJoinBeforeAnyContact) {
  std::ifstream file(RUBICON_SOURCE_DIR "/examples/salad.properties");
  host.files.put("salad.properties", std::string(std::istreambuf_iterator<char>(file), {}));
  host.net.names_answer = false;
  make(R"({"properties": "salad.properties"})");
  ASSERT_TRUE(network->open());
  EXPECT_THAT(host.all<model::Join>(), SizeIs(55));
  EXPECT_THAT(host.net.sent(), IsEmpty());
  for (const auto& [device, join] : host.all<model::Join>()) {
    EXPECT_FALSE(join.heard) << device << " is reachable only after its first update";
    EXPECT_FALSE(join.name.empty());
  }
}

TEST_F(Salad, JoinsHaveTheirPointsNamedByTypeAndSmallLetters) {
  start();
  std::vector<std::string> all;
  for (const auto& [device, join] : host.all<model::Join>()) {
    for (const auto& c : join.capabilities)
      all.push_back(fmt::format("{} {} {}-{} {}", device, to_string(c.point.kind), types.find(c.point.type)->name,
                                c.point.instance, to_string(c.access)));
  }
  EXPECT_THAT(
      all, ElementsAre("7 sensor switch-fridge read", "13 sensor pressureRaw-bed read",
                       "28 sensor status-tv_state read", "28 actuator status-tv_state read-write",
                       "30 sensor soundRecognitionConfidence-soundprob_tap read", "46 actuator lamp-light read-write",
                       "66 actuator relay-relay read", "68 sensor status-blind_stop read"));
  for (const auto* type : types.all()) EXPECT_EQ(type->name.find_first_of(".-"), type->name.npos);
}

TEST_F(Salad, UpdatesAreAskedForOnceBothSocketsAreUp) {
  start();
  ASSERT_THAT(asked, ElementsAre(kStartUpdates));
  EXPECT_EQ(base::to_hex(base::as_bytes(asked[0])), "2353414c414423303a313a323a3023454e4423");
  EXPECT_EQ(source.address, "127.0.0.1");
  EXPECT_NE(source.port, 9100) << "sent from a port of its own";
  EXPECT_EQ(counters()["port"], 9100u);
}

TEST_F(Salad, ReadingsComeInTheirTypes) {
  start();
  say("#SALADST#7;1:28;10:13;0.5:30;99.5:46;0:66;1#END#");
  EXPECT_THAT(readings(),
              ElementsAre("7 sensor switch-fridge=on", "28 sensor status-tv_state=10", "28 actuator status-tv_state=10",
                          "13 sensor pressureRaw-bed=0.5", "30 sensor soundRecognitionConfidence-soundprob_tap=99.5",
                          "46 actuator lamp-light=off", "66 actuator relay-relay=on"));
  EXPECT_EQ(state().reason, "");
  EXPECT_EQ(counters()["readings"], 6u);
}

TEST_F(Salad, AValueThatDoesNotFitItsTypeIsPassedOnForTheProxyToDecide) {
  start();
  say("#SALADST#7;5:28;0.5:13;9223372036854775808:68;9223372036854775808#END#");
  EXPECT_THAT(
      readings(),
      ElementsAre("7 sensor switch-fridge=5", "28 sensor status-tv_state=0.5", "28 actuator status-tv_state=0.5",
                  "13 sensor pressureRaw-bed=9223372036854775808", "68 sensor status-blind_stop=9223372036854775808"));
}

TEST_F(Salad, CommandsGoToTheActuatorIdAsWholeNumbers) {
  start();
  asked.clear();
  ASSERT_TRUE(command("46", point(Kind::kActuator, "lamp", "light"), true));
  ASSERT_TRUE(command("46", point(Kind::kActuator, "lamp", "light"), false));
  ASSERT_TRUE(command("28", point(Kind::kActuator, "status", "tv_state"), std::int64_t{10}));
  ASSERT_TRUE(command("28", point(Kind::kActuator, "status", "tv_state"), std::int64_t{-3}));
  host.time.run_for(1s);
  EXPECT_THAT(asked, ElementsAre("#SALAD#2:1/1/1:1:0#END#", "#SALAD#2:1/1/1:0:0#END#", "#SALAD#2:LG:10:0#END#",
                                 "#SALAD#2:LG:-3:0#END#"));
  const auto answers = host.all<model::Acknowledge>();
  ASSERT_THAT(answers, SizeIs(4));
  EXPECT_EQ(answers[0].second.outcome, model::Outcome::kSent);
  EXPECT_THAT(readings(), IsEmpty()) << "only the next update says that it was done";
  EXPECT_EQ(counters()["commands"], 4u);
}

TEST_F(Salad, WhatHasNoActuatorIdRefusesCommandsWithALineInTheLog) {
  start();
  asked.clear();
  EXPECT_EQ(command("66", point(Kind::kActuator, "relay", "relay"), true).error().code, ErrorCode::kRefused);
  EXPECT_TRUE(host.words.contains("command to device 66 refused"));
  EXPECT_EQ(command("7", point(Kind::kSensor, "switch", "fridge"), true).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(command("46", point(Kind::kActuator, "relay", "light"), true).error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(command("46", point(Kind::kActuator, "lamp", "light"), 0.5));
  EXPECT_EQ(command("29", point(Kind::kActuator, "lamp", "light"), true).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(command("046", point(Kind::kActuator, "lamp", "light"), true).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(send(model::Sample{1, {}, 1s}, "7").error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(send(model::Opaque{}, "7").error().code, ErrorCode::kUnsupported);
  host.time.run_for(1s);
  EXPECT_THAT(asked, IsEmpty());
}

TEST_F(Salad, ACommandBeforeTheLineIsThereIsRefused) {
  make();
  EXPECT_EQ(command("46", point(Kind::kActuator, "lamp", "light"), true).error().code, ErrorCode::kUnreachable);
}

TEST_F(Salad, DatagramsOfOtherHostsAreDroppedAndCounted) {
  start();
  transport::MemoryTransports stranger;
  stranger.join(host.net, "10.0.0.9");
  const auto socket = stranger.open_udp({{"", 9000}, 64}, {[](auto&, auto) {}, [](auto) {}, [](auto) {}}).value();
  ASSERT_TRUE(socket->send({"127.0.0.1", 9100}, base::as_bytes("#SALADST#7;1#END#")));
  host.time.run_for(1s);
  EXPECT_THAT(readings(), IsEmpty());
  EXPECT_EQ(counters()["dropped-other-source"], 1u);
}

TEST_F(Salad, AnySourceTakesThemAllBeforeTheHostIsKnownToo) {
  host.net.names_answer = false;
  make(R"({"salad_host": "flat", "any_source": "yes", "table": {"7": "FRIDGE,sensor.switch"}})");
  listen();
  ASSERT_TRUE(network->open());
  say("#SALADST#7;1#END#");
  EXPECT_THAT(readings(), ElementsAre("7 sensor switch-fridge=on"));
}

TEST_F(Salad, EveryAddressOfTheHostIsSalad) {
  host.net.name("flat", {"10.0.0.1", "192.168.1.141"});
  start();
  say("#SALADST#7;1#END#");
  EXPECT_THAT(readings(), SizeIs(1));
  EXPECT_EQ(host.net.sent().front().to, (transport::Endpoint{"10.0.0.1", 9000})) << "the first one is sent to";
}

TEST_F(Salad, NothingReceivedStopsReception) {
  start();
  for (const auto* bad : {"garbage", "", "#SALADST#", "#SALADST##", "#SALADST#7;abc#END#", "#SALADST#x;1#END#",
                          "#SALADST#7#END#", "#SALADST#7;1;1#END#", "#SALADST#7;NaN#END#", "\xff\xfe"}) {
    for (int i = 0; i < 100; ++i) say(bad);
  }
  say("#SALADST#7;1#END#");
  EXPECT_THAT(readings(), SizeIs(1));
  auto counts = counters();
  EXPECT_EQ(counts["dropped-not-salad"], 300u);
  EXPECT_EQ(counts["dropped-empty"], 200u);
  EXPECT_EQ(counts["dropped-bad-number"], 200u);
  EXPECT_EQ(counts["dropped-bad-id"], 100u);
  EXPECT_EQ(counts["dropped-bad-form"], 200u);
  EXPECT_LE(host.words.lines.size(), 10u) << "a few lines a minute and kind";
  EXPECT_THAT(host.failures, IsEmpty());
}

TEST_F(Salad, AnUnknownIdIsNamedOnceAndHasNoReading) {
  start();
  for (int i = 0; i < 10; ++i) say("#SALADST#29;7#END#");
  EXPECT_THAT(readings(), IsEmpty());
  EXPECT_EQ(std::count(host.words.lines.begin(), host.words.lines.end(),
                       "network: device 29 is not configured, its readings are dropped"),
            1);
  for (int id = 1000; id < 3000; ++id) say(fmt::format("#SALADST#{};1", id));
  EXPECT_LE(host.words.lines.size(), 10u);
  EXPECT_EQ(counters()["dropped-unknown-id"], 2010u);
}

TEST_F(Salad, ADatagramThatFillsTheBufferLosesItsLastItem) {
  start(
      R"({"salad_host": "flat", "socket_buffer_size_bytes": 21, "table": {"7": "A,sensor.status", "8": "B,sensor.status"}})");
  say("#SALADST#7;1:8;2:7;1234567");
  EXPECT_THAT(readings(), ElementsAre("7 sensor status-a=1", "8 sensor status-b=2"));
  EXPECT_EQ(counters()["dropped-cut"], 1u);
}

TEST_F(Salad, TheLineIsUpWhileSaladAnswersAndNoLonger) {
  start();
  say("garbage");
  EXPECT_TRUE(line_is(LineState::kConnecting, "no update from SALAD yet")) << "it was asked and has not answered";
  say("#SALADST#7;1#END#");
  EXPECT_TRUE(line_is(LineState::kUp, ""));
  host.time.run_for(11s);
  EXPECT_TRUE(line_is(LineState::kConnecting, "SALAD stopped sending updates; they were requested again"));
}

TEST_F(Salad, ASaladThatEndsTakesTheLineDown) {
  start();
  say("#SALADST#7;1#END#");
  salad.reset();
  host.time.run_for(11s);
  EXPECT_EQ(state().line, LineState::kDown);
  listen();
  host.time.run_for(21s);
  EXPECT_TRUE(line_is(LineState::kConnecting, "no update from SALAD yet")) << "it takes what we send again";
}

TEST_F(Salad, AfterSilenceUpdatesAreAskedForAgain) {
  start();
  host.time.run_for(8s);
  EXPECT_THAT(asked, SizeIs(1));
  host.time.run_for(2s);
  EXPECT_THAT(asked, ElementsAre(kStartUpdates, kStartUpdates));
  for (int i = 0; i < 30; ++i) {
    say("#SALADST#7;1#END#");
    host.time.run_for(1s);
  }
  EXPECT_THAT(asked, SizeIs(2)) << "not while SALAD speaks";
  host.time.run_for(11s);
  EXPECT_THAT(asked, SizeIs(3));
  EXPECT_THAT(state().reason, HasSubstr("SALAD stopped sending updates"));
  for (int i = 0; i < 10; ++i) say("garbage");
  host.time.run_for(10s);
  EXPECT_THAT(asked, SizeIs(4)) << "garbage is no update";
}

TEST_F(Salad, NeverMeansNever) {
  start(R"({"salad_host": "flat", "start-again-after": "never", "table": {"7": "A,sensor.status"}})");
  host.time.run_for(1h);
  EXPECT_THAT(asked, SizeIs(1));
}

TEST_F(Salad, AMovedSaladIsFoundAgain) {
  start();
  transport::MemoryTransports other;
  other.join(host.net, "192.168.1.142");
  host.net.name("flat", {"192.168.1.142"});
  std::vector<std::string> there;
  const auto socket =
      other
          .open_udp({{"", 9000}, 64}, {[&](auto&, ByteView bytes) { there.emplace_back(base::as_text(bytes)); },
                                       [](auto) {}, [](auto) {}})
          .value();
  host.time.run_for(25s);
  EXPECT_THAT(there, Contains(kStartUpdates));
  ASSERT_TRUE(socket->send({"127.0.0.1", 9100}, base::as_bytes("#SALADST#7;1#END#")));
  host.time.run_for(1s);
  EXPECT_THAT(readings(), SizeIs(1));
  host.net.name("flat", {});
  host.time.run_for(25s);
  EXPECT_THAT(host.failures, IsEmpty()) << "what was known stays";
  EXPECT_GE(there.size(), 3u);
}

TEST_F(Salad, ItsEndStopsTheUpdates) {
  start();
  asked.clear();
  network.reset();
  host.time.run_for(1s);
  EXPECT_THAT(asked, ElementsAre("#SALAD#0:0:2:0#END#"));
  EXPECT_EQ(host.net.open_sockets(), 1u) << "SALAD's own";
}

TEST_F(Salad, NobodyAtTheOtherEndIsSeenAndHarmless) {
  make();
  ASSERT_TRUE(network->open());
  host.time.run_for(5s);
  EXPECT_THAT(host.failures, IsEmpty());
  EXPECT_EQ(state().line, LineState::kDown);
  EXPECT_THAT(state().reason, HasSubstr("SALAD cannot be reached: UDP 192.168.1.141:9000"));
  EXPECT_EQ(counters()["undelivered-datagrams"], 1u);
  listen();
  host.time.run_for(10s);
  EXPECT_THAT(asked, ElementsAre(kStartUpdates));
  say("#SALADST#7;1#END#");
  EXPECT_TRUE(line_is(LineState::kUp, ""));
}

TEST_F(Salad, AHostThatCannotBeFoundIsALostLine) {
  host.net.name("flat", {});
  make();
  ASSERT_TRUE(network->open());
  host.time.run_for(1s);
  ASSERT_THAT(host.failures, SizeIs(1));
  EXPECT_EQ(host.failures[0].text, "host flat cannot be found: Name or service not known");
  EXPECT_EQ(host.net.open_sockets(), 0u);
  EXPECT_THAT(joined(), SizeIs(7)) << "its devices are there all the same";
  host.net.name("flat", {"192.168.1.141"});
  listen();
  ASSERT_TRUE(network->open());
  host.time.run_for(1s);
  EXPECT_THAT(asked, ElementsAre(kStartUpdates));
  EXPECT_THAT(joined(), SizeIs(7)) << "and join once";
}

TEST_F(Salad, ATakenPortIsTriedAgainByTheSupervisorUntilItIsFree) {
  struct Sink final : network::MessageSink {
    void from_network(const std::string&, Message&& message) override { messages.push_back(std::move(message)); }
    std::vector<Message> messages;
  } sink;
  listen();
  auto squatter = host.files.open_udp({{"", 9100}, 64}, {[](auto&, auto) {}, [](auto) {}, [](auto) {}}).value();
  network::Supervisor supervisor(IslandId{1}, host.time, host.files, host.words, sink);
  const ConfigNode node = support::config_of(kRoom);
  ConfigReader reader(node, "", errors);
  ASSERT_TRUE(supervisor.add(kType, {"salad", IslandId{1}, reader, types, {}}));
  supervisor.start();
  host.time.run_for(60s);
  std::size_t joins = 0;
  std::string reason;
  for (const auto& message : sink.messages) {
    joins += message.kind() == MessageKind::kJoin;
    if (const auto* said = std::get_if<model::State>(&message.body)) reason = said->reason;
  }
  EXPECT_EQ(joins, 7u);
  EXPECT_THAT(reason, HasSubstr("Address already in use"));
  EXPECT_THAT(asked, IsEmpty());
  squatter.reset();
  host.time.run_for(1s);
  EXPECT_THAT(asked, ElementsAre(kStartUpdates));
}

TEST_F(Salad, OpeningAnOpenLineAsksForNothingTwice) {
  start();
  ASSERT_TRUE(network->open());
  ASSERT_TRUE(network->open());
  host.time.run_for(1s);
  EXPECT_THAT(asked, SizeIs(1));
  EXPECT_THAT(joined(), SizeIs(7));
}

TEST_F(Salad, ABusyLineIsSaidToTheCommander) {
  start();
  host.net.refuses = 1;
  EXPECT_EQ(command("46", point(Kind::kActuator, "lamp", "light"), true).error().code, ErrorCode::kBusy);
  EXPECT_EQ(counters()["unsent"], 1u);
}

TEST_F(Salad, ALineWithoutARouteIsLostAtOnceAndOpenedAgain) {
  start();
  host.net.no_way = "Network is unreachable";
  EXPECT_EQ(command("46", point(Kind::kActuator, "lamp", "light"), true).error().code, ErrorCode::kIo);
  EXPECT_THAT(host.failures, IsEmpty()) << "not inside of the call";
  host.time.run_for(0s);
  ASSERT_THAT(host.failures, SizeIs(1));
  EXPECT_EQ(host.failures[0].text, "UDP 192.168.1.141:9000: cannot send: Network is unreachable");
  ASSERT_TRUE(network->open());
  host.time.run_for(1s);
  EXPECT_THAT(host.failures, SizeIs(2)) << "the request for updates cannot be sent either";
  host.net.no_way.clear();
  asked.clear();
  ASSERT_TRUE(network->open());
  host.time.run_for(1s);
  EXPECT_THAT(asked, ElementsAre(kStartUpdates));
}

class SaladChange : public Salad {
 protected:
  Result<void> change(std::string_view options) {
    const ConfigNode node = support::config_of(options);
    ConfigReader reader(node, "networks.salad", errors);
    auto changed = network->change({"salad", IslandId{1}, reader, types, {}});
    reader.finish();
    return changed;
  }
};

TEST_F(SaladChange, TakesDevicesInAndOutWithoutTouchingTheLine) {
  start();
  host.delivered.clear();
  ASSERT_TRUE(change(R"({"salad_host": "flat", "table": {
    "7": "FRIDGE,sensor.switch", "13": "BED,sensor.status", "28": "TV_STATE,sensor.status,LG",
    "46": "LIGHT,actuator.light,2/2/2", "47": "NEW,actuator.light", "68": "BLIND_STOP,sensor.status"}})"));
  EXPECT_THAT(joined(), ElementsAre("13", "46", "47")) << "changed type, changed actuator id, new";
  std::vector<std::string> left;
  for (const auto& [device, leave] : host.all<model::Leave>()) left.push_back(device);
  EXPECT_THAT(left, ElementsAre("30", "66"));
  host.time.run_for(1s);
  EXPECT_THAT(asked, SizeIs(1)) << "no second start, no stop";
  say("#SALADST#30;1:47;1#END#");
  EXPECT_THAT(readings(), ElementsAre("47 actuator lamp-new=on"));
  ASSERT_TRUE(command("46", point(Kind::kActuator, "lamp", "light"), true));
  host.time.run_for(1s);
  EXPECT_EQ(asked.back(), "#SALAD#2:2/2/2:1:0#END#");
}

TEST_F(SaladChange, AnotherLineIsNotForIt) {
  start();
  host.delivered.clear();
  for (const auto* options :
       {R"({"salad_host": "flat2", "table": {"7": "A,sensor.status"}})", R"({"table": {"7": "A,sensor.status"}})",
        R"({"salad_host": "flat", "salad_port": 1, "table": {"7": "A,sensor.status"}})",
        R"({"salad_host": "flat", "rubicon_port": 1, "table": {"7": "A,sensor.status"}})",
        R"({"salad_host": "flat", "socket_buffer_size_bytes": 99, "table": {"7": "A,sensor.status"}})"}) {
    EXPECT_EQ(change(options).error().code, ErrorCode::kUnsupported) << options;
  }
  EXPECT_FALSE(change(R"({"salad_host": "flat", "table": {"7": "A"}})"));
  EXPECT_THAT(host.delivered, IsEmpty()) << "nothing was changed";
  say("#SALADST#7;1#END#");
  EXPECT_THAT(readings(), ElementsAre("7 sensor switch-fridge=on"));
}

TEST_F(SaladChange, AnySourceAndPatienceAreChangedAsTheyGo) {
  start();
  ASSERT_TRUE(change(R"({"salad_host": "flat", "any_source": "yes", "start-again-after": "3s",
                         "table": {"7": "FRIDGE,sensor.switch"}})"));
  host.time.run_for(4s);
  EXPECT_THAT(asked, SizeIs(3));
  ASSERT_TRUE(host.files.open_udp({{"", 0}, 64}, {[](auto&, auto) {}, [](auto) {}, [](auto) {}})
                  .value()
                  ->send({"127.0.0.1", 9100}, base::as_bytes("#SALADST#7;0#END#")));
  host.time.run_for(1s);
  EXPECT_THAT(readings(), ElementsAre("7 sensor switch-fridge=off"));
}

TEST_F(SaladChange, BeforeTheFirstOpenOnlyTheListChanges) {
  make();
  ASSERT_TRUE(change(R"({"salad_host": "flat", "table": {"9": "A,sensor.status"}})"));
  EXPECT_THAT(host.delivered, IsEmpty());
  ASSERT_TRUE(network->open());
  EXPECT_THAT(joined(), ElementsAre("9"));
}

}  // namespace
}  // namespace rubicon::networks::salad
