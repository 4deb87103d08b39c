#include "apps/simulators/zigbee/world.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/simulators/zigbee/bridge_json.h"
#include "apps/simulators/zigbee/interviews.h"
#include "apps/simulators/zigbee/requests.h"
#include "base/printable.h"
#include "model/json_members.h"

namespace rubicon::zigbee_simulator {

namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

constexpr auto kBetweenHealths = 10min;
/// Availability: when the bridge gives a device up (zigbee.md, section 6; timeout 1 min, measured 62.5 s).
constexpr Duration kMainsSilence = 62500ms, kBatterySilence = 1500min + 1s;
/// A longer list is not queued a second time for a slow broker.
constexpr std::size_t kLongList = 256 * 1024;

}  // namespace

struct World::Parts {
  explicit Parts(World& world) : interviews(world), requests(world) {}
  Interviews interviews;
  Requests requests;
};

World::World(WorldOptions options, Scheduler& scheduler, Log log)
    : options_(std::move(options)),
      scheduler_(scheduler),
      log_(std::move(log)),
      random_(options_.seed),
      parts_(std::make_unique<Parts>(*this)) {}

World::~World() = default;

// -- the bridge

void World::start() {
  runs_ = true;
  began_ = scheduler_.now();
  restarting_.cancel();
  if (options_.permit_join) permit(254s);
  say("bridge/state", R"({"state":"online"})", true);
  say("bridge/converters", "[]", true);
  publish_info();
  publish_devices();
  publish_groups();
  say("bridge/extensions", "[]", true);
  start_devices();
  health_ = scheduler_.after(kBetweenHealths, [this] { publish_health(); });
}

/// On its own start the bridge publishes the cached state of everything (zigbee.md, section 1).
void World::start_devices() {
  for (const auto& device : devices_) {
    if (device->joined) publish_availability(*device);
  }
  for (const auto& device : devices_) {
    if (device->joined) publish_state(*device);
    if (device->usable()) begin_period(*device);
  }
  for (auto& [id, group] : groups_) {
    if (!group.state.empty()) publish_group(group);
  }
}

void World::publish_health() {
  say("bridge/health",
      model::dump(health_json(devices(), scheduler_.wall_now(), scheduler_.now() - began_, counters_.published,
                              counters_.sets + counters_.gets)),
      true);
  health_ = scheduler_.after(kBetweenHealths, [this] { publish_health(); });
}

void World::reconnected() {
  if (runs_) say("bridge/state", R"({"state":"online"})", true);
}

void World::stop() {
  if (!runs_) return;
  say("bridge/state", R"({"state":"offline"})", true);
  runs_ = false;
  periods_.clear();
  timers_.clear();
  joining_until_ = {};
  joining_.cancel();
  health_.cancel();
}

void World::restart(Duration pause) {
  stop();
  restart_required_ = false;
  restarting_ = scheduler_.after(pause, [this] { start(); });
}

void World::permit(Duration span) {
  joining_until_ = scheduler_.now() + span;
  joining_end_ = scheduler_.wall_now() + std::chrono::duration_cast<std::chrono::microseconds>(span);
  publish_info();
  if (span == Duration{}) return joining_.cancel();
  joining_ = scheduler_.after(span, [this] { publish_info(); });
  parts_->interviews.open();
}

void World::received(std::string_view topic, std::string_view payload) {
  if (!runs_ || !topic.starts_with(options_.base + "/")) return;
  topic.remove_prefix(options_.base.size() + 1);
  if (own_topics_.contains(topic)) return;  // a device may be called `a/set`
  log_.info(fmt::format("{} {}", base::printable(topic), base::printable(payload)));
  constexpr std::string_view kRequest = "bridge/request/";
  if (topic.starts_with(kRequest)) {
    ++counters_.requests;
    return parts_->requests.received(topic.substr(kRequest.size()), payload);
  }
  // From the end, because names may have slashes: NAME/set, NAME/set/PROPERTY, the same with get.
  for (const std::string_view verb : {"/set", "/get"}) {
    const auto at = topic.rfind(verb);
    if (at == topic.npos) continue;
    const auto rest = topic.substr(at + verb.size());
    if (!rest.empty() && rest.front() != '/') continue;
    const auto property = rest.empty() ? rest : rest.substr(1);
    return verb == "/set" ? set(topic.substr(0, at), property, payload) : get(topic.substr(0, at), property, payload);
  }
}

// -- messages of the bridge

void World::say(const std::string& topic, std::string payload, bool retain) {
  if (!runs_ || !publish) return;
  ++counters_.published;
  if (payload.empty())  // the topic is no longer used
    own_topics_.erase(topic);
  else
    own_topics_.insert(topic);
  const auto queue = payload.size() > kLongList ? transport::MqttQueue::kLatest : transport::MqttQueue::kInOrder;
  const bool sure = topic == "bridge/state" || topic == "bridge/health" || topic.ends_with("/availability");
  publish({options_.base + "/" + topic, std::move(payload), retain, sure ? std::uint8_t{1} : std::uint8_t{0}, queue});
}

void World::publish_info() {
  say("bridge/info", model::dump(info_json(options_, devices(), joining(), joining_end_, restart_required_)), true);
}

void World::publish_devices() {
  publish_list({});
}

void World::publish_list(const std::set<std::string>& without) {
  if (!runs_ || !publish) return;
  auto list = "[" + model::dump(coordinator_record());
  for (const auto& device : devices_) {
    if (device->joined && !without.contains(device->address())) list += "," + device->record_text();
  }
  say("bridge/devices", list + "]", true);
}

void World::shrink_list(const std::set<std::string>& addresses) {
  publish_list(addresses);
  later(200ms, [this] { publish_devices(); });
}

void World::publish_groups() {
  std::vector<const DeviceGroup*> all;
  for (const auto& [id, group] : groups_) all.push_back(&group);
  say("bridge/groups", model::dump(groups_json(all)), true);
}

void World::publish_event(std::string_view type, const RadioDevice& device, Json more) {
  more["friendly_name"] = device.name();
  more["ieee_address"] = device.address();
  say("bridge/event", model::dump(Json{{"type", type}, {"data", std::move(more)}}));
}

void World::publish_state(const RadioDevice& device, const Json& more) {
  auto state = device.known();
  state.update(more);
  if (const auto seen = last_seen_json(options_.last_seen, device.last_seen()); !seen.is_null())
    state["last_seen"] = seen;
  say(device.name(), model::dump(state));
}

void World::publish_availability(const RadioDevice& device) {
  if (!options_.availability || device.options.value("availability", Json(true)) == false) return;
  say(device.name() + "/availability", device.online ? R"({"state":"online"})" : R"({"state":"offline"})", true);
}

// -- devices

std::vector<RadioDevice*> World::devices() {
  std::vector<RadioDevice*> all;
  for (const auto& device : devices_) {
    if (device->joined) all.push_back(device.get());
  }
  return all;
}

RadioDevice* World::find(std::string_view name_or_address) {
  if (const auto named_so = by_name_.find(name_or_address); named_so != by_name_.end()) return named_so->second;
  const auto found = by_address_.find(name_or_address);
  return found == by_address_.end() ? nullptr : found->second;
}

/// As the bridge checks friendly names [zigbee.md, section 1].
Result<void> World::check_name(std::string_view name) const {
  const auto wrong = [](std::string why) { return fail(ErrorCode::kInvalid, std::move(why)); };
  if (name.empty()) return wrong("friendly_name must be at least 1 char long");
  if (name.starts_with('/') || name.ends_with('/')) return wrong("friendly_name is not allowed to end or start with /");
  if (name.find_first_of("+#") != name.npos)
    return wrong(fmt::format("MQTT wildcard (+ and #) not allowed in friendly_name ('{}')", name));
  if (std::ranges::any_of(name, [](char one) { return static_cast<unsigned char>(one) < 0x20 || one == 0x7f; }))
    return wrong("friendly_name is not allowed to contain control char");
  const auto slash = name.rfind('/');
  if (slash != name.npos && name.find_first_not_of("0123456789", slash + 1) == name.npos)
    return wrong(fmt::format("Friendly name cannot end with a \"/DIGIT\" ('{}')", name));
  const bool group = std::ranges::any_of(groups_, [&](auto& one) { return one.second.name == name; });
  if (group || by_name_.contains(name)) return wrong(fmt::format("friendly_name '{}' is already in use", name));
  return {};
}

std::string World::next_address() {
  return fmt::format("0x00124b00{:08x}", 0x10000000U + last_address_++);
}

RadioDevice& World::keep(DeviceModel model, std::string address, std::string name) {
  devices_.push_back(std::make_unique<RadioDevice>(std::move(model), address, name,
                                                   static_cast<std::uint16_t>(4096 + devices_.size() % 60000)));
  auto& device = *devices_.back();
  device.every = options_.every;
  by_name_[name] = by_address_[address] = &device;
  if (named) named(name, true);
  return device;
}

Result<RadioDevice*> World::add(DeviceModel model, std::string name) {
  auto address = next_address();
  if (name.empty()) name = address;
  if (const auto allowed = check_name(name); !allowed) return fail(allowed.error());
  auto& device = keep(std::move(model), address, name);
  device.settle(scheduler_.wall_now() - 1h);
  return &device;
}

std::string World::join(DeviceModel model, bool fails) {
  const auto address = next_address();
  parts_->interviews.add(keep(std::move(model), address, address), fails);
  return address;
}

void World::start_interview(RadioDevice& device) {
  parts_->interviews.repeat(device);
}

void World::announce(RadioDevice& device) {
  hear(device);
  publish_event("device_announce", device);
}

void World::forget(const std::string& address) {
  const auto found = by_address_.find(address);
  if (found == by_address_.end()) return;
  const auto* device = found->second;
  if (named) named(device->name(), false);
  forget_topics(device->name());
  by_name_.erase(device->name());
  by_address_.erase(found);
  parts_->interviews.forget(address);
  for (auto* timers : {&periods_, &silences_, &clearings_, &travels_}) timers->erase(address);
  for (auto& [id, group] : groups_) std::erase(group.members, address);
  std::erase_if(devices_, [&](const auto& one) { return one.get() == device; });
}

void World::forget_topics(const std::string& name) {
  own_topics_.erase(name);
  own_topics_.erase(name + "/availability");
}

/// In the recorded order. The availability stays on the broker.
void World::leave(const std::string& address) {
  const auto* device = find(address);
  if (device == nullptr) return;
  Json gone{{"friendly_name", device->name()}, {"ieee_address", device->address()}};
  forget(device->address());
  publish_groups();
  publish_devices();
  say("bridge/event", model::dump(Json{{"type", "device_leave"}, {"data", std::move(gone)}}));
}

Result<void> World::rename(RadioDevice& device, const std::string& to) {
  if (const auto allowed = check_name(to); !allowed) return allowed;
  const auto from = device.name();
  by_name_.erase(from);
  by_name_[to] = &device;
  device.rename(to);
  if (named) named(from, false);
  if (named) named(to, true);
  say(from, "", true);
  if (options_.availability) say(from + "/availability", "", true);
  forget_topics(from);
  publish_availability(device);
  publish_devices();
  publish_state(device);
  return {};
}

DeviceGroup& World::add_group(int id, std::string name, std::vector<std::string> members) {
  if (id == 0) id = groups_.empty() ? 1 : groups_.rbegin()->first + 1;
  if (named) named(name, true);
  return groups_[id] = {id, std::move(name), std::move(members)};
}

// -- what devices do

void World::hear(RadioDevice& device) {
  device.heard(scheduler_.wall_now(), random_);
  publish_state(device);
  mark(device, true);
}

void World::mark(RadioDevice& device, bool online) {
  if (device.online == online) return;
  device.online = online;
  publish_availability(device);
  for (auto& [id, group] : groups_) {
    if (std::ranges::find(group.members, device.address()) != group.members.end()) publish_group_availability(group);
  }
}

void World::set_faults(RadioDevice& device, Faults faults) {
  const bool was_silent = device.faults.silent;
  device.faults = faults;
  if (faults.silent == was_silent) return;
  if (!faults.silent) return hear(device);
  const auto limit = device.model().battery ? kBatterySilence : kMainsSilence;
  silences_[device.address()] = scheduler_.after(limit, [this, address = device.address()] {
    auto* found = find(address);
    if (found != nullptr && found->faults.silent) mark(*found, false);
  });
}

void World::change(RadioDevice& device, const std::string& property, Json value) {
  device.set_real(property, std::move(value));
  if (device.faults.silent) return;
  publish_report(device, {property});
  clear_later(device, property);
}

void World::act(RadioDevice& device, const std::string& property, const Json& value) {
  if (device.faults.silent) return;
  device.heard(scheduler_.wall_now(), random_);
  publish_state(device, {{property, value}});
  mark(device, true);
}

void World::report(RadioDevice& device) {
  if (device.faults.silent) return;
  device.walk(random_);
  const auto groups = device.by_cluster(device.measured());
  if (groups.empty()) hear(device);
  for (const auto& properties : groups) publish_report(device, properties);
  if (device.waiting.empty()) return;
  later(device, 9ms, [this, wanted = std::exchange(device.waiting, Json::object())](RadioDevice& found) {
    answer_set(found, wanted);
  });
}

/// One message, with a new last_seen and the new values. A device that reports two clusters at once sends two, which
/// have the same last_seen.
void World::publish_report(RadioDevice& device, const std::vector<std::string>& properties) {
  device.heard(scheduler_.wall_now(), random_);
  device.report(properties);
  publish_state(device);
  mark(device, true);
  follow_members(device);
}

/// The bridge sets an occupancy back by itself: the message has the last_seen of the one before.
void World::clear_later(RadioDevice& device, const std::string& property) {
  const auto& clears = device.model().clears;
  if (!clears || clears->property != property) return;
  clearings_[device.address()] = scheduler_.after(clears->after, [this, address = device.address()] {
    auto* found = find(address);
    if (found == nullptr || !runs_) return;
    const auto& clearing = *found->model().clears;
    found->set_real(clearing.property, clearing.value);
    found->report({clearing.property});
    publish_state(*found);
  });
}

void World::report_every(RadioDevice& device, Duration period) {
  device.every = period;
  periods_.erase(device.address());
  if (runs_) begin_period(device);
}

void World::begin_period(RadioDevice& device) {
  if (device.every <= Duration{} || !device.usable()) return;
  const auto first = Duration(random_.between(1, device.every.count()));
  periods_[device.address()] = scheduler_.after(first, [this, address = device.address()] { next_period(address); });
}

void World::next_period(const std::string& address) {
  auto* device = find(address);
  if (device == nullptr) return;
  periods_[address] = scheduler_.after(device->every, [this, address] { next_period(address); });
  report(*device);
}

void World::later(Duration delay, std::function<void()> call) {
  const auto id = ++last_timer_;
  timers_[id] = scheduler_.after(delay, [this, id, call = std::move(call)] {
    const auto run = call;
    timers_.erase(id);
    run();
  });
}

void World::later(const RadioDevice& device, Duration delay, std::function<void(RadioDevice&)> call) {
  later(delay, [this, address = device.address(), call = std::move(call)] {
    if (auto* found = find(address)) call(*found);
  });
}

}  // namespace rubicon::zigbee_simulator
