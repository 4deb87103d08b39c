#include "bridges/ros2/imports.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/text.h"
#include "bridges/ros2/names.h"
#include "model/units.h"
#include "rubicon/key.hpp"

namespace rubicon::bridges::ros2 {

namespace {

constexpr Duration kLookPause = std::chrono::milliseconds(100);
/// A stamp that is further from now is of another clock, such as that of a simulation.
constexpr Duration kMaxApart = std::chrono::hours(24);
constexpr SetOptions kJson{.media_type = "application/json"};
const std::string kGone = "no publisher of its topic is there";
const std::string kLeft = "the publisher of this value is gone";
const std::string kOurs = "a topic of ours has its name";

}  // namespace

Imports::Imports(const BridgeHost& host, const Options& options, const Topics& topics)
    : host_(host),
      options_(options),
      topics_(topics),
      log_({host.log, "bridge " + host.name}, host.scheduler),
      network_(model::IslandKey{host.prefix}.network("ros2-" + model::to_key_part(host.name))),
      look_(host.scheduler, kLookPause, [this] { look(); }),
      forgets_(host.scheduler, [this] { forget_left(); }) {}

void Imports::start() {
  if (imports_nothing()) return;
  std::ignore = host_.space.set(network_.property(options_.origin), fmt::to_string(options_.reach.domain));
  show_line("connecting", "");
}

void Imports::show_line(const std::string& line, const std::string& reason) {
  LineStatus status;
  status.line = line;
  status.reason = reason;
  status.since = host_.scheduler.wall_now();
  std::ignore = host_.space.set(network_.status(), model::line_status_to_json(status), kJson);
}

void Imports::attach(Node* node, const std::string& reason) {
  for (auto& [topic, import] : imports_) {
    close(import, reason.empty() ? kGone : reason);
    import.left.reset();  // without a node we do not see who publishes
  }
  node_ = node;
  if (imports_nothing()) return;
  show_line(node != nullptr ? "up" : "down", reason);
  look_.request();
}

/// Opens what is published and wanted, and closes what is not. Topics come by the thousand: one look for many.
void Imports::look() {
  if (node_ == nullptr || imports_nothing()) return;
  ++looks_;
  left_out_ = 0;
  const auto known = std::exchange(faults_, {});
  std::vector<const Publication*> all;
  for (const auto& [guid, publication] : node_->graph().publications()) {
    if (!publication.is_of_bridge) all.push_back(&publication);
  }
  std::stable_sort(all.begin(), all.end(), [](auto* left, auto* right) { return left->topic < right->topic; });
  for (auto at = all.begin(); at != all.end();) {
    const auto end = std::find_if(at, all.end(), [&](const auto* one) { return one->topic != (*at)->topic; });
    consider({at, end});
    at = end;
  }
  for (auto& [topic, import] : imports_) {
    if (import.seen != looks_) leave(import);
    follow_publishers(import);
  }
  for (const auto& [topic, what] : faults_) {
    if (const auto before = known.find(topic); before == known.end() || before->second != what)
      log_.warning(topic, fmt::format("{}: {}", topic, what));
  }
}

void Imports::consider(Offers offers) {
  const auto& topic = offers.front()->topic;
  const auto rule = std::find_if(options_.imports.begin(), options_.imports.end(),
                                 [&topic](const auto& one) { return one.topic == topic; });
  const bool is_named = rule != options_.imports.end();
  const auto known = imports_.find(topic);
  auto* import = known == imports_.end() ? nullptr : &known->second;
  const bool is_ours = !is_named && topics_.has(topic);
  if (!is_named && import == nullptr && (is_ours || !options_.imports_all)) return;
  if (import != nullptr) {
    import->seen = looks_;
    import->left.reset();
  }
  Publication offer{topic, {}, true, true};
  std::optional<Form> form;
  if (import != nullptr) form = import->form;  // the sensors that were made of it have types and units
  for (const auto* one : offers) {
    const auto its = form_of(one->type);
    if (!its || its != form.value_or(*its)) continue;
    form = its;
    offer.type = one->type;
    offer.reliable &= one->reliable;
    offer.kept &= one->kept;
  }
  if (!is_ours && !offer.type.empty()) return open(offer, *form, is_named ? &*rule : nullptr);
  const auto& type = offers.front()->type;
  const auto what = is_ours             ? kOurs
                    : import != nullptr ? fmt::format("published as {}, but imported as {}", type, type_of(*form))
                                        : fmt::format("its type {} cannot be imported", type);
  if (is_named || import != nullptr) faults_[topic] = what;
  if (import != nullptr) close(*import, what);
}

/// A reader that all publishers of the topic match, which may be another one than before.
void Imports::open(const Publication& offer, Form form, const ImportRule* rule) {
  const auto known = imports_.find(offer.topic);
  const bool is_new = known == imports_.end();
  if (!is_new && known->second.reader && known->second.reliable == offer.reliable && known->second.kept == offer.kept)
    return;
  if (is_new && rule == nullptr && imports_.size() >= kMaxTopics) {
    ++left_out_;
    return;
  }
  auto reader = node_->reader_for(offer, form);
  if (!reader) {
    faults_[offer.topic] = reader.error().text;
    return;
  }
  const auto device = rule != nullptr ? rule->device : import_place(offer.topic).device;
  auto& import = imports_.try_emplace(offer.topic, Import{offer.topic, form, rule, device}).first->second;
  if (!import.reader) ++robots_[device].open;
  by_endpoint_.erase(import.reader.get());
  import.reader.reset();
  import.reader = std::move(*reader);
  import.reliable = offer.reliable;
  import.kept = offer.kept;
  import.seen = looks_;
  by_endpoint_[import.reader.get()] = &import;
  show_robot(device);
}

void Imports::close(Import& import, const std::string& reason) {
  for (const auto& [name, sensor] : import.sensors) offline(*sensor, reason);
  if (!import.reader) return;
  by_endpoint_.erase(import.reader.get());
  import.reader.reset();
  --robots_[import.device].open;
  show_robot(import.device);
}

/// Nobody publishes it. What a rule names stays for ever.
void Imports::leave(Import& import) {
  close(import, kGone);
  if (import.rule != nullptr || import.left) return;
  import.left = host_.scheduler.now();
  forgets_.advance_to(*import.left + kRemembered);
}

/// At its time each: what counts for the bounds is never gone for longer.
void Imports::forget_left() {
  const auto now = host_.scheduler.now();
  for (auto at = imports_.begin(); at != imports_.end();) {
    const auto& left = at->second.left;
    const bool is_over = left && *left + kRemembered <= now;
    if (left && !is_over) forgets_.advance_to(*left + kRemembered);
    if (is_over) forget(at->second);
    at = is_over ? imports_.erase(at) : std::next(at);
  }
  look_.request();  // there is room for others
}

/// Its sensors, and its robot if that has no other import.
void Imports::forget(const Import& import) {
  const auto& device = import.device;
  auto& robot = robots_[device];
  for (const auto& [name, sensor] : import.sensors) {
    robot.sensors.erase(std::string(model::last_part(sensor->key.text)));
    erase_tuples(sensor->key);
  }
  sensors_ -= import.sensors.size();
  const auto of_robot = std::count_if(imports_.begin(), imports_.end(),
                                      [&device](const auto& one) { return one.second.device == device; });
  if (of_robot > 1) return describe_robot(device);
  const auto key = network_.device(device);
  for (const auto& tuple : {key.description(), key.status()}) std::ignore = host_.space.erase(tuple);
  robots_.erase(device);
}

void Imports::erase_tuples(const model::PointKey& sensor) {
  for (const auto& tuple : {sensor.description(), sensor.status(), sensor.value()})
    std::ignore = host_.space.erase(tuple);
}

/// One that came back, also with another QoS, is another publisher: the value is that of the one before.
void Imports::follow_publishers(Import& import) {
  if (!import.reader) return;
  const auto there = tuples::dds::matched_writers({import.reader.get()});
  for (const auto& [name, sensor] : import.sensors) {
    if (sensor->from != 0 && !there.contains(sensor->from)) offline(*sensor, kLeft);
  }
}

void Imports::offline(Sensor& sensor, const std::string& reason) {
  sensor.from = 0;
  if (sensor.quality != Quality::kDeviceOffline || sensor.reason != reason)
    state(sensor, Quality::kDeviceOffline, reason);
}

void Imports::news(dds_entity_t endpoint) {
  const auto found = by_endpoint_.find(endpoint);
  if (found != by_endpoint_.end()) take(*found->second);
}

void Imports::take(Import& import) {
  tuples::dds::take<std::byte>(import.reader.get(), SIZE_MAX, [&](const auto& message, const auto& info) {
    if (!info.valid_data) return;
    ++messages_;
    const auto parts = parts_of(import.form, &message);
    for (const auto& part : parts.all) {
      const bool is_measured = !part.value.empty() || !part.fault.empty() || part.type == "text";
      if (!is_measured || !wants(import, part)) continue;
      auto* sensor = sensor_of(import, part);
      if (sensor == nullptr) continue;
      if (std::exchange(sensor->from, info.publication_handle) != info.publication_handle) look_.request();
      heard(*sensor, part, parts.stamp);
    }
  });
}

/// With an id the value that the rule names; without one all.
bool Imports::wants(const Import& import, const Part& part) const {
  if (import.rule == nullptr || import.rule->id.empty()) return true;
  if (!import.rule->part.empty()) return part.name == import.rule->part;
  if (import.sensors.contains(part.name) || part.type == import.rule->type) return true;
  return import.sensors.empty() && part.name.empty();
}

const model::Type* Imports::type_of_part(const Import& import, const Part& part) const {
  const bool is_ruled = import.rule != nullptr && !import.rule->type.empty();
  return types_.find(std::string_view(is_ruled ? import.rule->type : part.type));
}

std::string Imports::id_of(const Import& import, const Part& part) const {
  if (import.rule != nullptr && !import.rule->id.empty()) return import.rule->id;
  const auto place = import_place(import.topic);
  auto instance = place.instance + (part.name.empty() ? "" : "_" + model::to_key_part(part.name));
  return fmt::format("{}-{}", part.type, instance.substr(0, 64));
}

/// Made with its first value. nullptr: there are too many.
Imports::Sensor* Imports::sensor_of(Import& import, const Part& part) {
  if (const auto known = import.sensors.find(part.name); known != import.sensors.end()) return known->second.get();
  const auto* type = type_of_part(import, part);
  const auto id = id_of(import, part);
  auto& robot = robots_[import.device];
  if (type == nullptr || sensors_ >= kMaxSensors || !robot.sensors.insert(id).second) return nullptr;
  auto sensor = std::make_unique<Sensor>();
  sensor->key = network_.device(import.device).point(model::Kind::kSensor, id);
  sensor->type = type;
  sensor->unit = part.unit;
  model::PointDescription about;
  about.type = type->name;
  about.type_id = static_cast<std::uint64_t>(type->id);
  about.quantity = type->quantity;
  about.unit = type->unit;
  about.data_type = to_string(type->data);
  about.access = "read";
  about.report = "state";
  about.instance = id.substr(std::min(id.find('-') + 1, id.size()));
  const bool is_made = host_.space.set(sensor->key.description(), model::point_description_to_json(about), kJson) &&
                       host_.space.declare(sensor->key.status(), "", kJson) && host_.space.declare(sensor->key.value());
  if (!is_made) {
    robot.sensors.erase(id);
    erase_tuples(sensor->key);
    return nullptr;
  }
  sensor->status_tuple = *host_.space.find(sensor->key.status());
  sensor->value_tuple = *host_.space.find(sensor->key.value());
  ++sensors_;
  auto* made = import.sensors.emplace(part.name, std::move(sensor)).first->second.get();
  robot.shown_open = false;
  show_robot(import.device);
  return made;
}

/// In the unit of the type; what does not fit is bad, and the value before stays.
void Imports::heard(Sensor& sensor, const Part& part, WallTime stamp) {
  auto text = part.value;
  auto fault = part.fault;
  if (fault.empty() && sensor.unit != sensor.type->unit && sensor.unit != "1") {
    const auto convert = model::conversion(sensor.unit, sensor.type->unit);
    const auto number = base::parse_number<double>(text);
    if (convert && number) text = fmt::format("{:.12g}", (*convert)(*number));
    if (!convert) fault = fmt::format("{} cannot be converted into {}", sensor.unit, sensor.type->unit);
  }
  if (fault.empty()) {
    if (const auto fits = model::TypeCatalogue::parse_reading(*sensor.type, text); !fits) fault = fits.error().text;
  }
  if (!fault.empty()) {
    ++bad_;
    return state(sensor, Quality::kBad, fault);
  }
  const auto now = host_.scheduler.wall_now();
  if (stamp < now - kMaxApart || stamp > now + kMaxApart) stamp = now;
  sensor.heard = now;
  if (std::exchange(sensor.value, text) != text) sensor.changed = now;
  state(sensor, Quality::kGood, {});
  SetOptions options;
  options.user_time = stamp;
  std::ignore = host_.space.set(sensor.value_tuple, text, options);
}

void Imports::state(Sensor& sensor, Quality quality, const std::string& reason) {
  if (std::exchange(sensor.quality, quality) != quality) sensor.since = host_.scheduler.wall_now();
  sensor.reason = reason;
  std::string text;
  model::write_point_status({to_string(quality), reason, sensor.since, sensor.heard, sensor.changed, {}, {}}, text);
  std::ignore = host_.space.set(sensor.status_tuple, text, kJson);
}

/// What changed since it was shown: its sensors, or whether a topic of it is published.
void Imports::show_robot(const std::string& device) {
  auto& robot = robots_[device];
  const bool is_open = robot.open > 0;
  if (std::exchange(robot.shown_open, is_open) == is_open && robot.since != WallTime{}) return;
  robot.since = host_.scheduler.wall_now();
  describe_robot(device);
  const DeviceCondition condition{is_open ? "reachable" : "unreachable", is_open ? "" : kGone, robot.since};
  std::ignore = host_.space.set(network_.device(device).status(), model::device_condition_to_json(condition), kJson);
}

void Imports::describe_robot(const std::string& device) {
  model::DeviceDescription about;
  about.name = device;
  about.type = about.model = "ROS 2";
  about.network = model::last_part(network_.text);
  for (const auto& id : robots_[device].sensors) {
    const auto type = id.substr(0, id.find('-'));
    if (std::count(about.capabilities.begin(), about.capabilities.end(), type) == 0) about.capabilities.push_back(type);
    about.sensors.push_back(id);
  }
  std::ignore = host_.space.set(network_.device(device).description(), model::device_description_to_json(about), kJson);
}

void Imports::complain(BridgeStatus& status) const {
  if (left_out_ > 0)
    status.add({},
               fmt::format("{} topics of robots are not imported: `import` can name those that are wanted", left_out_));
  if (!faults_.empty()) status.add({}, fmt::format("{}: {}", faults_.begin()->first, faults_.begin()->second));
}

void Imports::count(std::map<std::string, std::uint64_t>& counters) const {
  counters["imported-topics"] = by_endpoint_.size();
  counters["imported-sensors"] = sensors_;
  counters["imported-messages"] = messages_;
  counters["imported-bad"] = bad_;
  counters["import-looks"] = looks_;
}

}  // namespace rubicon::bridges::ros2
