#include "networks/zigbee/device.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

#include "networks/zigbee/bridge/settings.h"
#include "networks/zigbee/device/commands.h"
#include "networks/zigbee/device/known_values.h"
#include "networks/zigbee/device/polling.h"
#include "networks/zigbee/device/reports.h"
#include "networks/zigbee/device/state_message.h"
#include "networks/zigbee/exposes/sirens.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee {

namespace {

using device::Command;
using model::Outcome;

/// All devices share one reader, whose memory grows to the longest message. Its members are valid until the next one.
device::StateReader& state_reader() {
  thread_local device::StateReader reader;
  return reader;
}

/// Devices whose polls found no place try again at different times.
Duration retry_of(const std::string& address) {
  return std::chrono::milliseconds(200 + std::hash<std::string>()(address) % 200);
}

}  // namespace

struct Device::Impl {
  Impl(DeviceHost& its_host, exposes::PointsOfModels& its_models, bridge::DeviceRecord its_record);

  void set_record(bridge::DeviceRecord now);
  void limit_silence();
  model::Join join() const;
  void deliver(device::Reports::Found found);
  void unreachable(std::string reason);
  void answer(std::uint64_t request, Outcome outcome, std::string text);
  Result<void> command(std::uint64_t request, const PointId& id, const Value& value, Duration time_to_live);
  Result<void> sample(const model::Sample& request);
  bool is_event(const Capability& capability) const;
  bool get(const std::vector<std::size_t>& properties);
  bool poll(const std::vector<std::size_t>& which);
  bool ask(std::size_t property, bool own);
  Result<void> probe();
  /// Asks for what the device can be asked for; settings are not worth the radio.
  void refresh();
  std::vector<std::size_t> gettable() const;
  bool can_ask() const { return reports.traits().can_ask; }

  DeviceHost& host;
  exposes::PointsOfModels& models;
  const TypeCatalogue& types;
  bridge::DeviceRecord record;
  base::SharedList<exposes::MappedPoint> points;
  device::Properties properties;
  device::Commands commands;
  device::Verification verification;
  device::Reports reports;
  device::Polling polling;
  device::Silence silence;
  std::optional<bool> available;
  /// Settings for the next command of a property: JSON by part (exposes/sirens.h).
  std::map<std::string, std::map<std::string, std::string>> kept;
  bool bridge_decides = false;
  bool up = false;
  /// Since then only copies came. They may belong to the device that had the name before.
  bool renamed = false;
};

Device::Impl::Impl(DeviceHost& its_host, exposes::PointsOfModels& its_models, bridge::DeviceRecord its_record)
    : host(its_host),
      models(its_models),
      types(its_models.types()),
      commands(its_host.scheduler(),
               {[this](std::string payload) { return host.publish(record.name, "set", std::move(payload)); },
                [this](std::uint64_t request, Outcome outcome, std::string text) {
                  answer(request, outcome, std::move(text));
                },
                [this](const Command& command) { reports.commanded(command); }}),
      verification(its_host.scheduler(), {[this](std::size_t property, bool own) { return ask(property, own); },
                                          [this](std::size_t property, std::optional<WallTime> seen) {
                                            deliver(reports.proven(property, seen));
                                          }}),
      reports(its_host.scheduler(), points, properties, commands, verification),
      polling(its_host.scheduler(), retry_of(its_record.address),
              [this](const std::vector<std::size_t>& which) { return poll(which); }),
      silence(its_host.scheduler(), {[this] {
                                       const auto all = gettable();
                                       return !all.empty() && poll({all.front()});
                                     },
                                     [this](std::string reason) { unreachable(std::move(reason)); }}) {
  set_record(std::move(its_record));
}

void Device::Impl::set_record(bridge::DeviceRecord now) {
  record = std::move(now);
  const auto mapped = record.is_group() ? base::SharedList(exposes::map_leaves(record.leaves, types, false))
                                        : models.of(record.vendor + '\n' + record.model, record.leaves);
  const bool others = mapped != points;
  if (others) {
    commands.end(Outcome::kUndeliverable, "the definition of the device changed");
    verification.clear();
    polling.clear();
    kept.clear();
    properties.set_points(points, mapped);
    points = mapped;
  }
  auto traits = reports.traits();
  traits.group = record.is_group();
  traits.can_ask = record.mains() && !record.is_group();
  reports.traits(traits);
  if (others) {
    reports.points_changed();
    if (up) refresh();
  }
  limit_silence();
}

void Device::Impl::limit_silence() {
  const bool answers = can_ask() && !gettable().empty();
  // A mains device that neither reports periodically nor answers may be quiet for ever.
  const bool unlimited = record.mains() && !answers && bridge::longest_reporting(record) == Duration(0);
  silence.limit(unlimited || bridge_decides ? std::nullopt : bridge::silence_limit(record), answers);
}

model::Join Device::Impl::join() const {
  model::Join join;
  join.name = record.name;
  join.model = record.vendor.empty() ? record.model : fmt::format("{} {}", record.vendor, record.model);
  join.heard = false;
  for (const auto& point : points) {
    auto& capability = join.capabilities.emplace_back(point.capability);
    capability.deadline = Duration(0);
    // Its state follows commands: it cannot confirm one (zigbee.md, section 7).
    if (record.is_group()) capability.reports = capability.sampled = false;
  }
  const auto* rate = types.find("rate");
  if (!rate || !can_ask() || gettable().empty()) return join;
  auto& capability = join.capabilities.emplace_back();
  capability.point = {Kind::kProperty, rate->id, {}};
  capability.type_name = rate->name;
  capability.access = Access::kReadWrite;
  return join;
}

void Device::Impl::deliver(device::Reports::Found found) {
  if (!found.stored.empty()) host.deliver(record.address, model::Updates{std::move(found.stored), false});
  if (!found.readings.empty())
    host.deliver(record.address, model::Updates{std::move(found.readings)});
  else if (found.heard)
    host.deliver(record.address, model::KeepAlive{});
}

void Device::Impl::unreachable(std::string reason) {
  reports.interrupted();
  host.deliver(record.address, model::Unreachable{std::move(reason)});
}

void Device::Impl::answer(std::uint64_t request, Outcome outcome, std::string text) {
  host.deliver(record.address, model::Acknowledge{request, outcome, std::move(text)});
}

bool Device::Impl::is_event(const Capability& capability) const {
  const auto* type = types.find(capability.point.type);
  return (type ? type->report : capability.report) == model::Report::kEvent;
}

Result<void> Device::Impl::command(std::uint64_t request, const PointId& id, const Value& value,
                                   Duration time_to_live) {
  const auto point = std::find_if(points.begin(), points.end(),
                                  [&](const exposes::MappedPoint& one) { return one.capability.point == id; });
  if (point == points.end())
    return fail(ErrorCode::kNotFound,
                fmt::format("{} has no {} of type {} instance {}", record.name, to_string(id.kind),
                            static_cast<unsigned>(id.type), model::quoted(id.instance)));
  if (!point->access.settable)
    return fail(ErrorCode::kUnsupported, fmt::format("{} of {} cannot be set", point->property, record.name));
  if (!up) return fail(ErrorCode::kUnreachable, "Zigbee2MQTT is not there");
  auto json = exposes::encode(*point, value);
  if (!json) return fail(json.error());
  if (!point->coding.part.empty()) {
    kept[point->property][point->coding.part] = std::move(*json);
    answer(request, Outcome::kSent, {});
    return {};
  }
  if (const auto parts = kept.find(point->property); parts != kept.end() && value == Value(true))
    json = exposes::with_parts(*json, parts->second);
  Command command;
  command.request = request;
  command.point = static_cast<std::size_t>(point - points.begin());
  command.property = properties.of_point(command.point);
  command.key = point->property;
  command.value = value;
  command.wanted = exposes::decode(*point, *json).value_or(value);
  command.json = std::move(*json);
  command.event = is_event(point->capability);
  // A group reports nothing by itself: without the echo there is no answer to wait for.
  command.echoed = point->capability.reports && (!record.is_group() || reports.traits().optimistic);
  return commands.add(std::move(command), !record.mains() && !record.is_group(), time_to_live);
}

/// What the device reports often enough by itself is asked for only once.
Result<void> Device::Impl::sample(const model::Sample& request) {
  std::vector<std::size_t> wanted, polled;
  const auto reported = bridge::longest_reporting(record);
  for (std::size_t i = 0; can_ask() && i < points.size(); ++i) {
    const auto& point = points[i];
    const bool sampled =
        std::find(request.points.begin(), request.points.end(), point.capability.point) != request.points.end();
    if (!sampled || !point.access.gettable) continue;
    wanted.push_back(properties.of_point(i));
    if (reported == Duration(0) || request.period < reported) polled.push_back(wanted.back());
  }
  polling.once(wanted);
  polling.demand(std::move(polled), request.period);
  answer(request.request, Outcome::kSent, {});
  return {};
}

std::vector<std::size_t> Device::Impl::gettable() const {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool setting = points[i].capability.point.kind == Kind::kProperty;
    if (!points[i].access.gettable || setting) continue;
    const auto property = properties.of_point(i);
    if (std::find(found.begin(), found.end(), property) == found.end()) found.push_back(property);
  }
  return found;
}

void Device::Impl::refresh() {
  if (can_ask()) polling.once(gettable());
}

bool Device::Impl::get(const std::vector<std::size_t>& which) {
  std::string payload = "{";
  for (const auto index : which) {
    if (payload.size() > 1) payload += ',';
    device::append_key(payload, properties[index].name);
    payload += R"(:"")";
  }
  return up && host.publish(record.name, "get", payload + "}").has_value();
}

bool Device::Impl::poll(const std::vector<std::size_t>& which) {
  if (!up || !host.take_poll(record.address) || !get(which)) return false;
  for (const auto index : which) {
    properties[index].asked = true;
    properties[index].asked_at = host.scheduler().now();
  }
  return true;
}

/// A request already in flight is enough.
Result<void> Device::Impl::probe() {
  const auto all = gettable();
  if (!can_ask() || all.empty()) return fail(ErrorCode::kUnsupported, fmt::format("{} cannot be asked", record.name));
  const auto asked_at = properties[all.front()].asked_at;
  const bool under_way = asked_at != SteadyTime{} && host.scheduler().now() < asked_at + device::Silence::kProbeTime;
  if (!under_way) polling.once({all.front()});
  return {};
}

bool Device::Impl::ask(std::size_t property, bool own) {
  return (own || host.take_poll(record.address)) && get({property});
}

Device::Device(DeviceHost& host, exposes::PointsOfModels& models, bridge::DeviceRecord record)
    : impl_(std::make_unique<Impl>(host, models, std::move(record))) {
  host.deliver(impl_->record.address, impl_->join());
}

Device::~Device() = default;

void Device::update(bridge::DeviceRecord record) {
  const auto before = impl_->join();
  if (impl_->record.name != record.name) {
    impl_->renamed = true;
    impl_->commands.expect_no_answers();
  }
  impl_->set_record(std::move(record));
  auto now = impl_->join();
  const bool same = before.name == now.name && before.model == now.model && before.capabilities == now.capabilities;
  if (!same) impl_->host.deliver(impl_->record.address, std::move(now));
}

Result<void> Device::state(std::string_view payload, bool retained) {
  if (payload.empty() || (retained && impl_->renamed)) return {};
  impl_->renamed = false;
  const auto members = state_reader().read(payload);
  if (!members) return fail(members.error());
  auto found = impl_->reports.take(*members, retained);
  if (found.heard) impl_->silence.heard(Duration(0));
  impl_->deliver(std::move(found));
  return {};
}

bool Device::may_have_event(std::string_view payload) const {
  return std::any_of(impl_->points.begin(), impl_->points.end(), [&](const exposes::MappedPoint& point) {
    return point.event && payload.find(point.property) != payload.npos;
  });
}

void Device::availability(bool online) {
  const bool back = online && impl_->available == false;
  impl_->available = online;
  if (!online) return impl_->unreachable("Zigbee2MQTT: not available");
  impl_->reports.reached();
  impl_->host.deliver(impl_->record.address, model::KeepAlive{});
  if (back) impl_->refresh();
}

void Device::optimistic(bool publishes_echoes) {
  auto traits = impl_->reports.traits();
  traits.optimistic = publishes_echoes;
  impl_->reports.traits(traits);
}

void Device::bridge_decides(bool decides) {
  impl_->bridge_decides = decides;
  impl_->limit_silence();
}

Result<void> Device::send(const Message& message) {
  if (const auto* actuate = std::get_if<model::Actuate>(&message.body))
    return impl_->command(actuate->request, actuate->point, actuate->value, actuate->time_to_live);
  if (const auto* set = std::get_if<model::SetProperty>(&message.body))
    return impl_->command(set->request, set->point, set->value, Duration(0));
  if (const auto* sample = std::get_if<model::Sample>(&message.body)) return impl_->sample(*sample);
  if (message.kind() != MessageKind::kProbe)
    return fail(ErrorCode::kUnsupported, fmt::format("a ZigBee device takes no {}", to_string(message.kind())));
  return impl_->probe();
}

void Device::connected() {
  impl_->commands.expect_no_answers();
}

void Device::taken() {
  impl_->commands.taken();
}

void Device::not_taken(const std::string& why) {
  impl_->commands.not_taken(why);
}

void Device::line_lost(const std::string& why) {
  impl_->up = false;
  impl_->reports.interrupted();
  impl_->commands.end(Outcome::kUndeliverable, why);
  impl_->verification.clear();
  impl_->polling.line(false);
  impl_->silence.line(false);
}

void Device::line_up(bool repeats) {
  impl_->up = true;
  impl_->reports.line_up(repeats);
  impl_->polling.line(true);
  impl_->silence.line(true);
  impl_->refresh();
}

const bridge::DeviceRecord& Device::record() const {
  return impl_->record;
}

WallTime Device::last_seen() const {
  return impl_->reports.last_seen();
}

const std::vector<exposes::MappedPoint>& Device::points() const {
  return impl_->points;
}

}  // namespace rubicon::networks::zigbee
