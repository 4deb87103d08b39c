#include "apps/simulators/zigbee/radio_device.h"

#include <algorithm>
#include <cmath>

#include "model/json_members.h"

namespace rubicon::zigbee_simulator {

namespace {

using Json = nlohmann::json;

std::string_view interview_state(RadioDevice::Stage stage) {
  using Stage = RadioDevice::Stage;
  if (stage == Stage::kFailed) return "FAILED";
  return stage >= Stage::kInterviewed ? "SUCCESSFUL" : "IN_PROGRESS";
}

Json as_json(double number) {
  const double rounded = std::round(number * 100) / 100;
  return rounded == std::floor(rounded) ? Json(std::llround(rounded)) : Json(rounded);
}

/// Whether Zigbee2MQTT never caches the property (zigbee.md, section 5).
bool is_fleeting(std::string_view property) {
  return property == "action" || property.starts_with("action_") || property == "button" || property == "step_size" ||
         property == "transition_time" || property == "no_occupancy_since" || property == "elapsed";
}

}  // namespace

RadioDevice::RadioDevice(DeviceModel model, std::string address, std::string name, std::uint16_t network_address)
    : model_(std::move(model)),
      address_(std::move(address)),
      name_(std::move(name)),
      network_address_(network_address),
      real_(model_.values) {}

void RadioDevice::rename(std::string name) {
  name_ = std::move(name);
  text_.clear();
}

void RadioDevice::set_stage(Stage stage) {
  stage_ = stage;
  text_.clear();
}

void RadioDevice::settle(WallTime last_seen) {
  set_stage(Stage::kConfigured);
  joined = true;
  for (const auto& [property, value] : real_.items()) {
    if (!is_fleeting(property)) known_[property] = value;
  }
  last_seen_ = last_seen;
  link_quality_ = 150;
}

const std::string& RadioDevice::record_text() {
  if (text_.empty()) text_ = model::dump(record());
  return text_;
}

Json RadioDevice::record() const {
  const bool failed = stage_ == Stage::kFailed;
  Json record{{"ieee_address", address_},
              {"friendly_name", name_},
              {"network_address", network_address_},
              {"type", stage_ == Stage::kJoined || failed ? "Unknown"
                       : model_.battery                   ? "EndDevice"
                                                          : "Router"},
              {"supported", usable()},
              {"disabled", false},
              {"interview_state", interview_state(stage_)},
              {"interview_completed", usable()},
              {"interviewing", !usable() && !failed},
              {"endpoints", Json::object()}};
  if (failed || stage_ == Stage::kJoined) return record;
  record["endpoints"] = model_.endpoints;
  if (stage_ != Stage::kConfigured) {
    for (auto& endpoint : record["endpoints"]) {
      endpoint["bindings"] = Json::array();
      endpoint["configured_reportings"] = Json::array();
    }
  }
  if (stage_ >= Stage::kModel && !model_.model_id.empty()) record["model_id"] = model_.model_id;
  if (stage_ >= Stage::kManufacturer && !model_.manufacturer.empty()) record["manufacturer"] = model_.manufacturer;
  if (stage_ >= Stage::kPower) record["power_source"] = model_.battery ? "Battery" : "Mains (single phase)";
  if (stage_ >= Stage::kDate) record["date_code"] = "20260101";
  if (!usable()) return record;
  record["software_build_id"] = "1.0.0-sim";
  record["definition"] = model_.definition;
  return record;
}

void RadioDevice::heard(WallTime now, Random& random) {
  const bool first = last_seen_ == WallTime{};
  last_seen_ = now;
  ++messages;
  if (!first) link_quality_ = static_cast<int>(random.between(120, 219));
}

Json RadioDevice::known() const {
  auto state = known_;
  if (usable()) state.update(model_.known);
  if (link_quality_ >= 0) state["linkquality"] = link_quality_;
  return state;
}

void RadioDevice::know_nothing() {
  for (const auto& [property, leaves] : model_.leaves) {
    if (!is_published(leaves.front()) || property == "linkquality" || is_fleeting(property)) continue;
    if (!known_.contains(property)) known_[property] = nullptr;
  }
}

Json RadioDevice::acceptable(const Json& wanted) const {
  auto accepted = Json::object();
  if (!wanted.is_object()) return accepted;
  for (const auto& [property, value] : wanted.items()) {
    const auto leaves = model_.leaves.find(property);
    if (leaves == model_.leaves.end()) continue;
    for (const auto& leaf : leaves->second) {
      if (!is_settable(leaf) || !accepts(leaf, value)) continue;
      const bool toggles = leaf.contains("value_toggle") && value == leaf["value_toggle"];
      const bool on = known_.contains(property) && known_[property] == leaf.value("value_on", Json());
      accepted[property] = toggles ? leaf[on ? "value_off" : "value_on"] : value;
      break;
    }
  }
  return accepted;
}

/// With what a lamp, a cover or a lock does besides.
Json RadioDevice::follows(const Json& accepted) const {
  auto all = accepted;
  const auto has = [&](const char* property) { return accepted.contains(property) && real_.contains(property); };
  if (has("brightness") && real_.contains("state")) all["state"] = accepted["brightness"] == 0 ? "OFF" : "ON";
  if (has("color_temp")) all["color_mode"] = "color_temp";
  if (has("color")) all["color_mode"] = accepted["color"].contains("hue") ? "hs" : "xy";
  if (has("position")) all["state"] = accepted["position"] == 0 ? "CLOSE" : "OPEN";
  if (real_.contains("position") && accepted.contains("state")) {
    if (accepted["state"] == "STOP") all.erase("state");
    if (accepted["state"] == "OPEN") all["position"] = 100;
    if (accepted["state"] == "CLOSE") all["position"] = 0;
  }
  if (real_.contains("lock_state") && accepted.contains("state"))
    all["lock_state"] = accepted["state"] == "LOCK" ? "locked" : "unlocked";
  return all;
}

Json RadioDevice::echo(const Json& accepted) const {
  auto shown = follows(accepted);
  bool hidden = false;
  for (const auto& property : model_.no_echo) hidden = hidden || accepted.contains(property);
  if (hidden) return Json::object();
  for (const auto& [property, value] : accepted.items()) {
    if (!is_published(model_.leaves.at(property).front()) || is_fleeting(property)) shown.erase(property);
  }
  return shown;
}

std::vector<std::string> RadioDevice::execute(const Json& accepted) {
  std::vector<std::string> done;
  const auto all = follows(accepted);
  for (const auto& [property, value] : all.items()) {
    const auto leaf = model_.leaves.find(property);
    if (leaf != model_.leaves.end() && !is_published(leaf->second.front())) continue;
    real_[property] = value;
    done.push_back(property);
  }
  return done;
}

std::vector<std::string> RadioDevice::readable(const Json& asked) const {
  std::vector<std::string> found;
  if (!asked.is_object()) return found;
  for (const auto& [property, value] : asked.items()) {
    const auto leaves = model_.leaves.find(property);
    if (leaves != model_.leaves.end() && is_gettable(leaves->second.front())) found.push_back(property);
  }
  return found;
}

const Json& RadioDevice::real(const std::string& property) const {
  static const Json kNone;
  const auto found = real_.find(property);
  return found == real_.end() ? kNone : *found;
}

void RadioDevice::walk(Random& random) {
  for (const auto& [property, range] : model_.walk) {
    const auto& now = real(property);
    const double from = now.is_number() ? now.get<double>() : (range[0] + range[1]) / 2;
    const double to = std::clamp(from + range[2] * (2 * random.share() - 1), range[0], range[1]);
    real_[property] = now.is_number_integer() ? Json(std::llround(to)) : as_json(to);
  }
}

std::vector<std::vector<std::string>> RadioDevice::by_cluster(const std::vector<std::string>& properties) const {
  std::map<std::string, std::vector<std::string>> found;
  for (const auto& property : properties) {
    const auto cluster = model_.cluster.find(property);
    found[cluster == model_.cluster.end() ? " " + property : cluster->second].push_back(property);
  }
  std::vector<std::vector<std::string>> all;
  for (auto& [cluster, members] : found) all.push_back(std::move(members));
  return all;
}

std::vector<std::string> RadioDevice::measured() const {
  std::vector<std::string> all;
  for (const auto& [property, range] : model_.walk) all.push_back(property);
  for (const auto& [property, cluster] : model_.cluster) {
    const auto leaf = model_.leaves.find(property);
    const bool setting = leaf != model_.leaves.end() && is_settable(leaf->second.front());
    if (!setting && !model_.walk.contains(property) && leaf != model_.leaves.end()) all.push_back(property);
  }
  return all;
}

void RadioDevice::report(const std::vector<std::string>& properties) {
  for (const auto& property : properties) known_[property] = real(property);
}

}  // namespace rubicon::zigbee_simulator
