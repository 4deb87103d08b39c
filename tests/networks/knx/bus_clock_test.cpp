#include "networks/knx/exposures.h"

#include <cstdlib>
#include <ctime>
#include <optional>

#include "networks/knx/bench.h"

namespace rubicon::networks::knx {
namespace {

using ::testing::HasSubstr;

/// In Berlin.
class BusClock : public KnxBench {
 protected:
  BusClock() {
    if (const auto* zone = std::getenv("TZ")) before_ = zone;
    ::setenv("TZ", "Europe/Berlin", 1);
    ::tzset();
  }
  ~BusClock() override {
    before_ ? ::setenv("TZ", before_->c_str(), 1) : ::unsetenv("TZ");
    ::tzset();
  }
  static WallTime utc(int month, int day, int hour, int minute = 0, int second = 0) {
    return WallTime(std::chrono::sys_days(std::chrono::year(2026) / month / day)) + std::chrono::hours(hour) +
           std::chrono::minutes(minute) + std::chrono::seconds(second);
  }
  static std::string shown(dpt::DptId id, WallTime now, ClockZone zone = ClockZone::kLocal, bool synchronised = true) {
    const auto payload = clock_payload(id, zone, now, synchronised);
    return payload ? base::to_hex(payload->bytes) : payload.error().text;
  }
  int times(const std::string& address) const {
    int count = 0;
    for (const auto& one : server.heard()) count += one.destination == group(address) ? 1 : 0;
    return count;
  }

 private:
  std::optional<std::string> before_;
};

constexpr dpt::DptId kTime{10, 1}, kDate{11, 1}, kBoth{19, 1};

// Octets as KNX 3/7/2 describes them; 2026-07-03 is a Friday, 2026-12-31 a Thursday.
TEST_F(BusClock, ShowsLocalTimeWithDaylightSaving) {
  EXPECT_EQ(shown(kTime, utc(7, 3, 10, 30, 15)), "ac1e0f");  // Fri 12:30:15
  EXPECT_EQ(shown(kDate, utc(7, 3, 10)), "03071a");
  EXPECT_EQ(shown(kBoth, utc(7, 3, 10, 30, 15)), "7e0703ac1e0f2180");  // SUTI; CLQ
  EXPECT_EQ(shown(kTime, utc(12, 31, 23, 30)), "a01e00") << "Friday there";
  EXPECT_EQ(shown(kDate, utc(12, 31, 23, 30)), "01011b");
  EXPECT_EQ(shown(kTime, utc(12, 31, 23, 30), ClockZone::kUtc), "971e00");
}

TEST_F(BusClock, SaysWhetherItIsSetFromOutside) {
  EXPECT_EQ(shown(kBoth, utc(1, 5, 10), ClockZone::kLocal, true), "7e01052b00002080");
  EXPECT_EQ(shown(kBoth, utc(1, 5, 10), ClockZone::kLocal, false), "7e01052b00002000");
}

TEST_F(BusClock, ThatWasNeverSetIsNotShown) {
  EXPECT_THAT(shown(kTime, WallTime(std::chrono::hours(5))), HasSubstr("1970-01-01 05:00: it was never set"));
}

constexpr const char* kClocks = R"({"host": "10.0.0.9", "telegrams-per-second": 0, "expose": {
  "0/7/1": {"clock": "local", "dpt": "10.001", "every": "10min"}, "0/7/2": {"clock": "local", "dpt": "11.001", "every": "never"}}})";

TEST_F(BusClock, IsToldAtTheStartCyclicallyAndWhenItIsAsked) {
  host.time.set_wall(utc(7, 3, 10, 30));
  start(kClocks);
  EXPECT_EQ(times("0/7/1"), 1);
  EXPECT_EQ(times("0/7/2"), 1);
  host.time.run_for(30min);
  EXPECT_EQ(times("0/7/1"), 4);
  EXPECT_EQ(times("0/7/2"), 1) << "never again on the same day";
  server.inject(0x1105, group("0/7/1"), 0x00, {});
  host.time.run_for(1s);
  EXPECT_EQ(times("0/7/1"), 5);
  EXPECT_EQ(server.heard().back().tpdu, (Bytes{0x00, 0x40, 0xad, 0x00, 0x01})) << "Fri 13:00:01, as it is now";
}

TEST_F(BusClock, IsToldAtOnceWhenTheDayTheOffsetOrTheClockOfTheHostChanges) {
  host.time.set_wall(utc(3, 28, 22, 58));  // 23:58 local
  start(kClocks);
  host.time.run_for(3min);
  EXPECT_EQ(times("0/7/2"), 2) << "midnight";
  host.time.run_for(2h);  // 02:00 becomes 03:00
  const auto before = times("0/7/2");
  EXPECT_EQ(before, 3) << "daylight saving time";
  host.time.set_wall(host.time.wall_now() + 90s);
  host.time.run_for(61s);
  EXPECT_EQ(times("0/7/2"), 4) << "the clock of the host was set";
  host.time.run_for(5h);
  EXPECT_EQ(times("0/7/2"), 4);
}

TEST_F(BusClock, IsNotSentWhileItWasNeverSetNorWhereOnlyReadsAreAnswered) {
  host.time.set_wall(WallTime(std::chrono::hours(5)));
  start(kClocks);
  host.time.run_for(2min);
  EXPECT_EQ(times("0/7/1"), 0);
  host.time.set_wall(utc(7, 3, 10, 30));
  host.time.run_for(61s);
  EXPECT_EQ(times("0/7/1"), 1) << "as soon as it is set";
  ASSERT_TRUE(change(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "expose": {
    "0/7/3": {"clock": "local", "dpt": "10.001", "on-change": "no", "every": "never"}}})"));
  host.time.run_for(48h);
  EXPECT_EQ(times("0/7/3"), 0);
  server.inject(0x1105, group("0/7/3"), 0x00, {});
  host.time.run_for(1s);
  EXPECT_EQ(times("0/7/3"), 1);
}

class ExposedEvents : public KnxBench {};

TEST_F(ExposedEvents, AreWrittenThoughTheyAreOverBeforeTheirTurn) {
  start(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "expose": {
    "0/7/1": {"tuple": "proxy.zigbee.hall.sensor.blindStep-1.value", "dpt": "1.008"}}})");
  const auto set = [this](std::string_view text) {
    host.followed.at("proxy.zigbee.hall.sensor.blindStep-1.value")(text);
  };
  set("down");
  host.time.run_for(1s);
  EXPECT_EQ(telegrams("0/7/1", {0x00, 0x81}), 1);
  set("up");
  host.time.run_for(2s);
  set("");  // it is over, and the pause of 5 s is not
  host.time.run_for(3s);
  EXPECT_EQ(telegrams("0/7/1", {0x00, 0x80}), 1);
  host.time.run_for(1h);
  EXPECT_EQ(telegrams("0/7/1", {0x00, 0x80}), 1);
  server.inject(0x1105, group("0/7/1"), 0x00, {});
  host.time.run_for(1s);
  EXPECT_EQ(telegrams("0/7/1", {0x00, 0x40}), 0) << "no event is there to answer with";
}

TEST_F(ExposedEvents, ThatAreOverAreNotWrittenAfterTheLineWasLost) {
  start(R"({"host": "10.0.0.9", "telegrams-per-second": 0, "expose": {
    "0/7/1": {"tuple": "proxy.zigbee.hall.sensor.blindStep-1.value", "dpt": "1.008"}}})");
  const auto set = [this](std::string_view text) {
    host.followed.at("proxy.zigbee.hall.sensor.blindStep-1.value")(text);
  };
  set("down");
  host.time.run_for(1s);
  set("up");
  set("");
  server.disconnect_all();
  host.time.run_for(1s);
  ASSERT_TRUE(network->open());
  host.time.run_for(20s);
  EXPECT_EQ(telegrams("0/7/1", {0x00, 0x81}), 1);
  EXPECT_EQ(telegrams("0/7/1", {0x00, 0x80}), 0) << "a blind must not move long after the button";
}

TEST_F(BusClock, MistakesAreNamed) {
  const ConfigNode node = support::config_of(std::string_view(R"({"host": "10.0.0.9", "expose": {
    "0/7/1": {"clock": "local", "dpt": "9.001"}, "0/7/2": {"clock": "local", "tuple": "a.b", "dpt": "10.001"}, "0/7/3": {"dpt": "10.001"}}})"));
  ConfigReader reader(node, "networks.knx", errors);
  std::ignore = kType.make({"knx", IslandId{1}, reader, types, {}}, host);
  EXPECT_THAT(errors.text(),
              HasSubstr("expose.0/7/1.dpt: is 9.001, expected the type of a clock: 10.001, 11.001 or 19.001"));
  EXPECT_THAT(errors.text(), HasSubstr("expose.0/7/2.clock: expected 'clock' or 'tuple', not both"));
  EXPECT_THAT(errors.text(), HasSubstr("'tuple' is missing, expected the key of a tuple; or 'clock'"));
}

}  // namespace
}  // namespace rubicon::networks::knx
