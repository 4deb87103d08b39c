#include "networks/dummy/dummy_network.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/config_text.h"
#include "support/fake_host.h"

namespace rubicon::networks::dummy {
namespace {

using namespace std::chrono_literals;
using model::Acknowledge;
using model::Outcome;
using model::Updates;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::string_view kRoom = R"({"seed": 7, "simulate": {"kitchen": {
  "name": "Kitchen", "join": "1s", "keepalive": "10s", "leave": "100s", "rejoin": "120s",
  "sensors": {"temperature-1": {"wave": "sine", "low": 19, "high": 23, "period": "60s", "noise": 0.1},
              "light-1": {"wave": "random", "low": 5, "high": 400},
              "motion-1": {"wave": "square", "period": "20s"},
              "contact-1": {"wave": "steps", "values": ["closed", "open"], "period": "5s"}},
  "actuators": {"switch-1": {"behaviour": "obey", "value": "off", "delay": "200ms", "sensor": "light-1"},
                "dimmer-1": {"behaviour": "silent"}, "valve-1": {"behaviour": "ignore"}, "lock-1": {"behaviour": "fail"}},
  "properties": {"rate": 500, "room": "kitchen"}}}})";

class Dummy : public ::testing::Test {
 protected:
  void make(std::string_view options = kRoom) {
    const ConfigNode node = support::config_of(options);
    ConfigReader reader(node, "networks.dummy-1", errors);
    auto made = kType.make({"dummy-1", IslandId{1}, reader, types, {}}, host);
    reader.finish();
    if (made) network = std::move(*made);
  }
  void start(std::string_view options = kRoom) {
    make(options);
    ASSERT_TRUE(errors.empty()) << errors.text();
    ASSERT_TRUE(network->open());
    host.time.run_for(2s);
  }
  model::PointId point(Kind kind, std::string_view type) const { return {kind, types.find(type)->id, "1"}; }
  model::PointId sensor(std::string_view type) const { return point(Kind::kSensor, type); }
  model::PointId actuator(std::string_view type) const { return point(Kind::kActuator, type); }

  Result<void> send(model::Body body, const std::string& device = "kitchen") {
    Message message;
    message.destination = {IslandId{1}, "dummy-1", device};
    message.body = std::move(body);
    return network->send(message);
  }
  std::vector<Value> values_of(const model::PointId& of) const {
    std::vector<Value> values;
    for (const auto& [device, updates] : host.all<Updates>()) {
      for (const auto& reading : updates.readings) {
        if (reading.point == of) values.push_back(reading.value);
      }
    }
    return values;
  }
  Acknowledge last_answer() const { return host.all<Acknowledge>().back().second; }

  TypeCatalogue types;
  ConfigErrors errors;
  support::FakeHost host;
  std::unique_ptr<network::Network> network;
};

TEST_F(Dummy, JoinsWithEverythingTheScriptNames) {
  start();
  const auto joins = host.all<model::Join>();
  ASSERT_THAT(joins, SizeIs(1));
  EXPECT_EQ(joins[0].first, "kitchen");
  EXPECT_EQ(joins[0].second.name, "Kitchen");
  EXPECT_THAT(joins[0].second.capabilities, SizeIs(10));
  const model::PointId rate{Kind::kProperty, types.find("rate")->id, ""};
  for (const auto& capability : joins[0].second.capabilities) {
    const Value& initial = capability.initial;
    EXPECT_TRUE(capability.point != rate || initial == Value(std::int64_t{500}));
    EXPECT_TRUE(capability.point != actuator("switch") || initial == Value(false));
    EXPECT_EQ(capability.reports, capability.point != actuator("dimmer"));
  }
}

TEST_F(Dummy, ARangeIsManyDevicesAlike) {
  start(R"({"seed": 7, "simulate": {"room-{1..10000}": {"name": "Room {n}", "sensors": {
         "temperature-1": {"wave": "random", "low": 10, "high": 30}}}}})");
  const auto joins = host.all<model::Join>();
  ASSERT_THAT(joins, SizeIs(10000));
  std::map<std::string, std::string> names;
  for (const auto& [device, join] : joins) names.emplace(device, join.name);
  EXPECT_THAT(names, SizeIs(10000));
  EXPECT_EQ(names.at("room-1"), "Room 1");
  EXPECT_EQ(names.at("room-10000"), "Room 10000");
  host.delivered.clear();
  host.time.run_for(10s);
  EXPECT_THAT(host.all<model::KeepAlive>(), SizeIs(10000));
  for (const auto* room : {"room-1", "room-2"}) {
    ASSERT_TRUE(send(model::Sample{1, {sensor("temperature")}, 1s}, room));
    host.time.run_for(10s);
    ASSERT_TRUE(send(model::Sample{2, {}, 0s}, room));
  }
  const auto values = values_of(sensor("temperature"));
  ASSERT_THAT(values, SizeIs(22));
  EXPECT_NE(std::vector(values.begin(), values.begin() + 11), std::vector(values.begin() + 11, values.end()))
      << "each has a chance of its own";
}

TEST_F(Dummy, TheDevicesOfARangeDoNotSpeakAllAtOnce) {
  start(R"({"simulate": {"room-{1..100}": {"keepalive": "10s"}}})");
  host.delivered.clear();
  host.time.run_for(1s);
  EXPECT_THAT(host.all<model::KeepAlive>(), SizeIs(testing::Le(11u)));
  host.time.run_for(9s);
  EXPECT_THAT(host.all<model::KeepAlive>(), SizeIs(testing::Ge(99u)));
}

TEST_F(Dummy, RangesHaveAsManyDigitsAsTheirFirstNumber) {
  start(R"({"simulate": {"{08..11}-hall": {}, "a{b": {}}})");
  std::vector<std::string> devices;
  for (const auto& [device, join] : host.all<model::Join>()) devices.push_back(device);
  EXPECT_THAT(devices, testing::UnorderedElementsAre("08-hall", "09-hall", "10-hall", "11-hall", "a{b"));
}

TEST_F(Dummy, RangesThatMakeNoSenseAreRefused) {
  make(R"({"simulate": {"room-{5..1}": {}, "{1..x}": {}, "{1..2}-{1..2}": {}, "r-{1..20001}": {},
         "b-{1..3}": {}, "b-2": {}}})");
  for (const auto* text :
       {"simulate.room-{5..1}: is 'room-{5..1}', expected one range of whole numbers, for example room-{1..100}",
        "simulate.{1..x}: is '{1..x}', expected one range", "simulate.{1..2}-{1..2}: is '{1..2}-{1..2}', expected one",
        "simulate.r-{1..20001}: 20001 devices beside 0 others, expected at most limits.devices, 20000",
        "simulate.b-2: a second device has the address b-2"}) {
    EXPECT_THAT(errors.text(), HasSubstr(text));
  }
  EXPECT_THAT(errors.lines(), SizeIs(5));
}

TEST_F(Dummy, LivesLeavesAndComesBackAsScripted) {
  start();
  host.time.run_for(97s);
  EXPECT_THAT(host.all<model::KeepAlive>(), SizeIs(9));
  EXPECT_THAT(host.all<model::Leave>(), IsEmpty());
  host.time.run_for(2s);
  EXPECT_THAT(host.all<model::Leave>(), SizeIs(1));
  EXPECT_EQ(send(model::Sample{1, {}, 1s}).error().code, ErrorCode::kUnreachable);
  host.time.run_for(18s);
  EXPECT_THAT(host.all<model::KeepAlive>(), SizeIs(9));
  host.time.run_for(2s);
  EXPECT_THAT(host.all<model::Join>(), SizeIs(2));
}

TEST_F(Dummy, MeasuresNothingUntilAskedThenAtOnceAndEachPeriod) {
  start();
  host.time.run_for(30s);
  EXPECT_THAT(host.all<Updates>(), IsEmpty());
  ASSERT_TRUE(send(model::Sample{3, {sensor("temperature")}, 2s}));
  EXPECT_EQ(last_answer().request, 3u);
  EXPECT_EQ(last_answer().outcome, Outcome::kSent);
  EXPECT_THAT(values_of(sensor("temperature")), SizeIs(1));
  host.time.run_for(10s);
  EXPECT_THAT(values_of(sensor("temperature")), SizeIs(6));
  EXPECT_THAT(values_of(sensor("motion")), IsEmpty());
  ASSERT_TRUE(send(model::Sample{4, {}, 0ms}));
  host.time.run_for(10s);
  EXPECT_THAT(values_of(sensor("temperature")), SizeIs(6));
}

TEST_F(Dummy, GivesTheSameValuesForTheSameSeed) {
  std::vector<std::vector<Value>> runs;
  for (int run = 0; run < 2; ++run) {
    support::FakeHost fresh;
    const ConfigNode node = support::config_of(kRoom);
    ConfigReader reader(node, "", errors);
    auto made = kType.make({"dummy-1", IslandId{1}, reader, types, {}}, fresh);
    ASSERT_TRUE(made && (*made)->open());
    fresh.time.run_for(2s);
    Message message;
    message.destination.device = "kitchen";
    message.body = model::Sample{1, {sensor("temperature"), sensor("light")}, 1s};
    ASSERT_TRUE((*made)->send(message));
    fresh.time.run_for(60s);
    auto& values = runs.emplace_back();
    for (const auto& [device, updates] : fresh.all<Updates>()) {
      for (const auto& reading : updates.readings) values.push_back(reading.value);
    }
  }
  EXPECT_THAT(runs[0], SizeIs(122));
  EXPECT_EQ(runs[0], runs[1]);
}

TEST_F(Dummy, WavesStayBetweenTheirLevelsAndMoveThroughThem) {
  start();
  ASSERT_TRUE(send(model::Sample{1, {sensor("temperature"), sensor("motion"), sensor("contact")}, 1s}));
  host.time.run_for(60s);
  double lowest = 100, highest = 0;
  for (const auto& value : values_of(sensor("temperature"))) {
    lowest = std::min(lowest, std::get<double>(value));
    highest = std::max(highest, std::get<double>(value));
  }
  EXPECT_GE(lowest, 18.9);
  EXPECT_LE(lowest, 19.2);
  EXPECT_LE(highest, 23.1);
  EXPECT_GE(highest, 22.8);
  EXPECT_THAT(values_of(sensor("motion")), ::testing::IsSupersetOf({Value(true), Value(false)}));
  EXPECT_THAT(values_of(sensor("contact")), ::testing::IsSupersetOf({Value(true), Value(false)}));
}

TEST_F(Dummy, AnObedientActuatorReportsAfterItsDelayAndMovesItsSensor) {
  start();
  ASSERT_TRUE(send(model::Sample{1, {sensor("light")}, 1h}));
  ASSERT_TRUE(send(model::Actuate{2, actuator("switch"), true}));
  EXPECT_EQ(last_answer().request, 2u);
  host.time.run_for(199ms);
  EXPECT_THAT(values_of(actuator("switch")), IsEmpty());
  host.time.run_for(1ms);
  EXPECT_THAT(values_of(actuator("switch")), ElementsAre(Value(true)));
  EXPECT_EQ(values_of(sensor("light")).back(), Value(400.0));
}

TEST_F(Dummy, AnImpatientCommanderGetsTheLastCommandOnly) {
  start();
  ASSERT_TRUE(send(model::Actuate{1, actuator("switch"), true}));
  ASSERT_TRUE(send(model::Actuate{2, actuator("switch"), false}));
  host.time.run_for(1s);
  EXPECT_THAT(values_of(actuator("switch")), ElementsAre(Value(false)));
}

TEST_F(Dummy, OtherActuatorsKeepSilentIgnoreOrFail) {
  start();
  ASSERT_TRUE(send(model::Actuate{1, actuator("dimmer"), 50.0}));
  EXPECT_EQ(last_answer().outcome, Outcome::kSent);
  ASSERT_TRUE(send(model::Actuate{2, actuator("valve"), 50.0}));
  EXPECT_EQ(last_answer().outcome, Outcome::kSent);
  ASSERT_TRUE(send(model::Actuate{3, actuator("lock"), true}));
  EXPECT_EQ(last_answer().outcome, Outcome::kFailed);
  host.time.run_for(10s);
  EXPECT_THAT(host.all<Updates>(), IsEmpty());
}

TEST_F(Dummy, RefusesWhatItDoesNotHaveOrDo) {
  start();
  EXPECT_EQ(send(model::Sample{1, {sensor("humidity")}, 1s}).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(send(model::Actuate{1, actuator("fan"), true}).error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(send(model::Actuate{1, actuator("switch"), 3.5}));
  EXPECT_FALSE(send(model::Actuate{1, actuator("dimmer"), 101.0}));
  EXPECT_EQ(send(model::Sample{1, {}, 1s}, "cellar").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(send(model::Opaque{}).error().code, ErrorCode::kUnsupported);
}

TEST_F(Dummy, PropertiesAreKeptAndReported) {
  start();
  const model::PointId room{Kind::kProperty, types.find("room")->id, ""};
  ASSERT_TRUE(send(model::SetProperty{1, room, std::string("cellar")}));
  EXPECT_THAT(values_of(room), ElementsAre(Value(std::string("cellar"))));
}

TEST_F(Dummy, LosesItsLineAsScriptedAndGreetsWhenItIsBack) {
  start(R"({"line": {"down-at": "20s", "up-at": "25s"}, "simulate": {"kitchen": {"keepalive": "1s"}}})");
  host.time.run_for(17s);
  EXPECT_THAT(host.failures, IsEmpty());
  host.time.run_for(2s);
  EXPECT_THAT(host.failures, SizeIs(1));
  const auto lives = host.all<model::KeepAlive>().size();
  host.time.run_for(2s);
  EXPECT_EQ(host.all<model::KeepAlive>().size(), lives);
  EXPECT_FALSE(network->open());
  EXPECT_EQ(send(model::Sample{1, {}, 1s}).error().code, ErrorCode::kUnreachable);
  host.time.run_for(3s);
  ASSERT_TRUE(network->open());
  EXPECT_THAT(host.all<model::Join>(), SizeIs(2));
  EXPECT_THAT(host.all<model::State>(), SizeIs(2));
}

TEST_F(Dummy, ALineThatBeginsDownComesUpLater) {
  make(R"({"line": {"down-at": "0s", "up-at": "5s"}, "simulate": {"kitchen": {}}})");
  EXPECT_FALSE(network->open());
  host.time.run_for(6s);
  EXPECT_THAT(host.all<model::Join>(), IsEmpty());
  EXPECT_TRUE(network->open());
  EXPECT_THAT(host.all<model::Join>(), SizeIs(1));
}

TEST_F(Dummy, TellsAllThatIsWrongWithItsOptions) {
  make(R"({"colour": "red", "simulate": {"kitchen": {"leave": "5s", "join": "9s", "sensors": {
    "temperature": {}, "nothing-1": {}, "temprature-1": {}, "contact-1": {"wave": "steps", "values": ["ajar"]},
    "room-1": {"wave": "sine"}, "humidity-1": {"low": 50, "high": 40}, "battery-1": {"high": 200}},
    "actuators": {"switch-1": {"behaviour": "sulk", "sensor": "motion-1"}}, "properties": {"shoe": 42, "rate": "fast"}}}})");
  EXPECT_EQ(network, nullptr);
  for (const char* part :
       {"colour", "leave: is not after join", "sensors.temperature: expected a type and an instance",
        "unknown type 'nothing', expected", "unknown type 'temprature'; did you mean 'temperature'?", "ajar",
        "room-1.wave", "humidity-1.high: is below low", "battery-1.high", "sulk", "is not a sensor of this device",
        "properties.shoe: unknown type 'shoe', expected one that `rubicon types` lists", "properties.rate"}) {
    EXPECT_THAT(errors.text(), HasSubstr(part));
  }
}

}  // namespace
}  // namespace rubicon::networks::dummy
