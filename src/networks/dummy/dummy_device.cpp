#include "networks/dummy/dummy_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rubicon::networks::dummy {

namespace {

using namespace std::chrono_literals;
using Behaviour = ActuatorScript::Behaviour;

/// Samples are not sent more often; with a period of zero the loop would never end.
constexpr Duration kMinPeriod = 10ms;

template <class Scripts>
std::size_t index_of(const Scripts& scripts, const model::PointId& point) {
  const auto found = std::find_if(scripts.begin(), scripts.end(),
                                  [&](const auto& script) { return script.capability.point == point; });
  return static_cast<std::size_t>(found - scripts.begin());
}

auto no_such(const model::PointId& point, const std::string& device) {
  return fail(ErrorCode::kNotFound,
              fmt::format("device {} has no {} of type {} with instance '{}'", device, to_string(point.kind),
                          static_cast<unsigned>(point.type), point.instance));
}

/// The value of a sensor that follows an actuator with this value.
Value follower_value(const Wave& wave, const Value& commanded) {
  if (const auto* on = std::get_if<bool>(&commanded)) return wave.level(*on);
  if (const auto* whole = std::get_if<std::int64_t>(&commanded)) return wave.value_of(static_cast<double>(*whole));
  if (const auto* real = std::get_if<double>(&commanded)) return wave.value_of(*real);
  return wave.level(true);
}

}  // namespace

DummyDevice::DummyDevice(ScriptedDevice self, network::NetworkHost& host, const bool& line_is_up)
    : self_(std::move(self)), script_(*self_.script), host_(host), line_is_up_(line_is_up) {
  for (const SensorScript& sensor : script_.sensors) chances_.emplace_back(seed_of(self_.seed, sensor.id));
}

void DummyDevice::start() {
  Scheduler& scheduler = host_.scheduler();
  started_ = scheduler.now();
  join_timer_ = scheduler.at(started_ + script_.join, [this] { join(); });
  if (script_.leave) leave_timer_ = scheduler.at(started_ + *script_.leave, [this] { leave(); });
  if (script_.rejoin) rejoin_timer_ = scheduler.at(started_ + *script_.rejoin, [this] { join(); });
}

void DummyDevice::join() {
  joined_ = true;
  announce();
  keep_alive_timer_ = host_.scheduler().after(self_.first_keep_alive, [this] { keep_alive(); });
}

void DummyDevice::retire() {
  if (joined_) host_.deliver(self_.address, model::Leave{"no longer configured"});
}

void DummyDevice::announce() {
  if (!joined_) return;
  model::Join join;
  join.device_type = script_.type;
  join.name = self_.name;
  join.model = script_.model;
  join.capabilities = capabilities();
  deliver(std::move(join));
}

std::vector<model::Capability> DummyDevice::capabilities() const {
  std::vector<model::Capability> all;
  for (const auto& sensor : script_.sensors) all.push_back(sensor.capability);
  for (const auto& actuator : script_.actuators) all.push_back(actuator.capability);
  for (std::size_t i = 0; i < script_.properties.size(); ++i) {
    all.push_back(script_.properties[i].capability);
    if (const auto value = properties_.find(i); value != properties_.end()) all.back().initial = value->second;
  }
  return all;
}

void DummyDevice::leave() {
  deliver(model::Leave{"it leaves by the configuration"});
  joined_ = false;
  keep_alive_timer_.cancel();
  sample_timer_.cancel();
  sampled_.clear();
  pending_.clear();
}

void DummyDevice::keep_alive() {
  deliver(model::KeepAlive{});
  keep_alive_timer_ = host_.scheduler().after(script_.keep_alive, [this] { keep_alive(); });
}

/// Messages are lost while the line is down.
void DummyDevice::deliver(model::Body body) {
  if (line_is_up_) host_.deliver(self_.address, std::move(body));
}

void DummyDevice::report(const model::PointId& point, Value value) {
  deliver(model::Updates{{{point, std::move(value), host_.scheduler().wall_now()}}});
}

void DummyDevice::acknowledge(std::uint64_t request, model::Outcome outcome, std::string text) {
  deliver(model::Acknowledge{request, outcome, std::move(text)});
}

Result<void> DummyDevice::send(const Message& message) {
  if (!joined_)
    return fail(ErrorCode::kUnreachable, fmt::format("device {} has left or has not joined yet", self_.address));
  if (const auto* wanted = std::get_if<model::Sample>(&message.body)) return sample(*wanted);
  if (const auto* command = std::get_if<model::Actuate>(&message.body)) return actuate(*command);
  if (const auto* set = std::get_if<model::SetProperty>(&message.body)) return set_property(*set);
  return fail(ErrorCode::kUnsupported, fmt::format("simulated devices take no {}", to_string(message.kind())));
}

Result<void> DummyDevice::sample(const model::Sample& sample) {
  std::vector<std::size_t> wanted;
  for (const auto& point : sample.points) {
    const std::size_t index = index_of(script_.sensors, point);
    if (index == script_.sensors.size()) return no_such(point, self_.address);
    wanted.push_back(index);
  }
  sampled_ = std::move(wanted);
  period_ = std::max<Duration>(sample.period, kMinPeriod);
  acknowledge(sample.request, model::Outcome::kSent);
  measure();
  return {};
}

void DummyDevice::measure() {
  sample_timer_.cancel();
  if (sampled_.empty()) return;
  model::Updates updates;
  const Duration since = host_.scheduler().now() - started_;
  for (const std::size_t index : sampled_) {
    const SensorScript& sensor = script_.sensors[index];
    const model::PointId& point = sensor.capability.point;
    const auto follower = followers_.find(point);
    Value value = follower != followers_.end() ? follower->second : sensor.wave.at(since, chances_[index]);
    updates.readings.push_back({point, std::move(value), host_.scheduler().wall_now()});
  }
  deliver(std::move(updates));
  sample_timer_ = host_.scheduler().after(period_, [this] { measure(); });
}

Result<void> DummyDevice::actuate(const model::Actuate& actuate) {
  const std::size_t index = index_of(script_.actuators, actuate.point);
  if (index == script_.actuators.size()) return no_such(actuate.point, self_.address);
  const ActuatorScript& actuator = script_.actuators[index];
  if (auto fits = TypeCatalogue::check(*actuator.type, actuate.value); !fits) return fits;
  if (actuator.behaviour == Behaviour::kFail) {
    acknowledge(actuate.request, model::Outcome::kFailed, "the configuration lets it fail");
    return {};
  }
  acknowledge(actuate.request, model::Outcome::kSent);
  if (actuator.behaviour == Behaviour::kIgnore) return {};
  pending_[index] = {actuate.value, host_.scheduler().after(actuator.delay, [this, index] { execute(index); })};
  return {};
}

void DummyDevice::execute(std::size_t actuator) {
  const Value value = std::move(pending_.at(actuator).value);
  pending_.erase(actuator);
  const ActuatorScript& script = script_.actuators[actuator];
  if (script.behaviour != Behaviour::kSilent) report(script.capability.point, value);
  if (!script.sensor) return;
  const std::size_t sensor = index_of(script_.sensors, *script.sensor);
  followers_[*script.sensor] = follower_value(script_.sensors[sensor].wave, value);
  if (std::find(sampled_.begin(), sampled_.end(), sensor) != sampled_.end())
    report(*script.sensor, followers_[*script.sensor]);
}

Result<void> DummyDevice::set_property(const model::SetProperty& set) {
  const std::size_t index = index_of(script_.properties, set.point);
  if (index == script_.properties.size()) return no_such(set.point, self_.address);
  if (auto fits = TypeCatalogue::check(*script_.properties[index].type, set.value); !fits) return fits;
  properties_[index] = set.value;
  acknowledge(set.request, model::Outcome::kSent);
  report(set.point, set.value);
  return {};
}

}  // namespace rubicon::networks::dummy
