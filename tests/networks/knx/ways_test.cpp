#include "networks/knx/bench.h"

namespace rubicon::networks::knx {
namespace {

using model::LineState;
using ::testing::ElementsAre;
using ::testing::SizeIs;

/// The whole network by TCP: what a tunnel over UDP does must be done there too.
class KnxByTcp : public KnxBench {
 protected:
  void SetUp() override {
    server.on_connect = [this](bool stream) { by_tcp = by_tcp && stream; };
    start(R"({"host": "10.0.0.9", "via": "tunnel-tcp", "telegrams-per-second": 0, "groups": {
      "1/0/1": {"dpt": "1.001", "kind": "actuator", "state": "1/0/2"}, "1/2/7": "9.001"},
      "expose": {"6/0/1": {"tuple": "proxy.den.1.sensor.temperature-1.value", "dpt": "9.001"}}})");
    ASSERT_EQ(last_state().line, model::LineState::kUp);
    ASSERT_EQ(server.counters.connects, 1U);
    ASSERT_TRUE(by_tcp);
  }
  bool by_tcp = true;
};

TEST_F(KnxByTcp, ReadsWhatIsWantedAndHearsTheBus) {
  server.answers[group("1/2/7")] = {{0x0c, 0x33}, false};
  ASSERT_TRUE(send(model::Sample{9, {point(Kind::kSensor, "temperature")}, 1s}, "1/2/7"));
  host.time.run_for(1s);
  EXPECT_EQ(reads_of("1/2/7"), 1);
  server.inject(0x1105, group("1/2/7"), 0x80, {0x0c, 0x65});
  host.time.run_for(1s);
  EXPECT_THAT(values_of("1/2/7"), ElementsAre("21.5", "22.5"));
}

TEST_F(KnxByTcp, CommandsAreSentAndReported) {
  server.on_heard = [this](const auto& heard) {
    if (heard.destination == group("1/0/1")) server.inject(0x1106, group("1/0/2"), 0x80, {1}, true);
  };
  ASSERT_TRUE(send(model::Actuate{5, point(Kind::kActuator, "switch"), Value(true)}, "1/0/1"));
  host.time.run_for(1s);
  EXPECT_EQ(telegrams("1/0/1", {0x00, 0x81}), 1);
  const auto answers = host.all<model::Acknowledge>();
  ASSERT_THAT(answers, SizeIs(1));
  EXPECT_EQ(answers[0].second.outcome, model::Outcome::kSent);
  EXPECT_THAT(values_of("1/0/1"), ElementsAre("on"));
}

TEST_F(KnxByTcp, ShowsWhatIsExposedAndAnswersForIt) {
  const auto& change = host.followed.at("proxy.den.1.sensor.temperature-1.value");
  change("21.5");
  host.time.run_for(1s);
  EXPECT_EQ(telegrams("6/0/1", {0x00, 0x80, 0x0c, 0x33}), 1);
  server.inject_read(0x1107, group("6/0/1"));
  host.time.run_for(1s);
  EXPECT_EQ(telegrams("6/0/1", {0x00, 0x40, 0x0c, 0x33}), 1);
}

TEST_F(KnxByTcp, ALostConnectionIsMadeAgainAndTheStateRead) {
  server.answers[group("1/2/7")] = {{0x0c, 0x33}, false};
  ASSERT_TRUE(send(model::Sample{9, {point(Kind::kSensor, "temperature")}, 1s}, "1/2/7"));
  host.time.run_for(1s);
  server.stop();
  host.time.run_for(1s);
  ASSERT_THAT(host.failures, SizeIs(1)) << "a closed connection shows at once";
  server.start();
  ASSERT_TRUE(network->open());
  host.time.run_for(2s);
  EXPECT_EQ(last_state().line, model::LineState::kUp);
  EXPECT_TRUE(by_tcp);
  EXPECT_EQ(reads_of("1/2/7"), 2);
}

}  // namespace
}  // namespace rubicon::networks::knx
