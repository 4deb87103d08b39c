#include "networks/knx/bench.h"

namespace rubicon::networks::knx {
namespace {

using model::LineState;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::string_view kTwo = R"({"host": ["10.0.0.9", "10.0.0.10"], "telegrams-per-second": 0,
  "gateway-check": "1min", "groups": {
    "1/0/1": {"dpt": "1.001", "kind": "actuator"}, "1/2/7": "9.001"}})";

/// Two interfaces of one bus: `server` at 10.0.0.9, which is preferred, and `second`.
class KnxGateways : public KnxBench {
 protected:
  KnxGateways() {
    support::KnxServer::Options options;
    options.at = {"10.0.0.10", 3671};
    second = std::make_unique<support::KnxServer>(host.time, host.net, options);
    // As on a bus, what one of them sends is heard by the other.
    server.on_heard = [this](const auto& one) { forward(one, server, *second); };
    second->on_heard = [this](const auto& one) { forward(one, *second, server); };
  }
  void forward(const support::KnxServer::Heard& one, const support::KnxServer& from, support::KnxServer& to) {
    ++on_bus[one.tpdu];
    if (&from == second.get() || !echoes) return;
    to.inject(0x11c8, one.destination, 0x80, {1}, true);
  }
  /// What a supervisor does after a loss.
  void supervise(Duration time) {
    for (const auto end = host.time.now() + time; host.time.now() < end;) {
      if (host.failures.size() != answered) {
        answered = host.failures.size();
        std::ignore = network->open();
      }
      host.time.run_for(100ms);
    }
  }
  void bus(double celsius) {
    const auto byte = static_cast<std::uint8_t>(celsius * 2);
    for (auto* one : {&server, second.get()}) one->inject(0x1105, group("1/2/7"), 0x80, {0x0c, byte});
  }
  std::string used() const { return last_state().texts.at("gateway"); }
  bool is_up() const { return last_state().line == LineState::kUp; }

  std::unique_ptr<support::KnxServer> second;
  std::map<Bytes, int> on_bus;
  bool echoes = false;
  std::size_t answered = 0;
};

TEST_F(KnxGateways, TheFirstIsUsedWhileItIsThere) {
  start(kTwo);
  supervise(10min);
  EXPECT_TRUE(is_up());
  EXPECT_EQ(used(), "10.0.0.9 (preferred)");
  EXPECT_EQ(second->counters.connects, 0U);
  EXPECT_EQ(last_state().reason, "");
}

TEST_F(KnxGateways, TheSecondFollowsWhenTheFirstDoesNotAnswer) {
  server.stop();
  start(kTwo);
  supervise(30s);
  ASSERT_TRUE(is_up());
  EXPECT_EQ(used(), "10.0.0.10 (instead of 10.0.0.9)");
  EXPECT_THAT(last_state().reason, HasSubstr("10.0.0.9"));
  ASSERT_TRUE(send(model::Actuate{5, point(Kind::kActuator, "switch"), true}, "1/0/1"));
  supervise(1s);
  EXPECT_THAT(second->heard(), SizeIs(1));
}

TEST_F(KnxGateways, TheSecondFollowsAtOnceWhenTheFirstRefuses) {
  server.connect_status = 0x24;
  start(kTwo);
  ASSERT_TRUE(is_up());
  EXPECT_THAT(last_state().reason, HasSubstr("status 24"));
  EXPECT_THAT(host.failures, IsEmpty());
}

TEST_F(KnxGateways, TheSecondFollowsWhenTheFirstRefusesForItsBus) {
  server.connect_status = 0x27;
  start(kTwo);
  ASSERT_TRUE(is_up());
  EXPECT_EQ(used(), "10.0.0.10 (instead of 10.0.0.9)");
  EXPECT_THAT(last_state().reason, HasSubstr("no connection to the KNX bus"));
  EXPECT_EQ(last_state().texts.at("bus"), "ok");
}

TEST_F(KnxGateways, WhenAllRefuseTheLinePausesAndSaysWhy) {
  server.connect_status = second->connect_status = 0x24;
  start(kTwo);
  supervise(10s);
  EXPECT_EQ(last_state().line, LineState::kRefused);
  EXPECT_THAT(last_state().reason, testing::AllOf(HasSubstr("10.0.0.9: "), HasSubstr("10.0.0.10: ")));
  EXPECT_GE(server.counters.connects, 2U);
  EXPECT_GE(second->counters.connects, 2U);
  server.connect_status = 0;
  supervise(2min);
  EXPECT_EQ(used(), "10.0.0.9 (preferred)");
}

TEST_F(KnxGateways, ATelegramThatWaitedGoesToTheSecondOnce) {
  start(kTwo);
  server.stop();
  ASSERT_TRUE(send(model::Actuate{5, point(Kind::kActuator, "switch"), true, 60s}, "1/0/1"));
  supervise(30s);
  ASSERT_TRUE(is_up());
  EXPECT_EQ(used(), "10.0.0.10 (instead of 10.0.0.9)");
  EXPECT_THAT(second->heard(), SizeIs(1));
}

TEST_F(KnxGateways, TheLineReturnsWhenThePreferredOneIsBackAndLosesNothing) {
  server.stop();
  start(kTwo);
  supervise(30s);
  ASSERT_EQ(used(), "10.0.0.10 (instead of 10.0.0.9)");
  server.start();
  std::size_t sent = 0;
  for (; sent < 100; ++sent) {
    bus(10 + static_cast<double>(sent) / 2);
    supervise(1s);
  }
  supervise(2s);
  EXPECT_EQ(used(), "10.0.0.9 (preferred)");
  EXPECT_EQ(last_state().reason, "");
  EXPECT_EQ(last_state().counters.at("gateway-changes"), 1U);
  EXPECT_THAT(host.failures, SizeIs(answered)) << "the line was not lost";
  EXPECT_THAT(values_of("1/2/7"), SizeIs(sent)) << "each telegram of the bus once";
  EXPECT_EQ(second->counters.connects, 1U);
  EXPECT_EQ(last_state().counters.at("telegrams-received"), sent);
}

TEST_F(KnxGateways, BothTunnelsAreOpenForAMomentAndNothingCountsTwice) {
  server.stop();
  start(kTwo);
  supervise(30s);
  server.start();
  const auto before = server.counters.connects;
  for (int i = 0; i < 3000 && server.counters.connects == before; ++i) supervise(100ms);
  host.time.run_for(10ms);
  ASSERT_EQ(used(), "10.0.0.9 (preferred)");
  bus(21);
  echoes = true;
  ASSERT_TRUE(send(model::Actuate{5, point(Kind::kActuator, "switch"), true}, "1/0/1"));
  host.time.run_for(200ms);
  EXPECT_THAT(values_of("1/2/7"), SizeIs(1));
  EXPECT_THAT(values_of("1/0/1"), IsEmpty()) << "what we sent by one is no report of the other";
  EXPECT_EQ(telegrams("1/0/1", {0x00, 0x81}), 1);
  bus(22);
  bus(22);
  second->inject(0x1105, group("1/2/7"), 0x80, {0x0c, 44});  // the same, which the preferred one misses
  for (int i = 0; i < 2; ++i) server.inject(0x1105, group("1/2/7"), 0x80, {0x0c, 46});  // and two that the other misses
  host.time.run_for(5s);
  EXPECT_THAT(values_of("1/2/7"), SizeIs(6)) << "equal telegrams are several";
}

TEST_F(KnxGateways, ThePreferredOneIsNotTakenBeforeItGivesATunnel) {
  server.stop();
  start(kTwo);
  supervise(30s);
  server.connect_status = 0x24;
  server.start();
  supervise(3min);
  EXPECT_EQ(used(), "10.0.0.10 (instead of 10.0.0.9)");
  EXPECT_TRUE(is_up());
  EXPECT_GE(server.counters.connects, 2U);
  bus(21);
  supervise(1s);
  EXPECT_THAT(values_of("1/2/7"), SizeIs(1));
  server.connect_status = 0;
  supervise(90s);
  EXPECT_EQ(used(), "10.0.0.9 (preferred)");
}

TEST_F(KnxGateways, AfterALossThePreferredOneIsTriedFirst) {
  start(kTwo);
  server.disconnect_all();
  supervise(30s);
  EXPECT_EQ(used(), "10.0.0.9 (preferred)");
  EXPECT_EQ(second->counters.connects, 0U);
  EXPECT_EQ(last_state().counters.at("gateway-changes"), 0U);
}

TEST_F(KnxGateways, WithoutACheckTheSecondStays) {
  server.stop();
  start(R"({"host": ["10.0.0.9", "10.0.0.10"], "gateway-check": "never"})");
  supervise(30s);
  server.start();
  supervise(30min);
  EXPECT_EQ(used(), "10.0.0.10 (instead of 10.0.0.9)");
  second->disconnect_all();
  supervise(30s);
  EXPECT_EQ(used(), "10.0.0.9 (preferred)") << "each loss begins with the first";
}

TEST_F(KnxGateways, WrongListsAreNamed) {
  const auto errors_of = [&](std::string_view options) {
    ConfigErrors found;
    const ConfigNode node = support::config_of(options);
    ConfigReader reader(node, "networks.knx", found);
    EXPECT_FALSE(kType.make({"knx", IslandId{1}, reader, types, {}}, host)) << options;
    return found.text();
  };
  EXPECT_THAT(errors_of(R"({"host": []})"), HasSubstr("networks.knx.host: is an empty list"));
  EXPECT_THAT(errors_of(R"({"host": ["a.b", "A.b"]})"), HasSubstr("networks.knx.host: names 'A.b' twice"));
  EXPECT_THAT(errors_of(R"({"host": ["a", "b"], "tunnel-address": "1.1.5"})"),
              HasSubstr("networks.knx.tunnel-address"));
  EXPECT_THAT(errors_of(R"({"host": "a", "gateway-check": "1min"})"), HasSubstr("without a second host"));
  EXPECT_THAT(errors_of(R"({"host": ["a", "b"], "gateway-check": "1s"})"), HasSubstr("expected at least 10s"));
}

}  // namespace
}  // namespace rubicon::networks::knx
