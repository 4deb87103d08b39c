#include "proxy/proxy.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/assert.h"
#include "proxy/alerts.h"
#include "proxy/naming.h"
#include "proxy/proxy_impl.h"
#include "proxy/tuple_text.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy {

Proxy::Impl::Impl(ProxyConfig rules, Scheduler& scheduler, TupleSpace& space, gateway::Gateway& gateway,
                  const TypeCatalogue& types, base::LogSink& log, state::StateStore* store)
    : config(std::move(rules)),
      context{config, scheduler, space, gateway, types, Log(log, "proxy")},
      directory(context),
      memory(context, directory, store),
      network_tuples(context, directory),
      mirror(context, directory, memory),
      user_names(context, directory, memory, mirror),
      liveness(context, directory, mirror,
               {[this](Device& device) { demand.overdue(device); }, [this](Device& device) { lost(device); },
                [this](Device& device) { probe(device); }}),
      demand(context, directory, mirror, liveness),
      desk(context, directory, mirror, memory, [this](Device& device) { demand.changed(device); }),
      admission(context, directory, memory, network_tuples,
                {[this](const DeviceDirectory::Joined& joined, const Announced& announced,
                        const state::KnownDevice* known) { listed(joined, announced, known); },
                 [this](Device& device, const Claim& to, const std::string& tuple) { moved(device, to, tuple); },
                 [this](Device& device) { ignored(device); }, [this](Device& device) { demand.repeat(device); }}),
      transfer(context, directory, desk, admission.roaming()) {
  for (const auto& line : collisions(config)) context.log.error(line);
  network_tuples.begin();
  listen();
  admission.roaming().follow_domains();
}

template <class Body>
void Proxy::Impl::on(MessageKind kind, void (Impl::*call)(Device*, Network&, const Message&, const Body&)) {
  handles.push_back(context.gateway.subscribe(kind, [this, call](const Message& message) {
    RUBICON_DEBUG_ASSERT(context.scheduler.on_loop_thread());
    // Other islands publish their own devices; a message of another island must not act for one of ours.
    const auto self = context.space.self();
    if (message.origin != self || message.source.island != self || message.source.network.empty()) return;
    auto& network = directory.network(message.source.network);
    network_tuples.declare(network);
    auto* device = message.source.device.empty() ? nullptr : network.devices.find(message.source.device);
    (this->*call)(device, network, message, *std::get_if<Body>(&message.body));
  }));
}

void Proxy::Impl::listen() {
  on<model::Join>(MessageKind::kJoin, &Impl::join);
  on<model::KeepAlive>(MessageKind::kKeepAlive, &Impl::keep_alive);
  on<model::Unreachable>(MessageKind::kUnreachable, &Impl::unreachable);
  on<model::Leave>(MessageKind::kLeave, &Impl::leave);
  on<model::Updates>(MessageKind::kUpdates, &Impl::updates);
  on<model::State>(MessageKind::kState, &Impl::state);
  handles.push_back(
      context.gateway.subscribe(MessageKind::kAcknowledge, [this](const Message& message) { acknowledge(message); }));
  context.gateway.set_command_handler(
      [this](const Message& message, const std::string& through) { return desk.on_message(message, through); },
      [this](const Message& message) { return desk.may_command(message); });
  context.gateway.set_device_lookup(
      [this](const std::string& address) { return directory.networks_of(address); },
      [this](const std::string& network, const std::string& address) { return directory.parts_of(network, address); });
  context.gateway.set_look_ahead([this](std::span<const Message> next) { fetch(next); });
  const auto self = context.space.self();
  const model::IslandKey island{config.prefix};
  const auto any_device = island.network("*").device("*");
  for (const auto* kind : {"sensor", "actuator"}) {
    handles.push_back(context.space.watch_demand({self, any_device.point(kind, "*").value()},
                                                 [this](const tuples::Demand& wanted) { demand.on_demand(wanted); }));
  }
  handles.push_back(context.space.add_policy(
      {self, config.prefix + ".**"}, [this](const tuples::RemoteSet& request) { return desk.decide_set(request); }));
  handles.push_back(
      context.space.add_policy({self, any_device.description()},
                               [this](const tuples::RemoteSet& request) { return user_names.decide_set(request); }));
  handles.push_back(context.space.add_policy(
      {self, "ROAMING.**"}, [this](const tuples::RemoteSet& request) { return transfer.decide_set(request); }));
  for (const auto& inbox_key : {island.inbox(), island.inbox("*.*")}) {
    handles.push_back(context.space.add_policy(
        {self, inbox_key}, [this](const tuples::RemoteSet& request) { return admission.decide_set(request); }));
  }
}

void Proxy::Impl::join(Device* device, Network& network, const Message& message, const model::Join& join) {
  if (message.source.device.empty()) return void(admission.on_unknown_device(network, message));
  // A listed device keeps its tuples: it may be interviewed again.
  if (device && !join.problem.empty()) return found_unreachable(*device, join.problem, true);
  admission.on_join(device, network, message.source.device, join);
}

void Proxy::Impl::listed(const DeviceDirectory::Joined& joined, const Announced& announced,
                         const state::KnownDevice* known) {
  auto& device = *joined.device;
  const auto& join = announced.join;
  for (const auto& point : joined.vanished) desk.forget(device, point.number);
  const bool first = device.status == DeviceStatus::kUnknown;
  if (join.heard && first) device.status = DeviceStatus::kReachable;
  if (joined.fresh) device.since = context.clock.now().wall;
  device.joined = std::max(device.joined, announced.joined);
  if (joined.fresh) transfer.clear(device);
  mirror.joined(joined);
  adopt_rate(device);
  if (joined.fresh || joined.changed) warn_of_lost_names(device);
  if (known) restore_values(device, *known);
  const bool as_remembered = known && is_announcement(known->join, join);
  if (joined.changed && !as_remembered) memory.record_changed(device);
  if (join.heard) {
    if (!device.network->line_known) presume_line(*device.network);
    device.heard_at = announced.heard_at;
    if (first || device.status == DeviceStatus::kUnreachable) reachable(device, !joined.fresh);
  } else if (device.unusable) {
    usable_again(device);
  }
  liveness.watch(device);
  if (!joined.fresh) demand.repeat(device);
}

void Proxy::Impl::restore_values(Device& device, const state::KnownDevice& known) {
  Memory::restore_decision(device, known);
  device.given_name = known.given_name;
  device.given_area = known.area;
  if (directory.update_name(device)) mirror.described(device);
  for (const auto& stored : known.values) {
    auto* point = find_point(device, stored.point);
    if (!point) {
      point = directory.add_undeclared(device, stored.point);
      if (!point) continue;
      mirror.added(device, *point);
    }
    Memory::restore_origin(*point, stored.set_by_user);
    if (!is_rate(*point)) {
      mirror.remembered(device, *point, stored);
      continue;
    }
    const auto value = TypeCatalogue::parse(*point->type, to_text(stored.value));
    const auto rate = value ? rate_of(*value) : std::nullopt;
    if (!rate || !stored.set_by_user) continue;
    device.rate = *rate;
    mirror.own_value(device, *point, *value, Quality::kGood);
  }
}

void Proxy::Impl::warn_of_lost_names(const Device& device) {
  for (const auto& lost : lost_names_of(device)) {
    const auto path = path_of(device, lost);
    context.warn(path, fmt::format("{}: {}", path, lost.text));
  }
}

void Proxy::Impl::adopt_rate(Device& device) {
  for (auto& point : device.points) {
    if (!is_rate(point) || std::exchange(device.rate_point, point.number) == point.number) continue;
    device.rate = rate_of(point.details->capability->initial).value_or(device.rate);
    mirror.own_value(device, point, static_cast<std::int64_t>(device.rate.count()), Quality::kGood);
  }
}

void Proxy::Impl::keep_alive(Device* device, Network& network, const Message& message, const model::KeepAlive&) {
  if (!device) device = admission.on_unknown_device(network, message);
  if (device) heard(*device);
}

void Proxy::Impl::unreachable(Device* device, Network&, const Message&, const model::Unreachable& unreachable) {
  if (device) found_unreachable(*device, unreachable.reason, false);
}

void Proxy::Impl::found_unreachable(Device& device, const std::string& reason, bool unusable) {
  device.unusable = unusable;
  const bool same = device.found_unreachable && device.reason.text() == reason;
  if (same) return;
  if (device.status != DeviceStatus::kUnreachable) device.since = context.clock.now().wall;
  device.status = DeviceStatus::kUnreachable;
  device.found_unreachable = true;
  device.reason = reason;
  lost(device);
  desk.deliver(device);
}

/// A Join without a problem that was not heard is no sign of life.
void Proxy::Impl::usable_again(Device& device) {
  device.status = DeviceStatus::kUnknown;
  device.found_unreachable = device.unusable = false;
  device.since = context.clock.now().wall;
  device.reason.clear();
  mirror.device_status(device);
  mirror.all_points(device);
}

void Proxy::Impl::remove(Device& device) {
  auto& network = *device.network;
  admission.roaming().withdraw_claim(device);
  desk.forget(device);
  demand.forget(device);
  mirror.left(device);
  directory.remove(device);
  network_tuples.devices_changed(network);
  network_tuples.refresh_counters();
}

void Proxy::Impl::moved(Device& device, const Claim& to, const std::string& tuple) {
  context.log.info(fmt::format("{} moved to {} of island {}", device.key, to.key, number(to.island)));
  demand.stop(device);
  transfer.send(device, to, tuple);
  memory.left(device);
  remove(device);
}

void Proxy::Impl::ignored(Device& device) {
  demand.stop(device);
  memory.save_before_removal(std::array{&device});
  remove(device);
}

void Proxy::Impl::leave(Device* device, Network& network, const Message& message, const model::Leave& leave) {
  admission.on_leave({network.id, message.source.device});
  if (!device) return;
  context.log.info(fmt::format("{} left: {}", device->key, leave.reason));
  memory.left(*device);
  remove(*device);
}

/// Devices, points and tuples are visited in any order, so that each look into them waits for memory. Here those of
/// some messages are fetched at once, one step of all before the next step.
void Proxy::Impl::fetch(std::span<const Message> next) {
  next_readings.clear();
  const auto& devices = directory.network(next.front().source.network).devices;
  for (const auto& message : next) {
    if (message.kind() != MessageKind::kUpdates) continue;
    next_readings.push_back({&message, DeviceTable::hash_of(message.source.device), nullptr});
    devices.fetch_place(next_readings.back().hash);
  }
  for (const auto& one : next_readings) devices.fetch_device(one.hash);
  for (auto& one : next_readings) {
    one.device = devices.find(one.message->source.device, one.hash);
    if (one.device) fetch_points(*one.device);
  }
  for (const auto& one : next_readings) {
    if (!one.device) continue;
    for (const auto& reading : std::get_if<model::Updates>(&one.message->body)->readings) {
      if (const auto* point = find_point(*one.device, reading.point)) mirror.fetch(*point);
    }
  }
}

void Proxy::Impl::updates(Device* device, Network& network, const Message& message, const model::Updates& updates) {
  if (!updates.heard) [[unlikely]] {
    for (const auto& one : updates.readings) {
      if (device) repeated(*device, one);
    }
    return;
  }
  if (!device) [[unlikely]] {
    device = admission.on_unknown_device(network, message);
    if (!device) return;
  }
  heard(*device);
  for (const auto& one : updates.readings) reading(*device, one);
}

void Proxy::Impl::reading(Device& device, const model::Reading& reading) {
  auto* point = find_point(device, reading.point);
  if (!point) [[unlikely]] {
    point = directory.add_undeclared(device, reading.point);
    if (!point) {
      ++device.network->faults.undeclared_points;
      network_tuples.refresh_counters();
      context.warn(device.key + "/undeclared",
                   fmt::format("{}: value for a {} of type {} it never declared", device.key,
                               to_string(reading.point.kind), static_cast<unsigned>(reading.point.type)));
      return;
    }
    mirror.added(device, *point);
  }
  if (mirror.reading(device, *point, reading)) [[unlikely]]
    liveness.watch(device);
  if (point->commands.live != 0 && point->quality == Quality::kGood) [[unlikely]]
    desk.reported(device, *point, reading);
}

void Proxy::Impl::repeated(Device& device, const model::Reading& reading) {
  auto* point = find_point(device, reading.point);
  if (point && !is_rate(*point)) mirror.repeated(device, *point, reading);
}

void Proxy::Impl::heard(Device& device) {
  device.heard_at = context.clock.now().steady;
  network_tuples.refresh_counters();
  if (!device.network->line_known) [[unlikely]]
    set_line(*device.network, {model::LineState::kUp, {}, {}});
  if (device.status == DeviceStatus::kReachable) [[likely]]
    return;
  reachable(device, true);
  liveness.watch(device);
}

void Proxy::Impl::reachable(Device& device, bool was_known) {
  device.status = DeviceStatus::kReachable;
  device.found_unreachable = device.unusable = false;
  device.since = context.clock.now().wall;
  device.reason.clear();
  network_tuples.devices_changed(*device.network);
  if (!was_known) return;
  admission.roaming().publish_claim(device);
  mirror.device_status(device);
  mirror.all_points(device);
  demand.repeat(device);
  desk.deliver(device);
}

void Proxy::Impl::lost(Device& device) {
  liveness.interrupted(device, "not heard since the device was out of reach");
  mirror.device_status(device);
  desk.delayed(device);
  network_tuples.devices_changed(*device.network);
  admission.roaming().publish_claim(device);
}

void Proxy::Impl::state(Device*, Network& network, const Message&, const model::State& state) {
  const auto before = network_status_text(network);
  for (const auto& [name, count] : state.counters) network.reported[name] = std::to_string(count);
  for (const auto& [name, text] : state.texts) network.reported[name] = text;
  network_tuples.refresh_counters();
  const auto since = network.since;
  set_line(network, state);
  const bool retried = since == network.since && network_status_text(network) != before;
  if (retried) network_tuples.line_changed(network);
}

/// For networks that never report their line: it is up when a device is heard.
void Proxy::Impl::presume_line(Network& network) {
  set_line(network, {model::LineState::kUp, {}, {}});
}

void Proxy::Impl::set_line(Network& network, const model::State& state) {
  const bool same = network.line_known && network.line == state.line && network.reason == state.reason;
  network.line_known = true;
  if (same) return;
  network.line = state.line;
  network.reason = state.reason;
  network.finding = state.finding;
  network.since = context.clock.now().wall;
  network_tuples.line_changed(network);
  const bool down = state.line == model::LineState::kDown || state.line == model::LineState::kEnded ||
                    state.line == model::LineState::kRefused;
  if (down && !network.down) line_went_down(network);
  if (state.line == model::LineState::kUp) line_came_up(network);
}

void Proxy::Impl::line_went_down(Network& network) {
  network.down = true;
  for (const auto& listed : network.devices.all()) {
    auto& device = *listed;
    liveness.interrupted(device, "not heard since the line was down");
    desk.delayed(device);
    // Without a `silence`, the line alone decides which devices are reachable.
    if (network.rules.silence || device.status != DeviceStatus::kReachable) continue;
    device.status = DeviceStatus::kUnreachable;
    device.since = network.since;
    device.reason = fmt::format("the line is down: {}", network.reason);
    mirror.device_status(device);
    admission.roaming().publish_claim(device);
  }
  network_tuples.devices_changed(network);
}

void Proxy::Impl::line_came_up(Network& network) {
  network.down = false;
  for (const auto& listed : network.devices.all()) {
    auto& device = *listed;
    if (!network.rules.silence && device.status == DeviceStatus::kUnreachable && !device.found_unreachable) {
      reachable(device, true);
      continue;
    }
    mirror.all_points(device);
    liveness.watch(device);
    demand.repeat(device);
    takes_commands(device) ? desk.deliver(device) : desk.delayed(device);
  }
}

void Proxy::Impl::probe(const Device& device) {
  Message message;
  message.source.island = context.space.self();
  message.destination = {context.space.self(), device.network->id, device.address};
  message.body = model::Probe{announcement(device)};
  context.gateway.send(std::move(message));
}

void Proxy::Impl::acknowledge(const Message& message) {
  const auto* answer = std::get_if<model::Acknowledge>(&message.body);
  // Answers to devices of ours are not for the proxy; they may carry any number.
  if (!answer || message.origin != context.space.self() || !message.destination.network.empty()) return;
  if (!desk.acknowledged(*answer)) demand.acknowledged(*answer);
}

Proxy::Proxy(ProxyConfig config, Scheduler& scheduler, TupleSpace& space, gateway::Gateway& gateway,
             const TypeCatalogue& types, base::LogSink& log, state::StateStore* store)
    : impl_(std::make_unique<Impl>(std::move(config), scheduler, space, gateway, types, log, store)) {}

Proxy::~Proxy() {
  impl_->context.gateway.set_look_ahead(nullptr);
}

void Proxy::log_commands_to(base::LogSink& log) {
  impl_->context.commands = Log(log, "proxy");
}

void Proxy::restore() {
  impl_->admission.restore(std::string());
}

std::vector<Objection> Proxy::objections(const ProxyConfig& next) const {
  return key_conflicts(impl_->directory, next);
}
std::vector<std::string> Proxy::lost_names(const std::string& network, const NetworkRules& next) const {
  return lost_names_in(impl_->directory, network, next);
}

void Proxy::reconfigure(ProxyConfig config) {
  impl_->reconfigure(std::move(config));
}

Proxy::InboxCounters Proxy::inbox_counters() const {
  return impl_->admission.inbox_counters();
}

std::map<std::string, std::uint64_t> Proxy::device_counts() const {
  std::map<std::string, std::uint64_t> counts;
  for (const auto& [id, network] : impl_->directory.networks()) counts[id] = network->devices.size();
  return counts;
}

void Proxy::add_alerts(model::AlertList& list) const {
  proxy::add_alerts(impl_->directory, impl_->context.scheduler.wall_now(), list);
}

void Proxy::restart(const std::string& network) {
  impl_->restart(network);
}

}  // namespace rubicon::proxy
