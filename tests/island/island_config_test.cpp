#include "island/island_config.h"
#include "config/config_file.h"
#include "tuples/memory/memory_ecology.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/virtual_scheduler.h"
#include "config/yaml.h"
#include "island/island.h"
#include "island/network_types.h"
#include "networks/salad/salad_options.h"
#include "support/memory/memory_transports.h"
#include "transport/local_transports.h"

namespace rubicon::island {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

/// Reads a configuration, with overrides, up to the keys of the plug-ins.
class IslandConfigs : public testing::Test {
 protected:
  island::IslandConfig read(std::string_view text, const std::vector<std::string>& overrides = {}) {
    auto tree = config::parse_yaml(text, "x.yaml");
    EXPECT_TRUE(tree) << tree.error().text;
    if (!tree) return {};
    for (const auto& assignment : overrides) {
      const auto applied = config::apply_override(*tree, assignment);
      EXPECT_TRUE(applied) << applied.error().text;
    }
    errors_ = {};
    return island::read_island_config(*tree, network_types(), errors_);
  }
  /// Same, and the networks are made, as `check` does.
  std::vector<std::string> all_errors(std::string_view text, const std::vector<std::string>& overrides = {}) {
    auto config = read(text, overrides);
    VirtualScheduler time;
    transport::MemoryTransports files;
    base::NullLogSink log;
    tuples::MemoryEcology ecology(time);
    const auto made = Island::make(std::move(config), time, files, log, ecology, errors_);
    EXPECT_EQ(made.has_value(), errors_.empty());
    return errors_.lines();
  }

  base::ConfigErrors errors_;
};

using IslandConfigTest = IslandConfigs;

constexpr std::string_view kHead = "island: {id: 6541, name: home}\n";

std::string with_network(std::string_view network) {
  return std::string(kHead) + "networks:\n  " + std::string(network) + "\n";
}

TEST_F(IslandConfigTest, HasTheDefaultsOfTheManual) {
  const auto config = read(with_network("dummy: {type: dummy}"));
  EXPECT_THAT(errors_.lines(), IsEmpty());
  EXPECT_EQ(number(config.id), 6541U);
  EXPECT_EQ(config.proxy.prefix, "proxy");
  EXPECT_EQ(config.proxy.command_time_to_live, 5s);
  EXPECT_EQ(config.proxy.confirmation_wait, 5s);
  EXPECT_EQ(config.proxy.queue_expiry, 24h);
  EXPECT_EQ(config.limits.queue, 10000U);
  EXPECT_EQ(config.limits.devices, 20000U);
  EXPECT_EQ(config.proxy.networks.at("dummy").silence, Duration(60s));
  EXPECT_EQ(config.proxy.networks.at("dummy").rate, 1s);
}

TEST_F(IslandConfigTest, ReadsEveryCommonKey) {
  const auto config = read(
      "island: {id: 1, name: lab, prefix: lab}\n"
      "tuples: {engine: memory}\n"
      "discovery: {new-devices: auto}\n"
      "limits: {queue: 10, devices: 20}\n"
      "commands: {time-to-live: 1s, confirmation-wait: 2s, queue-expiry: 3min}\n"
      "types:\n"
      "  mood: {id: 0x8001, quantity: mood, data: enumeration, words: [bad, good], report: event}\n"
      "networks:\n"
      "  dummy-hall:\n"
      "    type: dummy\n"
      "    silence: never\n"
      "    rate: 250ms\n"
      "    devices: {1.4.6: {id: kitchen, name: Küche, sensors: {light-1: window}, actuators: {lamp-1: top}}}\n");
  EXPECT_THAT(errors_.lines(), IsEmpty());
  EXPECT_EQ(config.proxy.prefix, "lab");
  EXPECT_EQ(config.limits.queue, 10U);
  EXPECT_EQ(config.proxy.max_devices, 20U);
  EXPECT_EQ(config.proxy.queue_expiry, 3min);
  EXPECT_EQ(config.types.find("mood")->report, model::Report::kEvent);
  EXPECT_EQ(config.types.find("mood")->words, "bad,good");
  const auto& rules = config.proxy.networks.at("dummy-hall");
  EXPECT_EQ(rules.silence, std::nullopt);
  EXPECT_EQ(rules.rate, 250ms);
  const auto& names = rules.devices.at("1.4.6");
  EXPECT_EQ(names.id, "kitchen");
  EXPECT_EQ(names.name, "Küche");
  EXPECT_EQ(names.sensors.at("light-1"), "window");
  EXPECT_EQ(names.actuators.at("lamp-1"), "top");
}

TEST_F(IslandConfigTest, NamesGivenToFormerTypesHoldForThoseOfToday) {
  const auto config = read(
      with_network("dummy: {type: dummy, devices: {1: {sensors: {illuminance-1: window, pir-2: hall, motion-1: x}}}}"));
  EXPECT_THAT(errors_.lines(), IsEmpty());
  const auto& names = config.proxy.networks.at("dummy").devices.at("1").sensors;
  EXPECT_EQ(names,
            (std::map<std::string, std::string>{{"light-1", "window"}, {"motion-1", "x"}, {"motion-2", "hall"}}));
  read(with_network("dummy: {type: dummy, devices: {1: {sensors: {illuminance-1: a, light-1: b}}}}"));
  EXPECT_THAT(errors_.lines(), Contains(HasSubstr("sensors.light-1: light-1 has a name already")));
}

TEST_F(IslandConfigTest, ARecorderOfAFormerTypeRecordsThatOfTodayToo) {
  const auto config =
      read("island: {id: 1}\nrecorders: {lux: {file: a.rec, patterns: [\"proxy.*.*.sensor.illuminance-1.value\"]}}\n");
  EXPECT_THAT(errors_.lines(), IsEmpty());
  std::vector<std::string> patterns;
  for (const auto& pattern : config.recorders.at(0).patterns) patterns.push_back(to_string(pattern));
  EXPECT_THAT(patterns,
              testing::UnorderedElementsAre("proxy.*.*.sensor.illuminance-1.value", "proxy.*.*.sensor.light-1.value"));
}

TEST_F(IslandConfigTest, TellsAllThatIsWrongAtOnceWithTheirPlaces) {
  const auto errors = all_errors(
      "island: {id: 70000, name: home, colour: red}\n"
      "tuples: {engine: zenoh}\n"
      "limits:\n"
      "  queue: many\n"
      "networks:\n"
      "  dummy-1:\n"
      "    type: dummy\n"
      "    silence: 60\n"
      "    sede: 7\n"
      "  bacnet-1: {type: bacnet}\n"
      "surprise: 1\n");
  EXPECT_THAT(errors, SizeIs(8));
  EXPECT_THAT(errors, Contains("x.yaml:1:14: island.id: is '70000', expected a whole number from 1 to 65532"));
  EXPECT_THAT(errors, Contains(StartsWith("x.yaml:1:33: island: unknown key 'colour', known: id, name, prefix")));
  EXPECT_THAT(errors, Contains(StartsWith("x.yaml:2:18: tuples.engine: is 'zenoh', expected one of: memory, host")));
  EXPECT_THAT(errors, Contains(HasSubstr("x.yaml:4:10: limits.queue: is 'many', expected a whole number")));
  EXPECT_THAT(errors, Contains(HasSubstr("x.yaml:8:14: networks.dummy-1.silence: is '60', expected a duration")));
  EXPECT_THAT(errors,
              Contains(HasSubstr("x.yaml:10:20: networks.bacnet-1.type: is 'bacnet', expected one of: dummy, log")));
  EXPECT_THAT(errors, Contains(HasSubstr("x.yaml:11:1: unknown key 'surprise'")));
  EXPECT_THAT(errors,
              Contains(StartsWith("x.yaml:9:5: networks.dummy-1: unknown key 'sede'; did you mean 'seed'? known: ")));
}

TEST_F(IslandConfigTest, AWrongCommonKeyNamesTheRightOneAndTheListHoldsAllOfThem) {
  const auto errors = all_errors(with_network("dummy-1: {type: dummy, silnce: 30s, seed: 7}"));
  ASSERT_THAT(errors, SizeIs(1));
  EXPECT_EQ(
      errors[0],
      "x.yaml:3:26: networks.dummy-1: unknown key 'silnce'; did you mean 'silence'? known: as, devices, line, rate, "
      "roaming, sampling-rate, seed, silence, simulate, type, valid");
}

TEST_F(IslandConfigTest, AListOfNetworksIsNumberedByType) {
  const auto config = read(
      "island: {id: 1}\nnetworks:\n  - {type: wsn}\n  - {type: dummy, silence: 7s}\n  - {type: wsn, silence: 9s}\n",
      {"networks.wsn-2.rate=20ms"});
  EXPECT_THAT(errors_.lines(), IsEmpty());
  ASSERT_THAT(config.networks, SizeIs(3));
  EXPECT_EQ(config.networks[0].id, "wsn-1");
  EXPECT_EQ(config.networks[1].id, "dummy-1") << "a single one too";
  EXPECT_EQ(config.networks[2].id, "wsn-2");
  EXPECT_EQ(config.proxy.networks.at("wsn-2").silence, Duration(9s));
  EXPECT_EQ(config.proxy.networks.at("dummy-1").silence, Duration(7s));
}

TEST_F(IslandConfigTest, WhatIsWrongInAListOfNetworksHasItsPlace) {
  const auto errors = all_errors(
      "island: {id: 1}\nnetworks:\n  - {type: dummy, sede: 7}\n  - {silence: 5s}\n  - text\n  - {type: bacnet}\n");
  EXPECT_THAT(errors, Contains(StartsWith("x.yaml:3:19: networks.dummy-1: unknown key 'sede'; did you mean 'seed'?")));
  EXPECT_THAT(errors,
              Contains(StartsWith("x.yaml:4:5: networks.network-2: 'type' is missing, expected one of: dummy, ")));
  EXPECT_THAT(errors, Contains("x.yaml:5:5: networks.network-3: is a value, expected a map"));
  EXPECT_THAT(errors, Contains(HasSubstr("networks.bacnet-1.type: is 'bacnet', expected one of: dummy, log")));
  const auto typed = all_errors("island: {id: 1}\nwbe: {port: 80}\nhistroy: {file: x}\nnetworks: {knx: {type: kmx}}\n");
  for (const auto* text :
       {"'wbe'; did you mean 'web'?", "'histroy'; did you mean 'history'?", "'kmx'; did you mean 'knx'?"})
    EXPECT_THAT(typed, Contains(HasSubstr(text)));
}

TEST_F(IslandConfigTest, AnIslandKeepsOfItsOptionsOnlyWhatAReloadCompares) {
  const auto text = with_network("dummy-1: {type: dummy, seed: 7, simulate: {hall: {sensors: {temperature-1: {}}}}}");
  auto config = read(text);
  const auto before = config.networks[0];
  VirtualScheduler time;
  transport::MemoryTransports files;
  base::NullLogSink log;
  tuples::MemoryEcology ecology(time);
  const auto made = Island::make(std::move(config), time, files, log, ecology, errors_);
  ASSERT_TRUE(made) << errors_.text();
  const auto& kept = (*made)->config().networks[0];
  EXPECT_TRUE(kept.options.entries.empty());
  EXPECT_LT(kept.kept.size(), text.size());
  EXPECT_THAT(island::differences(kept, before, 9), IsEmpty());
  EXPECT_THAT(island::differences(kept, read(text, {"networks.dummy-1.seed=8"}).networks[0], 9),
              testing::ElementsAre("seed"));
}

TEST_F(IslandConfigTest, ATableNeedsItsFormat) {
  const auto errors = all_errors(
      with_network("log: {type: log, file: nowhere.csv, period: 1s, map: {a: {columns: {b: {sensor: light-1}}}}}"));
  EXPECT_THAT(errors, testing::ElementsAre(
                          "x.yaml:3:8: networks.log: 'format' is missing, expected csv (only tables have map, period), "
                          "packets or recording"));
  EXPECT_THAT(all_errors(with_network("log: {type: log, file: day.csv}")),
              Contains(HasSubstr("expected csv (the file is day.csv), packets or recording")));
  EXPECT_THAT(all_errors(with_network("log: {type: log, file: day.csv, format: packets}")), IsEmpty());
}

TEST_F(IslandConfigTest, WantsAnIslandWithAnId) {
  EXPECT_THAT(all_errors("networks:\n"), Contains(HasSubstr("'island' is missing")));
  EXPECT_THAT(all_errors("island: {name: home}\n"), Contains("x.yaml:1:9: island: 'id' is missing, expected 1..65532"));
  EXPECT_THAT(all_errors("island: home\n"), Contains(HasSubstr("x.yaml:1:9: island: is a value, expected a map")));
  EXPECT_THAT(all_errors("island: {id: 1, prefix: a.b}\n"),
              Contains(HasSubstr("island.prefix: expected one key part")));
}

TEST_F(IslandConfigs, ARecordingPlaysUnderAnotherNetworksId) {
  const auto config = read("island: {id: 1}\nnetworks: {log-1: {type: log, as: wsn-1, file: a.rec, silence: never}}\n");
  EXPECT_THAT(errors_.lines(), IsEmpty());
  ASSERT_THAT(config.networks, SizeIs(1));
  EXPECT_EQ(config.networks[0].id, "wsn-1");
  EXPECT_EQ(config.networks[0].key, "log-1");
  EXPECT_EQ(config.networks[0].options.find("as"), nullptr);
  EXPECT_TRUE(config.proxy.networks.contains("wsn-1"));
  EXPECT_THAT(all_errors("island: {id: 1}\nnetworks: {log-1: {type: log, as: wsn-1, fil: a.rec}}\n"),
              Contains(HasSubstr("networks.log-1")));
}

TEST_F(IslandConfigs, WhatARecordingPlaysAsMustBeFree) {
  const auto errors = [this](const std::string& networks) {
    read("island: {id: 1}\nnetworks: {" + networks + "}\n");
    return errors_.text();
  };
  EXPECT_THAT(errors("dummy-1: {type: dummy}, log-1: {type: log, as: dummy-1, file: a}"),
              HasSubstr("networks.log-1.as: the network id 'dummy-1' is taken"));
  EXPECT_THAT(errors("log-1: {type: log, as: dummy-1, file: a}, dummy-1: {type: dummy}"),
              HasSubstr("networks.dummy-1: the network id 'dummy-1' is taken"));
  EXPECT_THAT(errors("log-1: {type: log, as: x, file: a}, log-2: {type: log, as: x, file: a}"), HasSubstr("is taken"));
  EXPECT_THAT(errors("log-1: {type: log, as: a.b, file: a}"), HasSubstr("a network id has [A-Za-z0-9_-]+"));
  EXPECT_THAT(errors("log-1: {type: log, as: \"\", file: a}"), HasSubstr("a network id has [A-Za-z0-9_-]+"));
  EXPECT_THAT(errors("dummy-1: {type: dummy, as: wsn-1}"), HasSubstr("only a network of type log plays another one"));
}

TEST_F(IslandConfigs, RecordersAreRead) {
  const auto config = read(
      "island: {id: 1}\nrecorders:\n  all: {file: a.rec, patterns: \"proxy.**\"}\n"
      "  few: {file: b.rec, patterns: [\"proxy.*.status\", \"7:x\"], active: yes, minimum: 2s, compression: 9,"
      " rotate: {size: never, every: 1h, keep: all}}\n");
  EXPECT_THAT(errors_.lines(), IsEmpty());
  ASSERT_THAT(config.recorders, SizeIs(2));
  EXPECT_FALSE(config.recorders[0].active);
  EXPECT_EQ(config.recorders[0].rotation.size, 100'000'000u);
  EXPECT_EQ(config.recorders[0].rotation.keep, 10u);
  EXPECT_EQ(config.recorders[0].compression, 3);
  EXPECT_EQ(config.recorders[1].compression, 9);
  EXPECT_TRUE(config.recorders[1].active);
  EXPECT_EQ(config.recorders[1].patterns[1].owner, OwnerId(7));
  EXPECT_EQ(config.recorders[1].minimum, 2s);
  EXPECT_EQ(config.recorders[1].rotation, (config::Rotation{std::nullopt, 1h, std::nullopt}));
}

TEST_F(IslandConfigs, EverythingWrongWithARecorderIsTold) {
  read(
      "island: {id: 1}\nrecorders:\n  a: {}\n  b: {file: \"\", patterns: []}\n"
      "  c: {file: x, patterns: [\"a..b\"], minimum: 5, compression: 10, activ: yes,"
      " rotate: {size: 1kB, every: 1s, keep: -1, at: noon}}\n  d: {file: x, patterns: [\"**\"]}\n");
  const auto text = errors_.text();
  for (const auto* part :
       {"recorders.a: 'file' is missing", "recorders.a: 'patterns' is missing", "recorders.b.file: empty path",
        "recorders.b.patterns: is empty", "empty part at position", "recorders.c.minimum: is '5'",
        "recorders.c.compression: is '10'", "unknown key 'activ'", "recorders.c.rotate.size: is '1kB'",
        "recorders.c.rotate.every: expected at least 10s", "recorders.c.rotate.keep: is '-1'", "unknown key 'at'",
        "recorders.d.file: is written by recorder 'c' already"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
}

TEST_F(IslandConfigs, ARecordersNameIsAKeyPart) {
  read("island: {id: 1}\nrecorders:\n  a.b: {file: x, patterns: [\"**\"]}\n  \"\": {file: y, patterns: [\"**\"]}\n  " +
       std::string(41, 'n') + ": {file: z, patterns: [\"**\"]}\n");
  ASSERT_THAT(errors_.lines(), SizeIs(3));
  for (const auto& line : errors_.lines())
    EXPECT_THAT(line, HasSubstr("a recorder's name has [A-Za-z0-9_-]+, at most 40"));
}

TEST_F(IslandConfigs, RecordersOfTheWrongShapeAreTold) {
  for (const auto* wrong :
       {"recorders: 7", "recorders: [a]", "recorders: {a: 7}", "recorders: {a: [file]}",
        "recorders: {a: {file: [x], patterns: [\"**\"]}}", "recorders: {a: {file: x, patterns: {b: c}}}",
        "recorders: {a: {file: x, patterns: [[\"**\"]]}}",
        "recorders: {a: {file: x, patterns: [\"**\"], active: perhaps}}",
        "recorders: {a: {file: x, patterns: [\"**\"], rotate: daily}}",
        "recorders: {a: {file: x, patterns: [\"**\"], rotate: {size: 63kB}}}",
        "recorders: {a: {file: x, patterns: [\"**\"], rotate: {size: 99999999999999999999MB}}}",
        "recorders: {a: {file: x, patterns: [\"**\"], rotate: {keep: 100001}}}",
        "recorders: {a: {file: x, patterns: [\"**\"], minimum: -1s}}",
        "recorders: {a: {file: x, patterns: [\"**\"], compression: 0}}"}) {
    errors_ = {};
    read(std::string("island: {id: 1}\n") + wrong + "\n");
    EXPECT_FALSE(errors_.empty()) << wrong;
    EXPECT_THAT(errors_.text(), HasSubstr("recorders")) << wrong;
  }
}

TEST(IslandConfig, ANetworkIsCalledByItsTypeOrTypeAndName) {
  const auto errors_of = [](const std::string& id) {
    const auto tree = config::parse_yaml(with_network(id + ": {type: dummy}"), "x.yaml");
    base::ConfigErrors errors;
    island::read_island_config(tree.value(), network_types(), errors);
    return errors.text();
  };
  EXPECT_EQ(errors_of("dummy"), "");
  EXPECT_EQ(errors_of("dummy-1"), "");
  EXPECT_EQ(errors_of("dummy-hall_2"), "");
  EXPECT_THAT(errors_of("rooms"), HasSubstr("a network of type dummy is called dummy or dummy-<name>"));
  EXPECT_THAT(errors_of("dummyhall"), HasSubstr("is called dummy or dummy-<name>"));
  EXPECT_THAT(errors_of("dummy-a.b"), HasSubstr("a network id has [A-Za-z0-9_-]+"));
}

TEST_F(IslandConfigTest, RefusesTwoDevicesForOneKey) {
  EXPECT_THAT(all_errors(with_network("dummy: {type: dummy, devices: {1: {id: a}, 2: {id: a}}}")),
              Contains(HasSubstr("networks.dummy.devices.2: its id 'a' is taken by device '1'")));
  EXPECT_THAT(all_errors(with_network("dummy: {type: dummy, devices: {1.4: {}, 1_4: {}}}")),
              Contains(HasSubstr("its id '1_4' is taken by device '1.4'")));
  EXPECT_THAT(all_errors(with_network("dummy: {type: dummy, devices: {1: {}, 2: {id: '1'}}}")),
              Contains(HasSubstr("its id '1' is taken by device '1'")));
}

TEST_F(IslandConfigTest, RefusesBadNamesOfPoints) {
  const auto errors = all_errors(
      with_network("dummy: {type: dummy, devices: {1: {sensors: {light: a, light-1: b c, light-2: x, light-3: x}}}}"));
  EXPECT_THAT(errors, Contains(HasSubstr("devices.1.sensors.light: expected a sensor or actuator id such as light-1")));
  EXPECT_THAT(errors, Contains(HasSubstr("devices.1.sensors.light-1: expected a name of [A-Za-z0-9_-]+")));
  EXPECT_THAT(errors, Contains(HasSubstr("devices.1.sensors.light-3: two of one type get the same name")));
}

TEST_F(IslandConfigTest, RefusesSpansThatMakeNoSense) {
  const auto errors = all_errors(
      "island: {id: 1}\ncommands: {time-to-live: 0s, queue-expiry: -1s}\nnetworks: {dummy: {type: dummy, silence: 0s, "
      "rate: 0s}}\n");
  EXPECT_THAT(errors, Contains(HasSubstr("commands.time-to-live: expected more than 0s")));
  EXPECT_THAT(errors, Contains(HasSubstr("commands.queue-expiry: is '-1s', expected a duration")));
  EXPECT_THAT(errors, Contains(HasSubstr("networks.dummy.silence: expected more than 0s, or never")));
  EXPECT_THAT(errors, Contains(HasSubstr("networks.dummy.rate: expected at least 1ms")));
}

TEST_F(IslandConfigTest, ChecksTheTypesOfTheSite) {
  const auto errors = all_errors(
      "island: {id: 1}\n"
      "types:\n"
      "  low: {id: 0x10}\n"
      "  mood: {id: 0x8001}\n"
      "  again: {id: 32769}\n"
      "  temperature: {id: 0x8002}\n"
      "  bad-name: {id: 0x8003}\n"
      "  shape: {id: 0x8004, data: round}\n"
      "  nameless: {}\n");
  EXPECT_THAT(errors, SizeIs(6)) << errors_.text();
  EXPECT_THAT(errors, Contains(StartsWith("x.yaml:3:8: types.low: ")));
  EXPECT_THAT(errors, Contains(StartsWith("x.yaml:5:10: types.again: ")));
  EXPECT_THAT(errors, Contains(StartsWith("x.yaml:6:16: types.temperature: ")));
  EXPECT_THAT(errors, Contains(StartsWith("x.yaml:7:13: types.bad-name: ")));
  EXPECT_THAT(errors, Contains(HasSubstr("types.shape.data: is 'round', expected one of: boolean")));
  EXPECT_THAT(errors, Contains(HasSubstr("types.nameless: 'id' is missing")));
}

TEST_F(IslandConfigTest, SurvivesValuesOfTheWrongKindEverywhere) {
  for (const auto* key : {"island", "tuples", "discovery", "limits", "commands", "types", "networks"}) {
    for (const auto* value : {"[1, 2]", "text", "{a: {b: [c]}}", "{a: []}", "[]"}) {
      EXPECT_THAT(all_errors(std::string(key) + ": " + value + "\n"), testing::Not(IsEmpty())) << key << value;
    }
  }
  for (const auto* key : {"silence", "rate", "devices", "simulate", "line", "seed"}) {
    EXPECT_THAT(all_errors(with_network("dummy: {type: dummy, " + std::string(key) + ": [[1], {a: b}]}")),
                testing::Not(IsEmpty()))
        << key;
  }
}

TEST_F(IslandConfigTest, TheRateMayBeCalledSamplingRate) {
  const auto config = read(with_network("dummy: {type: dummy, sampling-rate: 250ms}"));
  EXPECT_THAT(errors_.lines(), IsEmpty());
  EXPECT_EQ(config.proxy.networks.at("dummy").rate, 250ms);
  EXPECT_THAT(all_errors(with_network("dummy: {type: dummy, sampling-rate: 0s}")),
              Contains(HasSubstr("networks.dummy.sampling-rate: expected at least 1ms")));
  EXPECT_THAT(all_errors(with_network("dummy: {type: dummy, sampling-rate: 1s, rate: 1s}")),
              Contains(HasSubstr("another name of rate")));
}

TEST_F(IslandConfigTest, AnOverrideReplacesOrCreatesAnyValue) {
  const auto config = read(with_network("dummy: {type: dummy, silence: 1s}"),
                           {"networks.dummy.silence=2s", "limits.queue=5", "island.name=other",
                            "networks.dummy.devices.\"1.4.6\".name=Hall = way", "networks.dummy-2={type: dummy}"});
  EXPECT_THAT(errors_.lines(), IsEmpty());
  EXPECT_EQ(config.proxy.networks.at("dummy").silence, Duration(2s));
  EXPECT_EQ(config.limits.queue, 5U);
  EXPECT_EQ(config.proxy.island_name, "other");
  EXPECT_EQ(config.proxy.networks.at("dummy").devices.at("1.4.6").name, "Hall = way");
  EXPECT_THAT(config.networks, SizeIs(2));
}

TEST_F(IslandConfigTest, AnOverrideIsCheckedLikeTheFile) {
  const auto errors = all_errors(with_network("dummy: {type: dummy}"),
                                 {"networks.dummy.seed=many", "networks.dummy.sede=7", "limits.queue=0"});
  EXPECT_THAT(errors, SizeIs(3));
  EXPECT_THAT(errors,
              Contains(StartsWith("--set 'networks.dummy.seed=many': networks.dummy.seed: is 'many', expected")));
  EXPECT_THAT(errors, Contains(StartsWith("--set 'networks.dummy.sede=7': networks.dummy: unknown key 'sede'")));
  EXPECT_THAT(errors, Contains(StartsWith("--set 'limits.queue=0': limits.queue: is '0', expected")));
}

TEST_F(IslandConfigTest, RefusesOverridesThatAreNone) {
  auto tree = config::parse_yaml(with_network("dummy: {type: dummy}"), "x.yaml").value();
  for (const auto* text : {"", "=", "a", "a.=1", ".a=1", "a..b=1", "=1", "\"a=1", "island.id.x=1", "a={", "a=*b"}) {
    const auto applied = config::apply_override(tree, text);
    ASSERT_FALSE(applied) << text;
    EXPECT_THAT(applied.error().text, StartsWith("--set '")) << text;
  }
}

TEST_F(IslandConfigTest, RoamingIsADomainOrOff) {
  const auto domain = [this](const std::string& word) {
    const auto config = read(std::string(kHead) + "networks: {dummy: {type: dummy" + word + "}}");
    return config.proxy.networks.at("dummy").roaming;
  };
  EXPECT_EQ(domain(""), "");
  EXPECT_EQ(domain(", roaming: lab"), "lab");
  EXPECT_EQ(domain(", roaming: off"), "");
  EXPECT_THAT(errors_.lines(), IsEmpty());
  for (const auto* wrong : {"a.b", "yes", "'on'", "''", "\"two words\""}) {
    EXPECT_EQ(domain(std::string(", roaming: ") + wrong), "");
    EXPECT_THAT(errors_.text(), HasSubstr("expected off, or the name of a domain")) << wrong;
  }
}

TEST_F(IslandConfigTest, ATypeWithUniqueAddressesRoamsUnlessTheConfigurationSaysOtherwise) {
  const network::NetworkType unique{
      .name = "tag", .summary = "", .sample_config = "", .make = nullptr, .roaming = "world"};
  const auto domain = [&](const std::string& word) {
    const auto tree = config::parse_yaml(std::string(kHead) + "networks: {tag: {type: tag" + word + "}}", "x.yaml");
    return island::read_island_config(*tree, std::span(&unique, 1), errors_).proxy.networks.at("tag").roaming;
  };
  EXPECT_EQ(domain(""), "world");
  EXPECT_EQ(domain(", roaming: lab"), "lab");
  EXPECT_EQ(domain(", roaming: off"), "");
  EXPECT_THAT(errors_.lines(), IsEmpty());
}

TEST(ConfigFile, NamesTheFileThatIsNotThere) {
  const auto missing = config::load_config("/nowhere/home.yaml", {});
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().text, HasSubstr("/nowhere/home.yaml"));
  EXPECT_EQ(config::load_config("/", {}).error().code, ErrorCode::kNotFound);
}

TEST(ConfigFile, TheDemoIslandIsRight) {
  const auto tree = config::load_config(std::string(RUBICON_SOURCE_DIR) + "/examples/home.yaml", {});
  ASSERT_TRUE(tree) << tree.error().text;
  base::ConfigErrors errors;
  const auto config = island::read_island_config(*tree, network_types(), errors);
  EXPECT_EQ(errors.text(), "");
  EXPECT_THAT(config.networks, SizeIs(3));
}

TEST(ConfigFile, TheTwoSpellingsOfTheFlatSayTheSame) {
  const std::string folder = std::string(RUBICON_SOURCE_DIR) + "/examples";
  transport::LocalTransports disk;
  const TypeCatalogue types;
  std::vector<std::map<networks::salad::DeviceId, networks::salad::SaladDevice>> flats;
  for (const auto* file : {"/salad.yaml", "/home.yaml"}) {
    base::ConfigErrors errors;
    const auto tree = config::load_config(folder + file, {});
    ASSERT_TRUE(tree) << tree.error().text;
    const auto config = island::read_island_config(*tree, network_types(), errors);
    ConfigReader options(config.networks.back().options, "salad", errors);
    flats.push_back(networks::salad::read_salad_options({"salad", IslandId{1}, options, types, folder}, disk).devices);
    EXPECT_EQ(errors.text(), "");
  }
  EXPECT_THAT(flats[0], SizeIs(55));
  EXPECT_EQ(flats[0], flats[1]);
}

}  // namespace
}  // namespace rubicon::island
