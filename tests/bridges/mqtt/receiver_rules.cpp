#include "bridges/mqtt/receiver_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "transport/mqtt.h"

namespace rubicon::bridges::mqtt {

namespace {

using nlohmann::json;
using Names = std::set<std::string>;

const Names kRoot{"dev", "o", "avty", "avty_mode", "qos", "cmps"};
const Names kDevice{"ids", "cns", "mf", "mdl", "mdl_id", "name", "hw", "sw", "sn", "via_device", "sa", "cu"};
const Names kCommon{"p",       "uniq_id",    "name",    "default_entity_id",
                    "ent_cat", "avty",       "dev_cla", "message_expiry_interval",
                    "group",   "json_attr_t"};

struct Platform {
  Names needed, known;
};
const std::map<std::string, Platform> kPlatforms{
    {"sensor", {{"stat_t"}, {"unit_of_meas", "stat_cla", "val_tpl", "ops"}}},
    {"binary_sensor", {{"stat_t"}, {"pl_on", "pl_off", "val_tpl"}}},
    {"switch", {{"cmd_t"}, {"stat_t", "opt", "pl_on", "pl_off", "stat_on", "stat_off", "val_tpl"}}},
    {"select", {{"cmd_t", "ops"}, {"stat_t", "opt", "val_tpl", "cmd_tpl"}}},
    {"number", {{"cmd_t"}, {"stat_t", "opt", "min", "max", "step", "mode", "unit_of_meas", "val_tpl", "cmd_tpl"}}},
    {"text", {{"cmd_t"}, {"stat_t", "val_tpl", "min", "max", "mode", "pattern"}}},
    {"date", {{"cmd_t"}, {"stat_t", "opt", "val_tpl", "cmd_tpl"}}},
    {"time", {{"cmd_t"}, {"stat_t", "opt", "val_tpl", "cmd_tpl"}}},
    {"datetime", {{"cmd_t"}, {"stat_t", "opt", "val_tpl", "cmd_tpl", "timezone"}}},
    {"button", {{"cmd_t"}, {"pl_prs"}}},
    {"event", {{"stat_t", "event_types"}, {"val_tpl"}}},
    {"light",
     {{"cmd_t"},
      {"stat_t",
       "opt",
       "pl_on",
       "pl_off",
       "stat_val_tpl",
       "on_cmd_type",
       "bri_cmd_t",
       "bri_stat_t",
       "bri_scl",
       "clr_temp_cmd_t",
       "clr_temp_stat_t",
       "color_temp_kelvin",
       "min_kelvin",
       "max_kelvin",
       "min_mireds",
       "max_mireds",
       "xy_cmd_t",
       "xy_stat_t",
       "xy_command_template",
       "xy_val_tpl",
       "hs_cmd_t",
       "hs_stat_t",
       "hs_command_template",
       "hs_val_tpl",
       "rgb_cmd_t",
       "rgb_stat_t",
       "rgb_command_template",
       "rgb_val_tpl"}}},
    {"cover",
     {{},
      {"stat_t", "opt", "cmd_t", "pl_open", "pl_cls", "pl_stop", "pos_t", "set_pos_t", "pos_open", "pos_clsd",
       "tilt_cmd_t", "tilt_status_t", "tilt_opnd_val", "tilt_clsd_val"}}},
    {"climate",
     {{}, {"opt",         "modes",          "mode_cmd_t",     "mode_stat_t", "mode_cmd_tpl",  "mode_stat_tpl",
           "temp_cmd_t",  "temp_stat_t",    "temp_unit",      "min_temp",    "max_temp",      "temp_step",
           "curr_temp_t", "act_t",          "act_tpl",        "pr_modes",    "pr_mode_cmd_t", "pr_mode_stat_t",
           "fan_modes",   "fan_mode_cmd_t", "fan_mode_stat_t"}}},
    {"lock", {{"cmd_t"}, {"stat_t", "opt", "pl_lock", "pl_unlk", "stat_locked", "stat_unlocked"}}},
    {"valve", {{"cmd_t"}, {"stat_t", "opt", "reports_position", "pl_open", "pl_cls", "stat_open", "stat_clsd"}}},
    {"fan", {{"cmd_t"}, {"stat_t", "opt", "pl_on", "pl_off", "pct_cmd_t", "pct_stat_t"}}},
    {"siren",
     {{"cmd_t"},
      {"stat_t", "opt", "pl_on", "pl_off", "stat_on", "stat_off", "cmd_tpl", "sup_dur", "sup_vol", "av_tones"}}},
};

/// Units of sensors and numbers by class; an empty unit = none.
const std::map<std::string, Names> kUnits{
    {"absolute_humidity", {"g/m³", "mg/m³"}},
    {"apparent_power", {"mVA", "VA", "kVA"}},
    {"aqi", {""}},
    {"area", {"m²", "cm²", "km²"}},
    {"atmospheric_pressure", {"hPa", "Pa", "kPa", "mbar"}},
    {"battery", {"%"}},
    {"carbon_dioxide", {"ppm"}},
    {"carbon_monoxide", {"ppm", "mg/m³"}},
    {"conductivity", {"μS/cm", "mS/cm", "S/cm"}},
    {"current", {"A", "mA"}},
    {"distance", {"m", "km", "cm", "mm"}},
    {"duration", {"s", "h", "min", "d", "ms"}},
    {"energy", {"kWh", "Wh", "MWh", "J"}},
    {"frequency", {"Hz", "kHz"}},
    {"gas", {"m³", "L"}},
    {"humidity", {"%"}},
    {"illuminance", {"lx"}},
    {"irradiance", {"W/m²"}},
    {"moisture", {"%"}},
    {"ph", {""}},
    {"pm1", {"μg/m³"}},
    {"pm10", {"μg/m³"}},
    {"pm25", {"μg/m³"}},
    {"power", {"W", "kW"}},
    {"power_factor", {"", "%"}},
    {"precipitation", {"mm", "cm"}},
    {"precipitation_intensity", {"mm/h", "mm/d"}},
    {"pressure", {"Pa", "hPa", "kPa", "bar"}},
    {"reactive_energy", {"varh", "kvarh"}},
    {"reactive_power", {"var", "kvar"}},
    {"signal_strength", {"dB", "dBm"}},
    {"sound_pressure", {"dB", "dBA"}},
    {"speed", {"m/s", "km/h"}},
    {"temperature", {"°C", "K", "°F"}},
    {"temperature_delta", {"K", "°C", "°F"}},
    {"volatile_organic_compounds_parts", {"ppm", "ppb"}},
    {"voltage", {"V", "mV"}},
    {"volume_flow_rate", {"m³/h", "L/min"}},
    {"volume_storage", {"m³", "L"}},
    {"water", {"m³", "L"}},
    {"weight", {"kg", "g"}},
    {"wind_direction", {"°"}},
    {"wind_speed", {"m/s", "km/h"}},
};
const Names kBinary{"battery",
                    "battery_charging",
                    "carbon_monoxide",
                    "cold",
                    "connectivity",
                    "door",
                    "gas",
                    "heat",
                    "light",
                    "lock",
                    "moisture",
                    "motion",
                    "moving",
                    "occupancy",
                    "opening",
                    "plug",
                    "power",
                    "presence",
                    "problem",
                    "running",
                    "safety",
                    "smoke",
                    "sound",
                    "tamper",
                    "update",
                    "vibration",
                    "window"};
const Names kCovers{"blind", "damper", "garage", "window", "shutter", "gate"};
const Names kEvents{"button", "doorbell", "motion"};
const Names kModes{"auto", "off", "cool", "heat", "dry", "fan_only", "heat_cool"};

class Check {
 public:
  std::vector<std::string> faults;

  void device_of(const json& message) {
    keys("root", message, kRoot);
    if (!message.value("o", json::object()).contains("name")) say("o has no name");
    const auto device = message.value("dev", json::object());
    keys("dev", device, kDevice);
    if (!device.contains("ids") || device["ids"].empty()) say("dev has no ids");
    const auto components = message.value("cmps", json::object());
    if (components.empty()) say("no components");
    availability("root", message.value("avty", json::array()));
    for (const auto& [id, component] : components.items()) entity(id, component);
  }

 private:
  void say(std::string text) { faults.push_back(std::move(text)); }

  void keys(const std::string& where, const json& object, const Names& known) {
    for (const auto& [key, value] : object.items()) {
      if (!known.contains(key)) say(fmt::format("{}: unknown key {}", where, key));
    }
  }

  void availability(const std::string& where, const json& list) {
    if (!list.is_array() || list.empty()) return say(where + ": no availability");
    for (const auto& one : list) {
      if (!one.contains("t") || !transport::is_mqtt_topic(one["t"].get<std::string>())) say(where + ": bad topic");
    }
  }

  void entity(const std::string& id, const json& body) {
    const auto platform = body.value("p", "");
    const auto found = kPlatforms.find(platform);
    if (found == kPlatforms.end()) return say(fmt::format("{}: unknown platform {}", id, platform));
    auto known = found->second.known;
    known.insert(found->second.needed.begin(), found->second.needed.end());
    known.insert(kCommon.begin(), kCommon.end());
    keys(id, body, known);
    for (const auto& key : found->second.needed) {
      if (!body.contains(key)) say(fmt::format("{}: {} needs {}", id, platform, key));
    }
    if (body.contains("avty")) availability(id, body["avty"]);
    ids(id, platform, body);
    topics(id, body);
    category(id, platform, body);
    if (platform == "sensor" || platform == "number") quantity(id, platform, body);
    if (platform == "binary_sensor") one_of(id, body, "dev_cla", kBinary);
    if (platform == "cover") cover(id, body);
    if (platform == "event") event(id, body);
    if (platform == "valve" && body.value("reports_position", false) &&
        (body.contains("pl_open") || body.contains("pl_cls") || body.contains("stat_open")))
      say(id + ": a valve with positions has no words");
    if (platform == "climate") climate(id, body);
    if (body.contains("group") && (!body["group"].is_array() || body["group"].empty())) say(id + ": an empty group");
    if (platform == "select" && body.value("ops", json::array()).empty()) say(id + ": no options");
    if (body.contains("opt") && body["opt"] != false) say(id + ": optimistic");
  }

  void ids(const std::string& id, const std::string& platform, const json& body) {
    const auto legal = [](const std::string& text, const std::string& more) {
      return !text.empty() &&
             text.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-" + more) ==
                 text.npos;
    };
    if (!legal(id, "")) say(id + ": no legal id");
    const auto unique = body.value("uniq_id", "");
    if (!legal(unique, "") || !unique_.insert(unique).second) say(id + ": uniq_id is not unique");
    const auto entity_id = body.value("default_entity_id", "");
    if (!legal(entity_id, ".") || !entity_id.starts_with(platform + ".") || entity_id.size() == platform.size() + 1)
      say(fmt::format("{}: entity id {}", id, entity_id));
    if (!body.contains("name") || (!body["name"].is_null() && body["name"].get<std::string>().empty()))
      say(id + ": no name");
  }

  void topics(const std::string& id, const json& body) {
    for (const auto& [key, value] : body.items()) {
      const bool topic = key.ends_with("_t") && value.is_string();
      if (topic && !transport::is_mqtt_topic(value.get<std::string>()))
        say(fmt::format("{}: {} is not a topic", id, key));
      if (topic && key.ends_with("cmd_t") && !value.get<std::string>().ends_with("/set"))
        say(fmt::format("{}: {} is not a command", id, key));
    }
  }

  void category(const std::string& id, const std::string& platform, const json& body) {
    one_of(id, body, "ent_cat", {"config", "diagnostic"});
    if ((platform == "sensor" || platform == "binary_sensor") && body.value("ent_cat", "") == "config")
      say(id + ": what is only shown has no category config");
  }

  void one_of(const std::string& id, const json& body, const char* key, const Names& words) {
    if (body.contains(key) && !words.contains(body[key].get<std::string>()))
      say(fmt::format("{}: {} is {}", id, key, body[key].dump()));
  }

  void quantity(const std::string& id, const std::string& platform, const json& body) {
    const auto unit = body.value("unit_of_meas", ""), device_class = body.value("dev_cla", "");
    if (body.contains("ops") && platform == "sensor" &&
        (device_class != "enum" || body.contains("unit_of_meas") || body.contains("stat_cla")))
      say(id + ": options without class enum, or with a unit");
    const bool clock = device_class == "date" || device_class == "timestamp";
    if (clock && (body.contains("unit_of_meas") || body.contains("stat_cla"))) say(id + ": a time with a unit");
    if (!device_class.empty() && device_class != "enum" && !clock) {
      const auto units = kUnits.find(device_class);
      if (units == kUnits.end())
        say(fmt::format("{}: unknown class {}", id, device_class));
      else if (!units->second.contains(unit))
        say(fmt::format("{}: class {} has no unit '{}'", id, device_class, unit));
    }
    one_of(id, body, "stat_cla", {"measurement", "measurement_angle", "total", "total_increasing"});
    if (body.value("stat_cla", "") == "measurement_angle" && unit != "°") say(id + ": an angle without °");
    if (platform != "number") return;
    if (body.value("min", 1.0) > body.value("max", 100.0)) say(id + ": min is above max");
    if (body.value("step", 1.0) < 0.001) say(id + ": step below 0.001");
    one_of(id, body, "mode", {"auto", "box", "slider"});
  }

  void cover(const std::string& id, const json& body) {
    one_of(id, body, "dev_cla", kCovers);
    if (body.contains("set_pos_t") && !body.contains("pos_t")) say(id + ": set_pos_t without pos_t");
    if (!body.contains("cmd_t") && !body.contains("set_pos_t")) say(id + ": cannot be moved");
    for (const auto* key : {"pos_open", "pos_clsd", "tilt_opnd_val", "tilt_clsd_val"}) {
      if (body.contains(key) && !body[key].is_number_integer()) say(fmt::format("{}: {} is no integer", id, key));
    }
  }

  void climate(const std::string& id, const json& body) {
    for (const auto& mode : body.value("modes", json::array())) {
      if (!kModes.contains(mode.get<std::string>())) say(fmt::format("{}: unknown mode {}", id, mode.dump()));
    }
    const auto presets = body.value("pr_modes", json::array());
    if (presets.empty() != !body.contains("pr_mode_cmd_t")) say(id + ": presets need a list and a topic");
    for (const auto& preset : presets) {
      if (preset == "none") say(id + ": none is no preset of its own");
    }
  }

  void event(const std::string& id, const json& body) {
    one_of(id, body, "dev_cla", kEvents);
    if (body.value("event_types", json::array()).empty()) say(id + ": no event types");
  }

  Names unique_;
};

}  // namespace

std::vector<std::string> faults_of(const nlohmann::json& message) {
  Check check;
  check.device_of(message);
  return check.faults;
}

}  // namespace rubicon::bridges::mqtt
