#include <regex>

#include "bridges/mqtt/receiver_rules.h"
#include "bridges/mqtt/town.h"
#include "model/home_assistant.h"

namespace rubicon::bridges::mqtt {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kAll = R"({"discovery": "homeassistant", "commands": ["**"]})";

class DiscoveryOf : public Town {
 protected:
  /// The components that are announced for a device with these points.
  json entities(const std::vector<Described>& points, const std::string& options = kAll) {
    island.network("zigbee-1");
    island.device("zigbee-1.d", "Hall", points, "Hall");
    time.run_for(10ms);
    bridge(options);
    time.run_for(6s);
    const auto message = announced("zigbee-1_d");
    EXPECT_THAT(message.is_object() ? faults_of(message) : std::vector<std::string>{"nothing announced"}, IsEmpty());
    return message.is_object() ? message["cmps"] : json::object();
  }
  static constexpr const char* kTopic = "rubicon/6541/zigbee-1/d/";
  /// The parts that say what it is, without names and ids.
  static json core(json entity) {
    for (const auto* key : {"uniq_id", "default_entity_id", "name", "avty", "message_expiry_interval"})
      entity.erase(key);
    return json::parse(std::regex_replace(entity.dump(), std::regex(kTopic), "T/"));
  }
};

TEST_F(DiscoveryOf, ADeviceTellsWhoItIsAndWhenItIsThere) {
  const auto all = entities({{"sensor", "temperature-1", "21.5"},
                             {"property", "firmware-1", "1.2", "good", {}, "read"},
                             {"property", "manufacturer-1", "Maker", "good", {}, "read"}},
                            R"({"discovery": "homeassistant", "page": "http://hall.lan:8642"})");
  const auto message = announced("zigbee-1_d");
  EXPECT_EQ(message["dev"], json::parse(R"({"ids":["rubicon_6541_zigbee-1_d"],"name":"Hall","mf":"Maker","mdl":"M1",
      "sw":"1.2","sa":"Hall","via_device":"rubicon_6541_zigbee-1",
      "cu":"http://hall.lan:8642/#/devices/6541/zigbee-1/d"})"));
  EXPECT_EQ(message["avty"], json::parse(R"([{"t":"rubicon/6541/online"},{"t":"rubicon/6541/zigbee-1/online"},
      {"t":"rubicon/6541/zigbee-1/d/online"}])"));
  const auto temperature = all["sensor-temperature-1"];
  EXPECT_EQ(temperature["avty"].back()["t"], "rubicon/6541/zigbee-1/d/sensor/temperature-1/online");
  EXPECT_EQ(temperature["uniq_id"], "rubicon_6541_zigbee-1_d_sensor-temperature-1");
  EXPECT_EQ(temperature["default_entity_id"], "sensor.hall_temperature");
  EXPECT_EQ(temperature["name"], "Temperature");
  for (const auto* one : {"6541", "6541_zigbee-1"}) {
    const auto there = json::parse(at(std::string("homeassistant/device/rubicon_") + one + "/config"));
    EXPECT_THAT(faults_of(there), IsEmpty()) << one;
    EXPECT_EQ(there["cmps"]["online"]["dev_cla"], "connectivity");
  }
}

TEST_F(DiscoveryOf, Lamp) {
  const auto all = entities({{"actuator", "lamp-1", "on"}});
  EXPECT_EQ(core(all["actuator-lamp-1"]), json::parse(R"({"p":"light","stat_t":"T/actuator/lamp-1",
      "cmd_t":"T/actuator/lamp-1/set","opt":false,"pl_on":"on","pl_off":"off"})"));
  EXPECT_EQ(all["actuator-lamp-1"]["name"], nullptr);
  EXPECT_EQ(all["actuator-lamp-1"]["message_expiry_interval"], 5);
  EXPECT_EQ(all.size(), 1U);
}

TEST_F(DiscoveryOf, LampWithDimmerAndColours) {
  const auto all = entities({{"actuator", "lamp-1", "on"},
                             {"actuator", "dimmer-1", "50"},
                             {"actuator", "colourTemperature-1", "2700"},
                             {"actuator", "colourXy-1", R"({"x":0.3,"y":0.4})"},
                             {"actuator", "colourRgb-1", "#ff8000"}});
  EXPECT_EQ(all.size(), 1U);
  EXPECT_EQ(core(all["actuator-lamp-1"]), json::parse(R"({"p":"light","stat_t":"T/actuator/lamp-1",
      "cmd_t":"T/actuator/lamp-1/set","opt":false,"pl_on":"on","pl_off":"off",
      "bri_cmd_t":"T/actuator/dimmer-1/set","bri_stat_t":"T/actuator/dimmer-1","bri_scl":100,
      "clr_temp_cmd_t":"T/actuator/colourTemperature-1/set","clr_temp_stat_t":"T/actuator/colourTemperature-1",
      "color_temp_kelvin":true,"min_kelvin":1000,"max_kelvin":20000,
      "xy_cmd_t":"T/actuator/colourXy-1/set","xy_stat_t":"T/actuator/colourXy-1",
      "xy_command_template":"{\"x\":{{ x }},\"y\":{{ y }}}","xy_val_tpl":"{{ value_json.x }},{{ value_json.y }}",
      "rgb_cmd_t":"T/actuator/colourRgb-1/set","rgb_stat_t":"T/actuator/colourRgb-1",
      "rgb_command_template":"{{ '#%02x%02x%02x' % (red, green, blue) }}",
      "rgb_val_tpl":"{{ value[1:3] | int(base=16) }},{{ value[3:5] | int(base=16) }},{{ value[5:7] | int(base=16) }}"})"));
}

TEST_F(DiscoveryOf, DimmerAlone) {
  const auto all = entities({{"actuator", "dimmer-2", "50"}});
  EXPECT_EQ(core(all["actuator-dimmer-2"]), json::parse(R"({"p":"light","stat_t":"T/actuator/dimmer-2",
      "cmd_t":"T/actuator/dimmer-2/set","opt":false,"pl_on":"on","pl_off":"0","on_cmd_type":"brightness",
      "stat_val_tpl":"{{ 'on' if value | float(0) > 0 else '0' }}","bri_cmd_t":"T/actuator/dimmer-2/set",
      "bri_stat_t":"T/actuator/dimmer-2","bri_scl":100})"));
}

TEST_F(DiscoveryOf, TwoLampsKeepTheirDimmers) {
  const auto all = entities({{"actuator", "lamp-1", "on"},
                             {"actuator", "lamp-2", "on"},
                             {"actuator", "dimmer-2", "50"},
                             {"actuator", "lightLevel-1", "128"}});
  EXPECT_EQ(all.size(), 2U);
  EXPECT_EQ(all["actuator-lamp-1"]["bri_scl"], 255);
  EXPECT_EQ(all["actuator-lamp-2"]["bri_scl"], 100);
  EXPECT_EQ(all["actuator-lamp-1"]["name"], "Lamp 1");
}

TEST_F(DiscoveryOf, BlindWithTilt) {
  const auto all = entities({{"actuator", "blindPosition-1", "30"},
                             {"actuator", "blindTilt-1", "50"},
                             {"actuator", "blindMove-1", "", "unknown", {"up", "down", "stop"}}});
  EXPECT_EQ(all.size(), 1U);
  EXPECT_EQ(core(all["actuator-blindPosition-1"]), json::parse(R"({"p":"cover","pos_t":"T/actuator/blindPosition-1",
      "set_pos_t":"T/actuator/blindPosition-1/set","pos_open":0,"pos_clsd":100,"opt":false,
      "cmd_t":"T/actuator/blindMove-1/set","pl_open":"up","pl_cls":"down","pl_stop":"stop",
      "tilt_cmd_t":"T/actuator/blindTilt-1/set","tilt_status_t":"T/actuator/blindTilt-1","tilt_opnd_val":0,
      "tilt_clsd_val":100,"dev_cla":"blind"})"));
}

TEST_F(DiscoveryOf, Thermostat) {
  const auto all = entities({{"actuator", "hvacController-1", "heat", "good", {"heat", "off", "fan"}},
                             {"actuator", "temperatureSetpoint-1", "21"},
                             {"sensor", "temperature-1", "20"},
                             {"sensor", "hvacState-1", "idle"}});
  EXPECT_EQ(core(all["actuator-hvacController-1"]), json::parse(R"({"p":"climate","modes":["heat","off","fan_only"],
      "mode_cmd_t":"T/actuator/hvacController-1/set","mode_stat_t":"T/actuator/hvacController-1",
      "mode_cmd_tpl":"{{ 'fan' if value == 'fan_only' else value }}",
      "mode_stat_tpl":"{{ 'fan_only' if value == 'fan' else value }}","opt":false,
      "temp_cmd_t":"T/actuator/temperatureSetpoint-1/set","temp_stat_t":"T/actuator/temperatureSetpoint-1",
      "temp_unit":"C","min_temp":-50.0,"max_temp":150.0,"temp_step":0.5,"curr_temp_t":"T/sensor/temperature-1",
      "act_t":"T/sensor/hvacState-1",
      "act_tpl":"{{ {'heat': 'heating', 'cool': 'cooling', 'fan': 'fan'}.get(value, 'idle') }}"})"));
  EXPECT_TRUE(all.contains("sensor-temperature-1")) << "it stays a sensor too";
}

TEST_F(DiscoveryOf, ThermostatsHaveThePresetsAndFanModesOfTheDevice) {
  const auto all = entities({{"actuator", "hvacController-1", "heat", "good", {"heat", "off"}},
                             {"actuator", "preset-1", "eco", "good", {"none", "eco", "away"}},
                             {"actuator", "fanMode-1", "low", "good", {"low", "high"}}});
  EXPECT_EQ(all.size(), 1U) << "they are no selections beside it";
  EXPECT_EQ(core(all["actuator-hvacController-1"]), json::parse(R"({"p":"climate","modes":["heat","off"],
      "mode_cmd_t":"T/actuator/hvacController-1/set","mode_stat_t":"T/actuator/hvacController-1",
      "mode_cmd_tpl":"{{ 'fan' if value == 'fan_only' else value }}",
      "mode_stat_tpl":"{{ 'fan_only' if value == 'fan' else value }}","opt":false,
      "pr_modes":["eco","away"],"pr_mode_cmd_t":"T/actuator/preset-1/set","pr_mode_stat_t":"T/actuator/preset-1",
      "fan_modes":["low","high"],"fan_mode_cmd_t":"T/actuator/fanMode-1/set",
      "fan_mode_stat_t":"T/actuator/fanMode-1"})"));
}

TEST_F(DiscoveryOf, RoomControllersHaveModesAsPresets) {
  const auto all = entities({{"actuator", "hvacMode-1", "comfort"}, {"actuator", "temperatureSetpoint-1", "21"}});
  EXPECT_EQ(all.size(), 1U);
  EXPECT_EQ(core(all["actuator-hvacMode-1"]), json::parse(R"({"p":"climate","modes":["auto"],
      "mode_stat_t":"T/actuator/hvacMode-1","mode_stat_tpl":"auto","opt":false,
      "temp_cmd_t":"T/actuator/temperatureSetpoint-1/set","temp_stat_t":"T/actuator/temperatureSetpoint-1",
      "temp_unit":"C","min_temp":-50.0,"max_temp":150.0,"temp_step":0.5,
      "pr_modes":["auto","comfort","standby","economy","protection"],"pr_mode_cmd_t":"T/actuator/hvacMode-1/set",
      "pr_mode_stat_t":"T/actuator/hvacMode-1"})"));
}

TEST_F(DiscoveryOf, SirensHaveTonesAndDurationsOfTheDevice) {
  const auto all = entities({{"actuator", "siren-warning", "off"},
                             {"property", "melody-warning", "", "unknown", {"burglar", "fire"}},
                             {"property", "duration-warning", "60"}});
  EXPECT_EQ(core(all["actuator-siren-warning"]), json::parse(R"({"p":"siren","stat_t":"T/actuator/siren-warning",
      "cmd_t":"T/actuator/siren-warning/set","opt":false,"pl_on":"on","pl_off":"off","stat_on":"on","stat_off":"off",
      "av_tones":["burglar","fire"],"sup_dur":true,"sup_vol":false})"))
      << "without a template: it sends an object";
  EXPECT_EQ(all["property-melody-warning"]["p"], "select") << "also by itself";
}

TEST_F(DiscoveryOf, ASirenIsAsLoudAsItIsTold) {
  const auto all = entities({{"actuator", "siren-1", "off"}, {"property", "volume-1", "80"}});
  EXPECT_EQ(core(all["actuator-siren-1"]), json::parse(R"({"p":"siren","stat_t":"T/actuator/siren-1",
      "cmd_t":"T/actuator/siren-1/set","opt":false,"pl_on":"on","pl_off":"off","stat_on":"on","stat_off":"off",
      "sup_dur":false,"sup_vol":true})"))
      << "without a template: it sends an object";
  EXPECT_EQ(core(all["property-volume-1"]), json::parse(R"({"p":"number","stat_t":"T/property/volume-1",
      "cmd_t":"T/property/volume-1/set","opt":false,"min":0.0,"max":100.0,"step":0.1,"mode":"slider",
      "unit_of_meas":"%","ent_cat":"config"})"));
}

TEST_F(DiscoveryOf, DatesAndTimes) {
  const std::vector<Described> points{{"actuator", "date-1", "2026-11-20"},
                                      {"actuator", "timeOfDay-1", "Fri 13:30:15"},
                                      {"actuator", "dateTime-1", R"({"dateTime":"2026-11-20T13:30:15"})"},
                                      {"sensor", "dateTime-2", "2026-11-20T13:30:15"},
                                      {"sensor", "date-2", "2026-11-20"}};
  const auto all = entities(points);
  EXPECT_EQ(core(all["actuator-date-1"]), json::parse(R"({"p":"date","stat_t":"T/actuator/date-1",
      "cmd_t":"T/actuator/date-1/set","opt":false})"));
  EXPECT_EQ(core(all["actuator-timeOfDay-1"]), json::parse(R"({"p":"time","stat_t":"T/actuator/timeOfDay-1",
      "cmd_t":"T/actuator/timeOfDay-1/set","opt":false,"val_tpl":"{{ value.split(' ')[-1] }}"})"));
  EXPECT_EQ(all["actuator-dateTime-1"]["p"], "datetime");
  EXPECT_THAT(all["actuator-dateTime-1"]["cmd_tpl"], HasSubstr("as_local"));
  EXPECT_EQ(all["sensor-dateTime-2"]["dev_cla"], "timestamp");
  EXPECT_EQ(all["sensor-dateTime-2"]["val_tpl"], all["actuator-dateTime-1"]["val_tpl"]);
  EXPECT_EQ(core(all["sensor-date-2"]), json::parse(R"({"p":"sensor","stat_t":"T/sensor/date-2","dev_cla":"date"})"));
}

TEST_F(DiscoveryOf, GroupsNameTheEntitiesOfTheirMembers) {
  island.put("proxy.zigbee-1.property.groups.value", R"([{"address":"d","members":["b1","b2","none"]}])");
  island.device("zigbee-1.b1", "Lamp 1", {{"actuator", "lamp-1", "on"}, {"actuator", "switch-1", "on"}});
  const auto alone = entities({{"actuator", "lamp-1", "on"}});
  EXPECT_EQ(alone["actuator-lamp-1"]["group"], json::parse(R"(["rubicon_6541_zigbee-1_b1_actuator-lamp-1"])"));
  EXPECT_FALSE(announced("zigbee-1_b1")["cmps"]["actuator-lamp-1"].contains("group"));
  island.device("zigbee-1.b2", "Lamp 2", {{"actuator", "lamp-1", "on"}});
  time.run_for(6s);
  EXPECT_EQ(announced("zigbee-1_d")["cmps"]["actuator-lamp-1"]["group"],
            json::parse(R"(["rubicon_6541_zigbee-1_b1_actuator-lamp-1","rubicon_6541_zigbee-1_b2_actuator-lamp-1"])"));
  island.put("proxy.zigbee-1.property.groups.value", R"([{"address":"d","members":["b2"]}])");
  time.run_for(1s);
  EXPECT_EQ(announced("zigbee-1_d")["cmps"]["actuator-lamp-1"]["group"].size(), 1U);
  ASSERT_TRUE(island.space.erase("proxy.zigbee-1.property.groups.value"));
  time.run_for(1s);
  EXPECT_FALSE(announced("zigbee-1_d")["cmps"]["actuator-lamp-1"].contains("group"));
}

TEST_F(DiscoveryOf, GroupsGoWithTheirNetwork) {
  auto other = std::make_unique<TownIsland>(ecology, time, OwnerId(77), "barn");
  const auto add_lamps = [&other] {
    other->network("zigbee-1");
    for (const auto* one : {"b", "d"})
      other->device("zigbee-1." + std::string(one), one, {{"actuator", "lamp-1", "on"}});
  };
  const auto lamp = [this] {
    return json::parse(at("homeassistant/device/rubicon_77_zigbee-1_d/config"))["cmps"]["actuator-lamp-1"];
  };
  add_lamps();
  other->put("proxy.zigbee-1.property.groups.value", R"([{"address":"d","members":["b"]}])");
  bridge(R"({"discovery": "homeassistant", "commands": ["**"], "patterns": ["proxy.**"]})");
  time.run_for(6s);
  ASSERT_TRUE(lamp().contains("group"));
  other.reset();
  time.run_for(2min);
  other = std::make_unique<TownIsland>(ecology, time, OwnerId(77), "barn");
  time.run_for(61s);
  ASSERT_EQ(at("homeassistant/device/rubicon_77_zigbee-1_d/config"), "(nothing)");
  add_lamps();
  time.run_for(6s);
  EXPECT_FALSE(lamp().contains("group")) << "it has none now";
}

TEST_F(DiscoveryOf, IsNotRepeatedWhereNothingIsNew) {
  std::ignore = entities({{"sensor", "temperature-1", "20"}});
  broker.forget_published();
  island.reach("zigbee-1.d", "unreachable");
  time.run_for(1s);
  EXPECT_EQ(at("rubicon/6541/zigbee-1/d/online"), "offline");
  EXPECT_THAT(broker.published("homeassistant/device/rubicon_6541_zigbee-1_d/config"), IsEmpty());
}

TEST_F(DiscoveryOf, LockValvesFanSirenAndButton) {
  const auto all = entities({{"actuator", "lock-1", "locked"},
                             {"actuator", "doorOpener-1", "", "unknown"},
                             {"actuator", "valve-1", "40"},
                             {"actuator", "valveSwitch-1", "open"},
                             {"actuator", "fan-1", "on"},
                             {"actuator", "fanSpeed-1", "40"},
                             {"actuator", "siren-1", "off"},
                             {"actuator", "garageDoor-1", "closed"}});
  EXPECT_EQ(core(all["actuator-lock-1"]), json::parse(R"({"p":"lock","stat_t":"T/actuator/lock-1",
      "cmd_t":"T/actuator/lock-1/set","opt":false,"pl_lock":"locked","pl_unlk":"unlocked","stat_locked":"locked",
      "stat_unlocked":"unlocked"})"));
  EXPECT_EQ(core(all["actuator-doorOpener-1"]),
            json::parse(R"({"p":"button","cmd_t":"T/actuator/doorOpener-1/set","pl_prs":"on"})"));
  EXPECT_EQ(core(all["actuator-valve-1"]), json::parse(R"({"p":"valve","stat_t":"T/actuator/valve-1",
      "cmd_t":"T/actuator/valve-1/set","opt":false,"reports_position":true})"));
  EXPECT_EQ(core(all["actuator-valveSwitch-1"]), json::parse(R"({"p":"valve","stat_t":"T/actuator/valveSwitch-1",
      "cmd_t":"T/actuator/valveSwitch-1/set","opt":false,"pl_open":"open","pl_cls":"closed","stat_open":"open",
      "stat_clsd":"closed"})"));
  EXPECT_EQ(core(all["actuator-fan-1"]), json::parse(R"({"p":"fan","stat_t":"T/actuator/fan-1",
      "cmd_t":"T/actuator/fan-1/set","opt":false,"pl_on":"on","pl_off":"off","pct_cmd_t":"T/actuator/fanSpeed-1/set",
      "pct_stat_t":"T/actuator/fanSpeed-1"})"));
  EXPECT_EQ(core(all["actuator-siren-1"]), json::parse(R"({"p":"siren","stat_t":"T/actuator/siren-1",
      "cmd_t":"T/actuator/siren-1/set","opt":false,"pl_on":"on","pl_off":"off","stat_on":"on","stat_off":"off",
      "cmd_tpl":"{{ value }}","sup_dur":false,"sup_vol":false})"));
  EXPECT_EQ(core(all["actuator-garageDoor-1"])["dev_cla"], "garage");
}

TEST_F(DiscoveryOf, EventsHaveTheWordsOfTheDevice) {
  const auto all = entities({{"sensor", "action-1", "", "unknown", {"on", "brightness_move_up"}},
                             {"sensor", "doorbell-1", "", "unknown"},
                             {"sensor", "buttonCount-1", "", "unknown"}});
  EXPECT_EQ(core(all["sensor-action-1"]), json::parse(R"({"p":"event","stat_t":"T/sensor/action-1",
      "event_types":["on","brightness_move_up"],"val_tpl":"{\"event_type\":{{ value | tojson }}}","dev_cla":"button"})"));
  EXPECT_EQ(all["sensor-doorbell-1"]["event_types"], json::parse(R"(["on"])"));
  EXPECT_EQ(all["sensor-buttonCount-1"]["val_tpl"], R"({"event_type":"buttonCount","value":{{ value | tojson }}})");
}

TEST_F(DiscoveryOf, OneWordIsAButton) {
  const auto all = entities({{"property", "identify-1", "", "unknown", {"identify"}, "write"}});
  EXPECT_EQ(core(all["property-identify-1"]), json::parse(R"({"p":"button","cmd_t":"T/property/identify-1/set",
      "pl_prs":"identify","dev_cla":"identify","ent_cat":"config"})"));
}

TEST_F(DiscoveryOf, WhatIsOnlyShownIsNoSwitch) {
  const std::vector<Described> points{{"actuator", "lamp-1", "on"},
                                      {"actuator", "lock-1", "locked"},
                                      {"actuator", "dimmer-1", "50"},
                                      {"actuator", "hvacMode-1", "comfort"}};
  const auto all = entities(points, R"({"discovery": "homeassistant"})");
  for (const auto& [id, entity] : all.items()) {
    EXPECT_FALSE(entity.contains("cmd_t")) << id;
    EXPECT_THAT(entity["p"].get<std::string>(), HasSubstr("sensor")) << id;
  }
  EXPECT_EQ(all["actuator-lock-1"]["pl_on"], "unlocked") << "their lock is on when it is open";
}

TEST_F(DiscoveryOf, UsualCommandsOpenNoDoor) {
  const auto all = entities({{"actuator", "lamp-1", "on"},
                             {"actuator", "lock-1", "locked"},
                             {"actuator", "doorOpener-1", "", "unknown", {}, "read-write"},
                             {"actuator", "siren-1", "off"},
                             {"property", "interval-1", "5"}},
                            R"({"discovery": "homeassistant", "commands": "yes"})");
  EXPECT_TRUE(all["actuator-lamp-1"].contains("cmd_t"));
  for (const auto* id : {"actuator-lock-1", "actuator-doorOpener-1", "actuator-siren-1", "property-interval-1"})
    EXPECT_FALSE(all.contains(id) && all[id].contains("cmd_t")) << id;
}

TEST_F(DiscoveryOf, PropertiesAreConfigurationOrDiagnostics) {
  const auto all = entities({{"property", "powerOnBehaviour-1", "on"},
                             {"property", "interval-1", "60"},
                             {"property", "childLock-1", "off"},
                             {"property", "firmware-1", "1", "good", {}, "read"},
                             {"property", "label-1", "x"}});
  EXPECT_EQ(all["property-powerOnBehaviour-1"]["p"], "select");
  EXPECT_EQ(all["property-interval-1"]["p"], "number");
  EXPECT_EQ(all["property-childLock-1"]["p"], "switch");
  EXPECT_EQ(all["property-label-1"]["p"], "text");
  EXPECT_EQ(all["property-childLock-1"]["ent_cat"], "config");
  EXPECT_EQ(all["property-firmware-1"]["ent_cat"], "diagnostic");
}

/// Each type of the catalogue, as sensor and as actuator: whatever it is, the receiver takes it.
TEST_F(DiscoveryOf, EachTypeIsTaken) {
  const TypeCatalogue types;
  std::vector<Described> points;
  for (const auto* type : types.all()) {
    points.push_back({"sensor", std::string(type->name) + "-1", ""});
    points.push_back({"actuator", std::string(type->name) + "-1", ""});
  }
  island.network("zigbee-1");
  for (std::size_t i = 0; i < points.size(); i += 20) {
    const auto end = std::min(points.size(), i + 20);
    island.device(fmt::format("zigbee-1.d{}", i / 20), "Hall",
                  {points.begin() + static_cast<std::ptrdiff_t>(i), points.begin() + static_cast<std::ptrdiff_t>(end)});
  }
  time.run_for(1s);
  bridge(kAll);
  time.run_for(6s);
  std::size_t devices = 0;
  for (const auto& [topic, payload] : broker.retained()) {
    if (!topic.ends_with("/config")) continue;
    ++devices;
    EXPECT_THAT(faults_of(json::parse(payload)), IsEmpty()) << topic;
  }
  EXPECT_EQ(devices, (points.size() + 19) / 20 + 2);
}

TEST_F(DiscoveryOf, AirPressureIsInHectopascal) {
  const auto all = entities({{"sensor", "airPressure-1", "101325"}});
  EXPECT_EQ(core(all["sensor-airPressure-1"]), json::parse(R"({"p":"sensor","stat_t":"T/sensor/airPressure-1",
      "unit_of_meas":"hPa","dev_cla":"atmospheric_pressure","stat_cla":"measurement","val_tpl":"{{ value | float * 0.01 }}"})"));
}

/// What is left out of an announcement is removed there, with all that people set of it.
TEST_F(DiscoveryOf, ADeviceIsAnnouncedWhenAllItsPointsAreDescribed) {
  island.network("zigbee-1");
  bridge(kAll);
  island.device("zigbee-1.d", "Hall", {{"sensor", "temperature-1", "20"}, {"sensor", "humidity-1", "40"}});
  island.space.erase(Pattern::parse("proxy.zigbee-1.d.sensor.humidity-1.*").value());
  time.run_for(1s);
  EXPECT_TRUE(announced("zigbee-1_d").is_discarded());
  island.point("zigbee-1.d", {"sensor", "humidity-1", "40"});
  time.run_for(1s);
  EXPECT_EQ(announced("zigbee-1_d")["cmps"].size(), 2U);
}

TEST_F(DiscoveryOf, LargeDevicesAreSplit) {
  std::vector<Described> points;
  for (int i = 1; i <= 300; ++i) points.push_back({"sensor", fmt::format("temperature-{}", i), "20"});
  const auto first = entities(points);
  const auto second = announced("zigbee-1_d_2");
  EXPECT_EQ(first.size(), 256U);
  EXPECT_EQ(second["cmps"].size(), 44U);
  EXPECT_EQ(second["dev"]["ids"], announced("zigbee-1_d")["dev"]["ids"]);
  island.remove_device("zigbee-1.d");
  time.run_for(1s);
  EXPECT_EQ(at("homeassistant/device/rubicon_6541_zigbee-1_d_2/config"), "(nothing)");
}

TEST_F(DiscoveryOf, OlderReceiversGetAMessageAnEntity) {
  island.network("zigbee-1");
  island.device("zigbee-1.d", "Hall", {{"sensor", "temperature-1", "21.5"}, {"actuator", "lamp-1", "on"}});
  bridge(R"({"discovery": "homeassistant-entities", "commands": "yes"})");
  time.run_for(6s);
  const auto lamp = json::parse(at("homeassistant/light/rubicon_6541_zigbee-1_d/actuator-lamp-1/config"));
  EXPECT_EQ(lamp["dev"]["ids"][0], "rubicon_6541_zigbee-1_d");
  EXPECT_EQ(lamp["avty"].size(), 3U);
  EXPECT_EQ(lamp["o"]["name"], "rubicon");
  EXPECT_NE(at("homeassistant/sensor/rubicon_6541_zigbee-1_d/sensor-temperature-1/config"), "(nothing)");
  island.space.erase(Pattern::parse("proxy.zigbee-1.d.sensor.**").value());
  time.run_for(6s);
  EXPECT_EQ(at("homeassistant/sensor/rubicon_6541_zigbee-1_d/sensor-temperature-1/config"), "(nothing)");
}

TEST_F(DiscoveryOf, AnotherFormOfARunBeforeIsRemoved) {
  const std::vector<Described> points{{"sensor", "temperature-1", "21.5"}};
  std::ignore = entities(points);
  end_bridge();
  bridge(R"({"discovery": "homeassistant-entities"})");
  time.run_for(15s);
  EXPECT_EQ(broker.published("homeassistant/device/rubicon_6541_zigbee-1_d/config").at(1),
            R"({"migrate_discovery": true})")
      << "before the others: the ids are the same";
  EXPECT_EQ(at("homeassistant/device/rubicon_6541_zigbee-1_d/config"), "(nothing)");
  EXPECT_NE(at("homeassistant/sensor/rubicon_6541_zigbee-1_d/sensor-temperature-1/config"), "(nothing)");
}

TEST_F(DiscoveryOf, TheBirthMessageIsAnswered) {
  std::ignore = entities({{"sensor", "temperature-1", "21.5"}});
  broker.forget_published();
  send("homeassistant/status", "online");
  time.run_for(11s);
  EXPECT_EQ(broker.published("homeassistant/device/rubicon_6541_zigbee-1_d/config").size(), 1U);
  EXPECT_EQ(broker.published("rubicon/6541/zigbee-1/d/sensor/temperature-1").size(), 1U);
}

TEST_F(DiscoveryOf, RenamesKeepIds) {
  const auto before = entities({{"sensor", "temperature-1", "21.5"}});
  island.device("zigbee-1.d", "Cellar", {{"sensor", "temperature-1", "21.5"}});
  time.run_for(1s);
  const auto after = announced("zigbee-1_d");
  EXPECT_EQ(after["dev"]["name"], "Cellar");
  EXPECT_EQ(after["cmps"]["sensor-temperature-1"]["uniq_id"], before["sensor-temperature-1"]["uniq_id"]);
}

TEST_F(DiscoveryOf, NamesOfEveryCharacterAreTaken) {
  island.network("zigbee-1");
  const std::vector<std::string> names{"", " ", "Küche", "温度", "a\"b\\c", std::string(300, 'x'), "\x01", "~", "#+/"};
  for (std::size_t i = 0; i < names.size(); ++i)
    island.device(fmt::format("zigbee-1.d{}", i), names[i], {{"sensor", "temperature-1", "20"}});
  bridge(kAll);
  time.run_for(6s);
  for (std::size_t i = 0; i < names.size(); ++i)
    EXPECT_THAT(faults_of(announced(fmt::format("zigbee-1_d{}", i))), IsEmpty()) << names[i];
}

TEST_F(DiscoveryOf, AnotherBridgeWithOurIdsIsNamed) {
  std::ignore = entities({{"sensor", "temperature-1", "21.5"}});
  send("homeassistant/device/rubicon_6541_zigbee-1_d/config", R"({"o":{"name":"rubicon"},"avty":[{"t":"x/online"}]})",
       true);
  EXPECT_THAT(made->status().reason, HasSubstr("announces devices under our ids"));
}

TEST(HomeAssistantTable, ReadsTheOtherWayRound) {
  EXPECT_EQ(model::entity_class_by("temperature", "°C")->type, "temperature");
  EXPECT_EQ(model::entity_class_by("temperature", "K")->type, "absoluteTemperature");
  EXPECT_EQ(model::entity_class_by("pm25", "\xc2\xb5g/m³")->type, "pm25") << "the micro sign of older ones";
  EXPECT_EQ(model::entity_class_by("nonsense", "°C"), nullptr);
  EXPECT_EQ(model::binary_class_by("moisture")->type, "waterLeak");
  EXPECT_EQ(model::from_entity_unit("kWh"), "kW.h");
  EXPECT_EQ(model::from_entity_unit(""), "1");
  const TypeCatalogue types;
  for (const auto& row : model::entity_classes()) EXPECT_NE(types.find(row.type), nullptr) << row.type;
  for (const auto& row : model::binary_classes()) EXPECT_NE(types.find(row.type), nullptr) << row.type;
}

}  // namespace
}  // namespace rubicon::bridges::mqtt
