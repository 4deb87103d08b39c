#include "apps/simulators/zigbee/device_model.h"

#include <algorithm>
#include <array>

#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::zigbee_simulator {

namespace {

using Json = nlohmann::json;

constexpr auto kLinkQuality = R"json({"type":"numeric","name":"linkquality","property":"linkquality","access":1,
  "category":"diagnostic","label":"Linkquality","description":"Link quality (signal strength)","unit":"lqi",
  "value_min":0,"value_max":255})json";

Json list_of(const Json& tree, const char* name) {
  const auto found = tree.find(name);
  return found == tree.end() ? Json::array() : *found;
}

Json object_of(const Json& tree, const char* name) {
  const auto found = tree.find(name);
  return found == tree.end() ? Json::object() : *found;
}

Json endpoint(const Json& model, bool first) {
  auto reportings = Json::array(), bindings = Json::array();
  std::set<std::string> bound;
  for (const auto& one : first ? list_of(model, "reporting") : Json::array()) {
    reportings.push_back({{"cluster", one[0]},
                          {"attribute", one[1]},
                          {"minimum_report_interval", one[2]},
                          {"maximum_report_interval", one[3]},
                          {"reportable_change", one[4]}});
    if (bound.insert(one[0]).second)
      bindings.push_back({{"cluster", one[0]},
                          {"target", {{"endpoint", 1}, {"ieee_address", "0x00124b00deadbeef"}, {"type", "endpoint"}}}});
  }
  return {{"bindings", bindings},
          {"clusters", {{"input", list_of(model, "input")}, {"output", list_of(model, "output")}}},
          {"configured_reportings", reportings},
          {"scenes", Json::array()}};
}

Json endpoints(const Json& model) {
  const auto names = list_of(model, "endpoints");
  auto all = Json::object();
  for (std::size_t i = 0; i < std::max<std::size_t>(names.size(), 1); ++i) {
    auto& made = all[std::to_string(i + 1)] = endpoint(model, i == 0);
    if (i < names.size()) made["name"] = names[i];
  }
  return all;
}

void add_leaves(DeviceModel& model) {
  for (auto& leaf : leaves_of(model.definition["exposes"])) {
    const auto property = leaf.value("property", "");
    model.leaves[property].push_back(std::move(leaf));
  }
}

int access_bits(const Json& leaf) {
  const auto found = leaf.find("access");
  return found != leaf.end() && found->is_number_integer() ? found->get<int>() : 0;
}

bool accepts_number(const Json& leaf, const Json& value) {
  if (!value.is_number()) return false;
  const auto number = value.get<double>();
  for (const auto& preset : list_of(leaf, "presets")) {
    if (preset["value"] == value) return true;
  }
  return number >= leaf.value("value_min", number) && number <= leaf.value("value_max", number);
}

}  // namespace

bool is_published(const Json& leaf) {
  return (access_bits(leaf) & 1) != 0;
}
bool is_settable(const Json& leaf) {
  return (access_bits(leaf) & 2) != 0;
}
bool is_gettable(const Json& leaf) {
  return (access_bits(leaf) & 4) != 0;
}

bool accepts(const Json& leaf, const Json& value) {
  const auto type = leaf.value("type", "");
  if (type == "numeric") return accepts_number(leaf, value);
  if (type == "binary")
    return value == leaf["value_on"] || value == leaf["value_off"] || value == list_of(leaf, "value_toggle");
  if (type == "text") return value.is_string();
  if (type == "list") return value.is_array();
  if (type == "composite") return value.is_object();
  const auto words = list_of(leaf, "values");
  return std::find(words.begin(), words.end(), value) != words.end();
}

DeviceModel read_model(std::string_view json) {
  const auto tree = model::object_of(json);
  DeviceModel model;
  auto exposes = list_of(tree, "exposes");
  exposes.push_back(model::parse_json(kLinkQuality));
  model.definition = {{"model", tree["model"]},
                      {"vendor", tree["vendor"]},
                      {"description", tree["description"]},
                      {"exposes", std::move(exposes)},
                      {"options", list_of(tree, "options")},
                      {"source", "native"},
                      {"supports_ota", model::flag_of(tree, "supports_ota")},
                      {"version", "0.0.0"}};
  model.manufacturer = model::text_of(tree, "manufacturer");
  model.model_id = model::text_of(tree, "model_id");
  model.battery = model::flag_of(tree, "battery");
  model.sleeps = model.battery && !model::flag_of(tree, "awake");
  model.endpoints = endpoints(tree);
  const auto clusters = object_of(tree, "cluster"), walks = object_of(tree, "walk");
  for (const auto& [property, cluster] : clusters.items()) model.cluster[property] = cluster;
  for (const auto& [property, walk] : walks.items()) model.walk[property] = walk;
  model.values = object_of(tree, "values");
  model.known = object_of(tree, "known");
  for (auto& property : model::texts_of(tree, "no_echo")) model.no_echo.insert(std::move(property));
  if (const auto clears = list_of(tree, "clears"); clears.size() == 3)
    model.clears = {clears[0], clears[1], std::chrono::seconds(clears[2].get<int>())};
  add_leaves(model);
  return model;
}

DeviceModel make_model(DefinitionGenerator& generator, std::uint32_t index) {
  auto record = generator.device_record(index);
  DeviceModel model;
  model.definition = record.value("definition", Json());
  if (!model.definition.is_object())
    model.definition = Json{{"exposes", Json::array()}, {"model", "none"}, {"vendor", "none"}};
  model.manufacturer = model::text_of(record, "manufacturer");
  model.model_id = model::text_of(record, "model_id");
  model.battery = record["type"] == "EndDevice";
  model.sleeps = model.battery;
  model.endpoints = record["endpoints"];
  model.values = generator.state_of(model.definition["exposes"]);
  model.values.erase("linkquality");
  model.known = Json::object();
  add_leaves(model);
  for (const auto& [property, leaves] : model.leaves) {
    const auto& leaf = leaves.front();
    if (leaf["type"] != "numeric" || is_settable(leaf) || !is_published(leaf)) continue;
    const double low = leaf.value("value_min", 0.0);
    const double high = std::max(low, leaf.value("value_max", low + 100));
    model.walk[property] = {low, high, (high - low) / 10};
  }
  return model;
}

// Models as Zigbee2MQTT 2.14 lists them, shortened. `cluster`: the properties that the device reports together;
// `walk`: how measured values vary: lowest, highest, largest step.
namespace {

struct BuiltIn {
  std::string_view name, json;
};

constexpr auto kBuiltIn = std::to_array<BuiltIn>({
    {"lamp", R"json({"model":"9290012573A","vendor":"Philips","description":"Hue white and color ambiance E26/E27/E14",
"manufacturer":"Signify Netherlands B.V.","model_id":"LCT015","supports_ota":true,
"input":["genBasic","genIdentify","genGroups","genScenes","genOnOff","genLevelCtrl","lightingColorCtrl"],
"exposes":[{"type":"light","features":[
 {"type":"binary","name":"state","property":"state","access":7,"label":"State","value_on":"ON","value_off":"OFF","value_toggle":"TOGGLE"},
 {"type":"numeric","name":"brightness","property":"brightness","access":7,"label":"Brightness","value_min":0,"value_max":254},
 {"type":"numeric","name":"color_temp","property":"color_temp","access":7,"label":"Color temp","unit":"mired","value_min":153,"value_max":500,
  "presets":[{"name":"coolest","value":153,"description":"Coolest temperature supported"},{"name":"warmest","value":500,"description":"Warmest temperature supported"}]},
 {"type":"numeric","name":"color_temp_startup","property":"color_temp_startup","access":7,"label":"Color temp startup","unit":"mired","value_min":153,"value_max":500,
  "presets":[{"name":"coolest","value":153},{"name":"previous","value":65535}]},
 {"type":"composite","name":"color_xy","property":"color","access":7,"label":"Color (X/Y)","features":[
  {"type":"numeric","name":"x","property":"x","access":7,"label":"X"},{"type":"numeric","name":"y","property":"y","access":7,"label":"Y"}]},
 {"type":"composite","name":"color_hs","property":"color","access":7,"label":"Color (HS)","features":[
  {"type":"numeric","name":"hue","property":"hue","access":7,"label":"Hue"},{"type":"numeric","name":"saturation","property":"saturation","access":7,"label":"Saturation"}]}]},
 {"type":"enum","name":"power_on_behavior","property":"power_on_behavior","access":7,"category":"config","label":"Power-on behavior","values":["off","on","toggle","previous"]},
 {"type":"enum","name":"effect","property":"effect","access":2,"label":"Effect","values":["blink","breathe","okay","colorloop","finish_effect","stop_effect"]}],
"options":[{"type":"numeric","name":"transition","property":"transition","access":2,"label":"Transition","value_min":0}],
"cluster":{"state":"genOnOff","brightness":"genLevelCtrl","color_temp":"lightingColorCtrl","color":"lightingColorCtrl","color_mode":"lightingColorCtrl"},
"values":{"state":"OFF","brightness":254,"color_temp":370,"color_temp_startup":370,"color":{"x":0.4575,"y":0.4099},"color_mode":"color_temp","power_on_behavior":"on"},
"known":{}})json"},

    {"plug",
     R"json({"model":"SP 120","vendor":"Innr","description":"Smart plug","manufacturer":"innr","model_id":"SP 120","supports_ota":true,
"input":["genBasic","genIdentify","genGroups","genScenes","genOnOff","genLevelCtrl","haElectricalMeasurement","seMetering"],
"exposes":[{"type":"switch","features":[
 {"type":"binary","name":"state","property":"state","access":7,"label":"State","value_on":"ON","value_off":"OFF","value_toggle":"TOGGLE"}]},
 {"type":"numeric","name":"power","property":"power","access":5,"label":"Power","unit":"W"},
 {"type":"numeric","name":"voltage","property":"voltage","access":5,"label":"Voltage","unit":"V"},
 {"type":"numeric","name":"current","property":"current","access":5,"label":"Current","unit":"A"},
 {"type":"numeric","name":"energy","property":"energy","access":5,"label":"Energy","unit":"kWh"}],
"options":[{"type":"numeric","name":"power_calibration","property":"power_calibration","access":2,"label":"Power calibration","value_step":0.1}],
"reporting":[["genOnOff","onOff",0,65000,1],["haElectricalMeasurement","activePower",10,65000,5],["haElectricalMeasurement","rmsCurrent",10,65000,50],
 ["haElectricalMeasurement","rmsVoltage",10,65000,5],["seMetering","currentSummDelivered",10,65000,10]],
"cluster":{"state":"genOnOff","power":"haElectricalMeasurement","voltage":"haElectricalMeasurement","current":"haElectricalMeasurement","energy":"seMetering"},
"values":{"state":"ON","power":109,"voltage":230,"current":0.5,"energy":12},
"walk":{"power":[60,140,12]}})json"},

    {"thermometer",
     R"json({"model":"SNZB-02_eWeLink","vendor":"eWeLink","description":"Temperature and humidity sensor","manufacturer":"eWeLink","model_id":"SNZB-02","battery":true,
"input":["genBasic","genPowerCfg","genIdentify","msTemperatureMeasurement","msRelativeHumidity"],
"exposes":[{"type":"numeric","name":"battery","property":"battery","access":1,"category":"diagnostic","label":"Battery","unit":"%","value_min":0,"value_max":100},
 {"type":"numeric","name":"temperature","property":"temperature","access":1,"label":"Temperature","unit":"°C"},
 {"type":"numeric","name":"humidity","property":"humidity","access":1,"label":"Humidity","unit":"%"},
 {"type":"numeric","name":"voltage","property":"voltage","access":1,"category":"diagnostic","label":"Voltage","unit":"mV"}],
"options":[{"type":"numeric","name":"temperature_calibration","property":"temperature_calibration","access":2,"label":"Temperature calibration","value_step":0.1}],
"reporting":[["msTemperatureMeasurement","measuredValue",30,3600,20],["msRelativeHumidity","measuredValue",30,3600,100],["genPowerCfg","batteryVoltage",3600,65000,0],["genPowerCfg","batteryPercentageRemaining",3600,65000,0]],
"cluster":{"temperature":"msTemperatureMeasurement","humidity":"msRelativeHumidity","battery":"genPowerCfg","voltage":"genPowerCfg"},
"values":{"battery":90,"temperature":21.41,"humidity":44.81,"voltage":3000},
"walk":{"temperature":[19,24,0.12],"humidity":[40,55,0.6]}})json"},

    {"motion",
     R"json({"model":"RTCGQ11LM","vendor":"Aqara","description":"Motion sensor","manufacturer":"LUMI","model_id":"lumi.sensor_motion.aq2","battery":true,
"input":["genBasic","genIdentify","msIlluminanceMeasurement","msOccupancySensing"],
"exposes":[{"type":"numeric","name":"battery","property":"battery","access":1,"category":"diagnostic","label":"Battery","unit":"%","value_min":0,"value_max":100},
 {"type":"binary","name":"occupancy","property":"occupancy","access":1,"label":"Occupancy","value_on":true,"value_off":false},
 {"type":"numeric","name":"device_temperature","property":"device_temperature","access":1,"category":"diagnostic","label":"Device temperature","unit":"°C"},
 {"type":"numeric","name":"voltage","property":"voltage","access":1,"category":"diagnostic","label":"Voltage","unit":"mV"},
 {"type":"numeric","name":"illuminance","property":"illuminance","access":1,"label":"Illuminance","unit":"lx"},
 {"type":"numeric","name":"power_outage_count","property":"power_outage_count","access":1,"category":"diagnostic","label":"Power outage count"}],
"options":[{"type":"numeric","name":"occupancy_timeout","property":"occupancy_timeout","access":2,"label":"Occupancy timeout","value_min":0}],
"cluster":{"illuminance":"msIlluminanceMeasurement","occupancy":"msOccupancySensing"},
"values":{"battery":100,"occupancy":false,"device_temperature":24,"voltage":3015,"illuminance":240,"power_outage_count":3},
"walk":{"illuminance":[20,900,200]},
"clears":["occupancy",false,90]})json"},

    {"contact",
     R"json({"model":"MCCGQ11LM","vendor":"Aqara","description":"Door and window sensor","manufacturer":"LUMI","model_id":"lumi.sensor_magnet.aq2","battery":true,
"input":["genBasic","genIdentify","genOnOff"],
"exposes":[{"type":"numeric","name":"battery","property":"battery","access":1,"category":"diagnostic","label":"Battery","unit":"%","value_min":0,"value_max":100},
 {"type":"binary","name":"contact","property":"contact","access":1,"label":"Contact","value_on":false,"value_off":true},
 {"type":"numeric","name":"device_temperature","property":"device_temperature","access":1,"category":"diagnostic","label":"Device temperature","unit":"°C"},
 {"type":"numeric","name":"voltage","property":"voltage","access":1,"category":"diagnostic","label":"Voltage","unit":"mV"},
 {"type":"numeric","name":"power_outage_count","property":"power_outage_count","access":1,"category":"diagnostic","label":"Power outage count"},
 {"type":"numeric","name":"trigger_count","property":"trigger_count","access":1,"category":"diagnostic","label":"Trigger count"},
 {"type":"enum","name":"identify","property":"identify","access":2,"category":"config","label":"Identify","values":["identify"]}],
"options":[{"type":"numeric","name":"identify_timeout","property":"identify_timeout","access":2,"label":"Identify timeout","value_min":1,"value_max":30}],
"cluster":{"contact":"genOnOff"},
"values":{"contact":true,"battery":97,"device_temperature":22,"voltage":3005,"power_outage_count":1,"trigger_count":12}})json"},

    {"cover",
     R"json({"model":"J1 (5502)","vendor":"Ubisys","description":"Shutter control J1","manufacturer":"ubisys","model_id":"J1 (5502)",
"input":["genBasic","genIdentify","genGroups","genScenes","closuresWindowCovering"],
"exposes":[{"type":"cover","features":[
 {"type":"enum","name":"state","property":"state","access":3,"label":"State","values":["OPEN","CLOSE","STOP"]},
 {"type":"numeric","name":"position","property":"position","access":7,"label":"Position","unit":"%","value_min":0,"value_max":100},
 {"type":"numeric","name":"tilt","property":"tilt","access":7,"label":"Tilt","unit":"%","value_min":0,"value_max":100}]}],
"options":[{"type":"binary","name":"invert_cover","property":"invert_cover","access":2,"label":"Invert cover","value_on":true,"value_off":false}],
"reporting":[["closuresWindowCovering","currentPositionLiftPercentage",1,65000,1]],
"cluster":{"state":"closuresWindowCovering","position":"closuresWindowCovering","tilt":"closuresWindowCovering"},
"values":{"state":"OPEN","position":100,"tilt":100},
"no_echo":["state"]})json"},

    {"lock",
     R"json({"model":"YRD426NRSC","vendor":"Yale","description":"Assure lock","manufacturer":"Yale","model_id":"YRD446 BLE TSDB","battery":true,"awake":true,
"input":["genBasic","genPowerCfg","genIdentify","closuresDoorLock"],
"exposes":[{"type":"lock","features":[
 {"type":"binary","name":"state","property":"state","access":7,"label":"State","value_on":"LOCK","value_off":"UNLOCK"},
 {"type":"enum","name":"lock_state","property":"lock_state","access":1,"label":"Lock state","values":["not_fully_locked","locked","unlocked"]}]},
 {"type":"numeric","name":"battery","property":"battery","access":1,"category":"diagnostic","label":"Battery","unit":"%","value_min":0,"value_max":100}],
"options":[],
"reporting":[["closuresDoorLock","lockState",0,3600,0]],
"cluster":{"state":"closuresDoorLock","lock_state":"closuresDoorLock"},
"values":{"state":"LOCK","lock_state":"locked","battery":80},
"no_echo":["state"]})json"},

    {"trv",
     R"json({"model":"014G2461","vendor":"Danfoss","description":"Ally thermostat","manufacturer":"Danfoss","model_id":"eTRV0100","battery":true,
"input":["genBasic","genPowerCfg","genIdentify","genTime","hvacThermostat"],
"exposes":[{"type":"climate","features":[
 {"type":"numeric","name":"occupied_heating_setpoint","property":"occupied_heating_setpoint","access":7,"label":"Occupied heating setpoint","unit":"°C","value_min":5,"value_max":35,"value_step":0.5},
 {"type":"numeric","name":"local_temperature","property":"local_temperature","access":5,"label":"Local temperature","unit":"°C"},
 {"type":"enum","name":"system_mode","property":"system_mode","access":7,"label":"System mode","values":["off","heat","auto"]},
 {"type":"enum","name":"running_state","property":"running_state","access":5,"label":"Running state","values":["idle","heat"]},
 {"type":"numeric","name":"pi_heating_demand","property":"pi_heating_demand","access":5,"label":"PI heating demand","unit":"%","value_min":0,"value_max":100}]},
 {"type":"binary","name":"mounted_mode_control","property":"mounted_mode_control","access":7,"category":"config","label":"Mounted mode control","value_on":true,"value_off":false},
 {"type":"numeric","name":"battery","property":"battery","access":1,"category":"diagnostic","label":"Battery","unit":"%","value_min":0,"value_max":100}],
"options":[],
"reporting":[["hvacThermostat","localTemp",60,3600,25],["hvacThermostat","occupiedHeatingSetpoint",0,3600,10]],
"cluster":{"occupied_heating_setpoint":"setpoint","local_temperature":"localTemp","system_mode":"setpoint","running_state":"demand","pi_heating_demand":"demand"},
"values":{"occupied_heating_setpoint":21,"local_temperature":20.4,"system_mode":"heat","running_state":"idle","pi_heating_demand":12,"mounted_mode_control":true,"battery":71},
"walk":{"local_temperature":[18,23,0.2],"pi_heating_demand":[0,100,9]}})json"},

    {"remote",
     R"json({"model":"E1524/E1810","vendor":"IKEA","description":"TRADFRI remote control","manufacturer":"IKEA of Sweden","model_id":"TRADFRI remote control","battery":true,"supports_ota":true,
"input":["genBasic","genPowerCfg","genIdentify"],"output":["genScenes","genOnOff","genLevelCtrl"],
"exposes":[{"type":"numeric","name":"battery","property":"battery","access":1,"category":"diagnostic","label":"Battery","unit":"%","value_min":0,"value_max":100},
 {"type":"enum","name":"action","property":"action","access":1,"category":"diagnostic","label":"Action","values":["toggle","brightness_up_click","brightness_down_click","brightness_up_hold","brightness_up_release","arrow_left_click","arrow_right_click"]}],
"options":[],
"reporting":[["genPowerCfg","batteryPercentageRemaining",3600,65000,0]],
"values":{"battery":74}})json"},

    {"switch",
     R"json({"model":"TS0012","vendor":"TuYa","description":"2-gang switch","manufacturer":"_TZ3000_jl7qyupf","model_id":"TS0012","supports_ota":true,
"input":["genBasic","genIdentify","genGroups","genScenes","genOnOff"],"endpoints":["left","right"],
"exposes":[{"type":"switch","endpoint":"left","features":[
 {"type":"binary","name":"state","endpoint":"left","property":"state_left","access":7,"label":"State","value_on":"ON","value_off":"OFF","value_toggle":"TOGGLE"}]},
 {"type":"switch","endpoint":"right","features":[
 {"type":"binary","name":"state","endpoint":"right","property":"state_right","access":7,"label":"State","value_on":"ON","value_off":"OFF","value_toggle":"TOGGLE"}]},
 {"type":"enum","name":"power_on_behavior","endpoint":"left","property":"power_on_behavior_left","access":7,"category":"config","label":"Power-on behavior","values":["off","on","previous"]}],
"options":[],
"cluster":{"state_left":"genOnOff 1","state_right":"genOnOff 2"},
"values":{"state_left":"OFF","state_right":"OFF","power_on_behavior_left":"previous"},
"known":{"update":{"installed_version":77,"latest_version":77,"state":"idle"}}})json"},

    {"relay",
     R"json({"model":"BASICZBR3","vendor":"SONOFF","description":"Zigbee smart switch","manufacturer":"SONOFF","model_id":"BASICZBR3",
"input":["genBasic","genIdentify","genGroups","genScenes","genOnOff"],
"exposes":[{"type":"switch","features":[
 {"type":"binary","name":"state","property":"state","access":7,"label":"State","value_on":"ON","value_off":"OFF","value_toggle":"TOGGLE"}]}],
"options":[{"type":"binary","name":"state_action","property":"state_action","access":2,"label":"State action","value_on":true,"value_off":false}],
"cluster":{"state":"genOnOff"},
"values":{"state":"OFF"}})json"},

    {"weather",
     R"json({"model":"WSDCGQ11LM","vendor":"Aqara","description":"Temperature and humidity sensor","manufacturer":"LUMI","model_id":"lumi.weather","battery":true,
"input":["genBasic","genIdentify","msTemperatureMeasurement","msPressureMeasurement","msRelativeHumidity"],
"exposes":[{"type":"numeric","name":"battery","property":"battery","access":1,"category":"diagnostic","label":"Battery","unit":"%","value_min":0,"value_max":100},
 {"type":"numeric","name":"temperature","property":"temperature","access":1,"label":"Temperature","unit":"°C"},
 {"type":"numeric","name":"humidity","property":"humidity","access":1,"label":"Humidity","unit":"%"},
 {"type":"numeric","name":"pressure","property":"pressure","access":1,"label":"Pressure","unit":"hPa"},
 {"type":"numeric","name":"voltage","property":"voltage","access":1,"category":"diagnostic","label":"Voltage","unit":"mV"}],
"options":[],
"cluster":{"temperature":"msTemperatureMeasurement","humidity":"msRelativeHumidity","pressure":"msPressureMeasurement","battery":"genBasic","voltage":"genBasic"},
"values":{"battery":88,"temperature":17.2,"humidity":61.5,"pressure":1009.4,"voltage":2985},
"walk":{"temperature":[12,22,0.3],"humidity":[50,75,0.8],"pressure":[980,1030,0.4]}})json"},
});

}  // namespace

std::vector<std::string> model_names() {
  std::vector<std::string> names;
  for (const auto& one : kBuiltIn) names.emplace_back(one.name);
  return names;
}

std::optional<DeviceModel> find_model(std::string_view name) {
  for (const auto& one : kBuiltIn) {
    if (one.name == name) return read_model(one.json);
  }
  return std::nullopt;
}

}  // namespace rubicon::zigbee_simulator
