#include "apps/simulators/zigbee/world.h"

#include <fmt/format.h>

#include <utility>

#include "base/text.h"

namespace rubicon::zigbee_simulator {

namespace {

using namespace std::chrono_literals;

constexpr auto kBetweenHealths = 10min;

}  // namespace

World::World(WorldOptions options, Scheduler& scheduler, Log log)
    : state_{std::move(options), scheduler},
      log_(std::move(log)),
      delays_(scheduler, registry_),
      topics_(state_, registry_),
      radio_(state_, registry_, topics_),
      commands_(state_, registry_, topics_, radio_, delays_),
      interviews_(state_, registry_, topics_, radio_, delays_),
      requests_(*this, state_, registry_, topics_, delays_, interviews_) {}

// -- the bridge

void World::start() {
  state_.runs = true;
  state_.began = state_.scheduler.now();
  restarting_.cancel();
  if (state_.options.permit_join) permit_join(254s);
  topics_.say("bridge/state", R"({"state":"online"})", true);
  topics_.say("bridge/converters", "[]", true);
  topics_.info();
  topics_.devices();
  topics_.groups();
  topics_.say("bridge/extensions", "[]", true);
  start_devices();
  health_ = state_.scheduler.after(kBetweenHealths, [this] { publish_health(); });
}

/// On its own start the bridge publishes the cached state of everything (zigbee.md, section 1).
void World::start_devices() {
  for (const auto* device : registry_.devices()) topics_.availability(*device);
  for (auto* device : registry_.devices()) {
    topics_.state(*device);
    radio_.begin(*device);
  }
  for (const auto& [id, group] : registry_.groups()) {
    if (!group.state.empty()) topics_.group(group);
  }
}

void World::publish_health() {
  topics_.health();
  health_ = state_.scheduler.after(kBetweenHealths, [this] { publish_health(); });
}

void World::reconnected() {
  topics_.say("bridge/state", R"({"state":"online"})", true);
}

void World::stop() {
  if (!state_.runs) return;
  topics_.say("bridge/state", R"({"state":"offline"})", true);
  state_.runs = false;
  radio_.stop();
  delays_.clear();
  state_.joining_until = {};
  joining_.cancel();
  health_.cancel();
}

void World::restart(Duration pause) {
  stop();
  state_.restart_required = false;
  restarting_ = state_.scheduler.after(pause, [this] { start(); });
}

void World::permit_join(Duration span) {
  state_.joining_until = state_.scheduler.now() + span;
  state_.joining_end = state_.scheduler.wall_now() + std::chrono::duration_cast<std::chrono::microseconds>(span);
  topics_.info();
  if (span == Duration{}) return joining_.cancel();
  joining_ = state_.scheduler.after(span, [this] { topics_.info(); });
  interviews_.open();
}

void World::received(std::string_view topic, std::string_view payload) {
  const auto& base = state_.options.base;
  if (!state_.runs || !topic.starts_with(base + "/")) return;
  topic.remove_prefix(base.size() + 1);
  if (topics_.is_own(topic)) return;  // a device may be called `a/set`
  log_.info(fmt::format("{} {}", base::printable(topic), base::printable(payload)));
  constexpr std::string_view kRequest = "bridge/request/";
  if (topic.starts_with(kRequest)) {
    ++state_.counters.requests;
    return requests_.received(topic.substr(kRequest.size()), payload);
  }
  // From the end, because names may have slashes: NAME/set, NAME/set/PROPERTY, the same with get.
  for (const std::string_view verb : {"/set", "/get"}) {
    const auto at = topic.rfind(verb);
    if (at == topic.npos) continue;
    const auto rest = topic.substr(at + verb.size());
    if (!rest.empty() && rest.front() != '/') continue;
    const auto name = topic.substr(0, at), property = rest.empty() ? rest : rest.substr(1);
    return verb == "/set" ? commands_.set(name, property, payload) : commands_.get(name, property, payload);
  }
}

void World::shrink_list(const std::set<std::string>& addresses) {
  topics_.devices(addresses);
  delays_.after(200ms, [this] { topics_.devices(); });
}

// -- devices come and go

RadioDevice& World::keep(DeviceModel model, const std::string& address, const std::string& name) {
  auto& device = registry_.add(std::move(model), address, name);
  device.every = state_.options.every;
  return device;
}

Result<RadioDevice*> World::add(DeviceModel model, std::string name) {
  const auto address = registry_.next_address();
  if (name.empty()) name = address;
  if (const auto allowed = registry_.check_name(name); !allowed) return fail(allowed.error());
  auto& device = keep(std::move(model), address, name);
  device.settle(state_.scheduler.wall_now() - 1h);
  return &device;
}

std::string World::join(DeviceModel model, bool fails) {
  const auto address = registry_.next_address();
  interviews_.add(keep(std::move(model), address, address), fails);
  return address;
}

void World::forget(const RadioDevice& device) {
  const auto address = device.address();
  topics_.forget(device.name());
  interviews_.forget(address);
  radio_.forget(address);
  registry_.erase(device);
}

/// In the recorded order. The availability stays on the broker.
void World::leave(const std::string& address) {
  const auto* device = registry_.find(address);
  if (device == nullptr) return;
  const auto name = device->name(), gone = device->address();
  forget(*device);
  topics_.groups();
  topics_.devices();
  topics_.left(name, gone);
}

Result<void> World::rename(RadioDevice& device, const std::string& to) {
  if (const auto allowed = registry_.check_name(to); !allowed) return allowed;
  const auto from = device.name();
  registry_.rename(device, to);
  topics_.say(from, "", true);
  if (state_.options.availability) topics_.say(from + "/availability", "", true);
  topics_.forget(from);
  topics_.availability(device);
  topics_.devices();
  topics_.state(device);
  return {};
}

}  // namespace rubicon::zigbee_simulator
