#include <gmock/gmock.h>

#include "recorder/recorded_islands.h"

namespace rubicon::recorder {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

const std::string kHome = R"yaml(
island: {id: 6541, name: home}
types:
  mood: {id: 0x8001, quantity: mood, data: enumeration, words: [glum, merry], report: event}
networks:
  dummy-1:
    type: dummy
    silence: never
    devices:
      1.4.6: {id: kitchen, name: "Küche ☕", sensors: {temperature-1: window}, actuators: {dimmer-1: bedside}}
      guest: {name: "Gästezimmer, \"hinten\""}
    simulate:
      1.4.6:
        model: simulated room
        sensors:
          temperature-1: {wave: sine, low: 19, high: 23, period: 60s, noise: 0.1}
          contact-1: {wave: steps, values: [closed, closed, open], period: 2s}
          pressure-1: {wave: constant, value: 100000}
          button-1: {wave: constant, value: press}
          mood-1: {wave: steps, values: [merry, glum], period: 3s}
        actuators:
          switch-1: {value: off, delay: 200ms}
          dimmer-1: {behaviour: silent}
        properties: {rate: 500, room: "Küche, Nord"}
      guest:
        leave: 10s
        rejoin: 15s
        sensors: {humidity-1: {wave: random, low: 30, high: 60}}
        properties: {rate: 1000}
      short:
        leave: 8s
        sensors: {co2-1: {wave: constant, value: 600}}
  log-flat:
    type: log
    format: csv
    file: flat.csv
    silence: never
    time: {column: t, unit: unix}
    map:
      hall: {name: Hall, columns: {a: {sensor: temperature-1}, b: {sensor: contact-door}}, properties: {room: {value: hall}}}
)yaml";
const std::string kRecorder = "recorders: {all: {file: home.rec, patterns: [\"proxy.**\"]}}\n";

std::string player(const std::string& more) {
  return R"yaml(
island: {id: 99, name: theatre}
types:
  mood: {id: 0x8001, quantity: mood, data: enumeration, words: [glum, merry], report: event}
networks:
  log-rooms: {type: log, as: dummy-1, network: dummy-1, file: home.rec, silence: never)yaml" +
         more + "}\n  log-b: {type: log, as: log-flat, network: log-flat, file: home.rec, silence: never" + more +
         "}\n";
}

class Replay : public testing::Test {
 protected:
  Replay() {
    disk.put("flat.csv", std::string_view("t,a,b\n1700000000,20.5,open\n1700000001,20.5,closed\n1700000005,21,open\n"));
  }

  /// Records the home for a while; its last picture and its history.
  void record(Duration span = 30s, const std::string& more = kRecorder) {
    TestIsland home(kHome + more, disk);
    home.run(3s);
    home.command("proxy.dummy-1.kitchen.property.rate.command", "250");
    home.command("proxy.dummy-1.kitchen.actuator.dimmer-bedside.command", "40");
    home.run(2s);
    home.command("proxy.dummy-1.kitchen.actuator.switch-1.command", "on");
    home.run(span);
    rooms = home.picture("dummy-1");
    flat = home.picture("log-flat");
    history = home.history();
    EXPECT_GT(rooms.size(), 15u);
  }

  transport::MemoryTransports disk;
  std::map<std::string, Seen> rooms, flat;
  std::map<std::string, std::vector<Seen>> history;
};

TEST_F(Replay, UnderTheRecordedNamesEverythingIsAsItWas) {
  record();
  TestIsland theatre(player(", speed: max"), disk, false);
  theatre.run(5s);
  EXPECT_THAT(theatre.picture("dummy-1"), testing::ContainerEq(rooms));
  EXPECT_THAT(theatre.picture("log-flat"), testing::ContainerEq(flat));
  EXPECT_EQ(rooms.at("proxy.dummy-1.kitchen.property.rate.value").value, "250");
  EXPECT_EQ(rooms.at("proxy.dummy-1.kitchen.sensor.pressure-1.value").value, "1e+05");
  EXPECT_EQ(rooms.at("proxy.dummy-1.kitchen.actuator.dimmer-bedside.value").user_time, WallTime{});
  EXPECT_THAT(rooms.at("proxy.dummy-1.kitchen.description").value, HasSubstr("Küche ☕"));
  EXPECT_THAT(rooms.at("proxy.dummy-1.kitchen.description").value, HasSubstr("1.4.6"));
  EXPECT_FALSE(rooms.contains("proxy.dummy-1.short.description"));
}

TEST_F(Replay, TellsEachSetOfAReadingInItsOrderEqualValuesToo) {
  record();
  TestIsland theatre(player(", speed: max"), disk, false);
  theatre.run(5s);
  std::size_t compared = 0;
  for (const auto& [key, values] : history) {
    if (key.find(".property.") != key.npos) continue;
    EXPECT_THAT(theatre.history().at(key), testing::ContainerEq(values)) << key;
    compared += values.size();
  }
  EXPECT_GT(compared, 100u);
  EXPECT_GT(history.at("proxy.dummy-1.kitchen.sensor.button-1.value").size(), 50u);
}

TEST_F(Replay, IsTheSameAtEverySpeed) {
  record();
  TestIsland theatre(player(", speed: 10"), disk, false);
  theatre.run(1s);
  EXPECT_NE(theatre.picture("dummy-1"), rooms);
  theatre.run(5s);
  EXPECT_THAT(theatre.picture("dummy-1"), testing::ContainerEq(rooms));
}

TEST_F(Replay, NeverExecutesACommand) {
  record();
  TestIsland theatre(player(", speed: max"), disk, false);
  std::vector<std::string> commands;
  const auto ears = theatre.island->space().subscribe({std::nullopt, "proxy.*.*.*.*.command"}, {{}, {}, 0, true},
                                                      [&](const tuples::Event& event) {
                                                        if (!event.tuple.value.empty())
                                                          commands.emplace_back(event.tuple.key);
                                                      });
  theatre.run(5s);
  EXPECT_THAT(commands, testing::IsEmpty());
  EXPECT_EQ(theatre.picture("dummy-1").at("proxy.dummy-1.kitchen.actuator.switch-1.value").value, "on");
}

TEST_F(Replay, ARecordingOfARecordingIsTheSame) {
  record();
  {
    TestIsland theatre(player(", speed: max") + "recorders: {again: {file: again.rec, patterns: [\"proxy.**\"]}}\n",
                       disk, false);
    theatre.run(5s);
  }
  disk.put("home.rec", disk.bytes("again.rec"));
  TestIsland second(player(", speed: max"), disk, false);
  second.run(5s);
  EXPECT_THAT(second.picture("dummy-1"), testing::ContainerEq(rooms));
  EXPECT_THAT(second.picture("log-flat"), testing::ContainerEq(flat));
}

TEST_F(Replay, OnRequestValuesGetTheTimeOfTheReplay) {
  record();
  TestIsland theatre(player(", speed: max, times: replay"), disk, false);
  theatre.run(5s);
  const auto now = theatre.time.wall_now();
  const auto user = theatre.picture("dummy-1").at("proxy.dummy-1.kitchen.sensor.temperature-window.value").user_time;
  EXPECT_GE(user, now - 6s);
}

TEST_F(Replay, TypesThatTheReplayingIslandDoesNotKnowKeepNameAndText) {
  record();
  auto yaml = player(", speed: max");
  yaml.replace(yaml.find("types:"), yaml.find("networks:") - yaml.find("types:"), "");
  TestIsland theatre(yaml, disk, false);
  theatre.run(5s);
  const auto now = theatre.picture("dummy-1");
  const std::string key = "proxy.dummy-1.kitchen.sensor.mood-1.";
  EXPECT_EQ(theatre.history().at(key + "value").back(), history.at(key + "value").back());
  EXPECT_THAT(now.at(key + "description").value, HasSubstr("\"type\":\"mood\",\"type_id\":32769"));
  EXPECT_EQ(now.at("proxy.dummy-1.kitchen.description"), rooms.at("proxy.dummy-1.kitchen.description"));
}

TEST_F(Replay, PlaysUnderItsOwnNameToo) {
  record();
  TestIsland theatre(
      "island: {id: 99, name: theatre}\nnetworks: {log-1: {type: log, network: dummy-1, file: home.rec, "
      "silence: never, speed: max}}\n",
      disk, false);
  theatre.run(5s);
  const auto now = theatre.picture("log-1");
  EXPECT_EQ(now.size(), rooms.size());
  EXPECT_EQ(now.at("proxy.log-1.kitchen.sensor.temperature-window.value"),
            rooms.at("proxy.dummy-1.kitchen.sensor.temperature-window.value"));
}

TEST_F(Replay, SeveralNetworksInARecordingAreNamedWhenNoneIsChosen) {
  record(2s);
  TestIsland theatre("island: {id: 99, name: theatre}\nnetworks: {log-1: {type: log, file: home.rec, speed: max}}\n",
                     disk, false);
  theatre.run(5s);
  EXPECT_TRUE(theatre.log.contains(
      "home.rec: the recording holds the networks dummy-1, log-flat; choose one with the option `network`"));
  EXPECT_TRUE(theatre.picture("log-1").empty());
}

TEST_F(Replay, TheOnlyNetworkOfARecordingNeedsNoName) {
  record(2s, "recorders: {rooms: {file: home.rec, patterns: [\"proxy.dummy-1.**\"]}}\n");
  TestIsland theatre(
      "island: {id: 99, name: theatre}\nnetworks: {log-1: {type: log, file: home.rec, silence: never, speed: max}}\n",
      disk, false);
  theatre.run(5s);
  EXPECT_EQ(theatre.picture("log-1").size(), rooms.size());
}

TEST_F(Replay, ValuesWithoutDescriptionsPlayAsWhatTheirKeysSay) {
  record(2s, "recorders: {values: {file: home.rec, patterns: [\"proxy.dummy-1.*.sensor.*.value\"]}}\n");
  TestIsland theatre(
      "island: {id: 99, name: theatre}\nnetworks: {log-1: {type: log, file: home.rec, silence: never, speed: max}}\n",
      disk, false);
  theatre.run(5s);
  const auto now = theatre.picture("log-1");
  EXPECT_EQ(now.at("proxy.log-1.kitchen.sensor.temperature-window.value"),
            rooms.at("proxy.dummy-1.kitchen.sensor.temperature-window.value"));
  EXPECT_FALSE(now.contains("proxy.log-1.kitchen.property.rate.value"));
}

TEST_F(Replay, ALoopEndsWhereTheRecordingDoesEachTime) {
  record(5s);
  TestIsland theatre(player(", speed: 1, loop: yes"), disk, false);
  const auto before = theatre.history().size();
  theatre.run(35s);
  EXPECT_GT(theatre.history().size(), before);
  const auto& first = history.at("proxy.dummy-1.kitchen.sensor.button-1.value");
  EXPECT_GT(theatre.history().at("proxy.dummy-1.kitchen.sensor.button-1.value").size(), 2 * first.size());
}

TEST_F(Replay, DevicesOfTheSessionBeforeLeaveWhenTheRecordedIslandStartsAgain) {
  record(5s);
  {
    TestIsland home(
        "island: {id: 6541, name: home}\nnetworks: {dummy-1: {type: dummy, silence: never, simulate: {attic: "
        "{sensors: {temperature-1: {}}}}}}\n" +
            kRecorder,
        disk);
    home.run(5s);
    rooms = home.picture("dummy-1");
  }
  TestIsland theatre(player(", speed: max"), disk, false);
  theatre.run(5s);
  EXPECT_THAT(theatre.picture("dummy-1"), testing::ContainerEq(rooms));
}

TEST_F(Replay, ADamagedBlockCostsOnlyItself) {
  record();
  auto bytes = disk.bytes("home.rec");
  bytes[bytes.size() * 9 / 10] ^= 0x10U;
  disk.put("home.rec", bytes);
  TestIsland theatre(player(", speed: max"), disk, false);
  theatre.run(5s);
  EXPECT_THAT(theatre.picture("dummy-1"), testing::ContainerEq(rooms));
  EXPECT_TRUE(theatre.log.contains("bytes skipped"));
}

TEST_F(Replay, StartPassesOverReadingsButNotOverWhatDevicesAre) {
  record(30s);
  TestIsland theatre(player(", start: 33s"), disk, false);
  theatre.time.run_ready();
  theatre.run(10ms);
  auto now = theatre.picture("dummy-1");
  EXPECT_EQ(now.at("proxy.dummy-1.kitchen.description"), rooms.at("proxy.dummy-1.kitchen.description"));
  EXPECT_EQ(now.at("proxy.dummy-1.kitchen.property.rate.value").value, "250");
  EXPECT_FALSE(now.contains("proxy.dummy-1.short.description"));
}

}  // namespace
}  // namespace rubicon::recorder
