#include "proxy/proxy.h"

#include <fmt/format.h>

#include "base/assert.h"
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
      inbox(context),
      board(context, directory),
      mirror(context, directory, memory),
      liveness(context, directory, mirror,
               {[this](Device& device) { demand.overdue(device); }, [this](Device& device) { lost(device); },
                [this](Device& device) { probe(device); }}),
      demand(context, directory, mirror, liveness),
      desk(context, directory, mirror, memory, [this](Device& device) { demand.changed(device); }),
      roaming(context, directory,
              {[this](Device& device, const Claim& to, const std::string& tuple) { moved(device, to, tuple); },
               [this](const DeviceName& name) { arrive(name); }, [this](Device& device) { demand.repeat(device); }}),
      hand_over(context, directory, desk, roaming),
      decisions_turn(scheduler, [this] { carry_out(); }) {
  for (const auto& line : collisions(config)) context.log.error(line);
  board.begin();
  inbox.begin();
  listen();
  roaming.follow();
}

template <class Body>
void Proxy::Impl::on(MessageKind kind, void (Impl::*call)(Device*, Network&, const Message&, const Body&)) {
  handles.push_back(context.gateway.subscribe(kind, [this, call](const Message& message) {
    RUBICON_DEBUG_ASSERT(context.scheduler.on_loop_thread());
    // Devices of other islands are mirrored by their own proxy; a foreign message may not pass for one of ours.
    const auto self = context.space.self();
    if (message.origin != self || message.source.island != self || message.source.network.empty()) return;
    auto& network = directory.network(message.source.network);
    board.declare(network);
    auto* device = message.source.device.empty() ? nullptr : directory.find(network, message.source.device);
    (this->*call)(device, network, message, *std::get_if<Body>(&message.body));
  }));
}

void Proxy::Impl::listen() {
  on<model::Join>(MessageKind::kJoin, &Impl::join);
  on<model::KeepAlive>(MessageKind::kKeepAlive, &Impl::keep_alive);
  on<model::Leave>(MessageKind::kLeave, &Impl::leave);
  on<model::Updates>(MessageKind::kUpdates, &Impl::updates);
  on<model::State>(MessageKind::kState, &Impl::state);
  handles.push_back(
      context.gateway.subscribe(MessageKind::kAcknowledge, [this](const Message& message) { acknowledge(message); }));
  context.gateway.take_commands([this](const Message& message) { return desk.take(message); });
  context.gateway.find_devices([this](const std::string& address) { return directory.networks_of(address); });
  const auto self = context.space.self();
  for (const auto* kind : {"sensor", "actuator"}) {
    handles.push_back(context.space.watch_demand({self, fmt::format("{}.*.*.{}.*.value", config.prefix, kind)},
                                                 [this](const tuples::Demand& wanted) { demand.wanted(wanted); }));
  }
  handles.push_back(context.space.add_policy({self, config.prefix + ".**"},
                                             [this](const tuples::RemoteSet& wish) { return desk.judge(wish); }));
  handles.push_back(
      context.space.add_policy({self, config.prefix + ".*.*.description"},
                               [this](const tuples::RemoteSet& wish) { return judge_description(wish); }));
  handles.push_back(context.space.add_policy({self, "ROAMING.**"},
                                             [this](const tuples::RemoteSet& wish) { return hand_over.judge(wish); }));
  for (const auto* inbox_key : {".inbox", ".inbox.*.*"}) {
    handles.push_back(context.space.add_policy({self, config.prefix + inbox_key},
                                               [this](const tuples::RemoteSet& wish) { return judge_inbox(wish); }));
  }
}

void Proxy::Impl::join(Device* device, Network& network, const Message& message, const model::Join& join) {
  if (message.source.device.empty()) return void(stranger(network, message));
  const DeviceName name{network.id, message.source.device};
  const Announced announced{join, context.clock.now().steady,
                            join.heard ? roaming.stamp(network, name.address) : WallTime{}};
  std::optional<state::KnownDevice> known;
  const auto* entry = device ? nullptr : inbox.find(name);
  // Who waits for a word is remembered by the inbox; who was let in may have values from before.
  if (!device && (!entry || entry->standing == Standing::kLetIn)) known = memory.recall(name.network, name.address);
  if (!device && !let_in(network, name, announced, known ? &*known : nullptr, !join.heard)) {
    if (join.heard) inbox.heard(name);
    return;
  }
  enter(network, name.address, announced, known ? &*known : nullptr);
}

/// False: there is no room for it, or its key is taken; it is in the inbox then.
bool Proxy::Impl::admit(Network& network, const std::string& address, const Announced& announced,
                        const state::KnownDevice* known) {
  const auto& join = announced.join;
  const auto joined = directory.join(network, address, join);
  board.refresh_counters();
  if (!joined) {
    park({network.id, address}, announced, joined.error().text);
    return false;
  }
  inbox.take({network.id, address});
  auto& device = *joined->device;
  for (const auto& point : joined->vanished) desk.forget(device, point.number);
  const bool first = device.status == DeviceStatus::kUnknown;
  if (join.heard && first) device.status = DeviceStatus::kReachable;
  if (joined->fresh) device.since = context.clock.now().wall;
  device.joined = std::max(device.joined, announced.joined);
  if (joined->fresh) hand_over.clear(device);
  mirror.joined(*joined);
  take_rate(device);
  if (joined->fresh || joined->changed) warn_of_lost_names(device);
  if (known) bring_back(device, *known);
  const bool as_remembered = known && is_announcement(known->join, join);
  if (joined->changed && !as_remembered) memory.record_changed(device);
  if (join.heard) {
    if (!network.line_known) presume_line(network);
    device.heard_at = announced.heard_at;
    if (first || device.status == DeviceStatus::kUnreachable) reachable(device, !joined->fresh);
  }
  liveness.watch(device);
  if (!joined->fresh) demand.repeat(device);
  roaming.listed(device);
  return true;
}

void Proxy::Impl::take_rate(Device& device) {
  for (auto& point : device.points) {
    if (!is_rate(point) || std::exchange(device.rate_point, point.number) == point.number) continue;
    device.rate = rate_of(point.details->capability->initial).value_or(device.rate);
    mirror.own_value(device, point, static_cast<std::int64_t>(device.rate.count()), Quality::kGood);
  }
}

void Proxy::Impl::keep_alive(Device* device, Network& network, const Message& message, const model::KeepAlive&) {
  if (!device) device = stranger(network, message);
  if (device) heard(*device);
}

void Proxy::Impl::remove(Device& device) {
  auto& network = *device.network;
  roaming.withdrawn(device);
  desk.forget(device);
  demand.forget(device);
  mirror.left(device);
  directory.remove(device);
  board.devices_changed(network);
  board.refresh_counters();
}

void Proxy::Impl::leave(Device* device, Network& network, const Message& message, const model::Leave& leave) {
  const DeviceName name{network.id, message.source.device};
  roaming.forget(name);
  if (!device) {
    const auto* entry = inbox.find(name);
    if (!entry || entry->ignored()) return;
    const auto known = memory.recall(name.network, name.address);
    const auto decision = known ? known->decision : state::Decision::kNone;
    if (decision == state::Decision::kNone) {
      memory.forget(name.network, name.address);
    } else {
      memory.absent(name.network, name.address, entry->announced.join, decision);
    }
    inbox.take(name);
    return;
  }
  context.log.info(fmt::format("{} left: {}", device->key, leave.reason));
  memory.left(*device);
  remove(*device);
}

void Proxy::Impl::updates(Device* device, Network& network, const Message& message, const model::Updates& updates) {
  if (!device) [[unlikely]] {
    device = stranger(network, message);
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
      board.refresh_counters();
      context.warn(device.key + "/undeclared",
                   fmt::format("{}: value for a {} of type {} it never declared", device.key,
                               to_string(reading.point.kind), static_cast<unsigned>(reading.point.type)));
      return;
    }
    mirror.added(device, *point);
  }
  if (mirror.reading(device, *point, reading)) [[unlikely]]
    liveness.watch(device);
  if (point->live_commands != 0 && point->quality == Quality::kGood) [[unlikely]]
    desk.reported(device, *point, reading);
}

void Proxy::Impl::heard(Device& device) {
  device.heard_at = context.clock.now().steady;
  board.refresh_counters();
  if (!device.network->line_known) [[unlikely]]
    set_line(*device.network, {model::LineState::kUp, {}, {}});
  if (device.status == DeviceStatus::kReachable) [[likely]]
    return;
  reachable(device, true);
  liveness.watch(device);
}

void Proxy::Impl::reachable(Device& device, bool was_known) {
  device.status = DeviceStatus::kReachable;
  device.since = context.clock.now().wall;
  device.reason.clear();
  board.devices_changed(*device.network);
  if (!was_known) return;
  roaming.listed(device);
  mirror.device_status(device);
  mirror.all_points(device);
  demand.repeat(device);
  desk.deliver(device);
}

void Proxy::Impl::lost(Device& device) {
  liveness.interrupted(device, "not heard since the device was out of reach");
  mirror.device_status(device);
  desk.delayed(device);
  board.devices_changed(*device.network);
  roaming.listed(device);
}

void Proxy::Impl::state(Device*, Network& network, const Message&, const model::State& state) {
  const auto before = network_status_text(network);
  for (const auto& [name, count] : state.counters) network.reported[name] = std::to_string(count);
  for (const auto& [name, text] : state.texts) network.reported[name] = text;
  board.refresh_counters();
  const auto since = network.since;
  set_line(network, state);
  const bool tried_again = since == network.since && network_status_text(network) != before;
  if (tried_again) board.line_changed(network);
}

/// A network that never speaks of its line has one that works when its devices are heard.
void Proxy::Impl::presume_line(Network& network) {
  set_line(network, {model::LineState::kUp, {}, {}});
}

void Proxy::Impl::set_line(Network& network, const model::State& state) {
  const bool same = network.line_known && network.line == state.line && network.reason == state.reason;
  network.line_known = true;
  if (same) return;
  network.line = state.line;
  network.reason = state.reason;
  network.since = context.clock.now().wall;
  board.line_changed(network);
  const bool down = state.line == model::LineState::kDown || state.line == model::LineState::kEnded ||
                    state.line == model::LineState::kRefused;
  if (down && !network.down) line_went_down(network);
  if (state.line == model::LineState::kUp) line_came_up(network);
}

void Proxy::Impl::line_went_down(Network& network) {
  network.down = true;
  for (auto& [address, device] : network.devices) {
    liveness.interrupted(device, "not heard since the line was down");
    desk.delayed(device);
    // Where silence says nothing, the line decides who can be reached.
    if (network.rules.silence || device.status != DeviceStatus::kReachable) continue;
    device.status = DeviceStatus::kUnreachable;
    device.since = network.since;
    device.reason = fmt::format("the line is down: {}", network.reason);
    mirror.device_status(device);
    roaming.listed(device);
  }
  board.devices_changed(network);
}

void Proxy::Impl::line_came_up(Network& network) {
  network.down = false;
  for (auto& [address, device] : network.devices) {
    if (!network.rules.silence && device.status == DeviceStatus::kUnreachable) {
      reachable(device, true);
      continue;
    }
    mirror.all_points(device);
    liveness.watch(device);
    demand.repeat(device);
    device.status == DeviceStatus::kUnreachable ? desk.delayed(device) : desk.deliver(device);
  }
}

void Proxy::Impl::probe(const Device& device) {
  Message message;
  message.source.island = context.space.self();
  message.destination = {context.space.self(), device.network->id, device.address};
  message.body = model::Probe{announcement(device)};
  context.gateway.send(std::move(message));
}

/// The device, if it could not come before and can now.
Device* Proxy::Impl::stranger(Network& network, const Message& message) {
  const DeviceName name{network.id, message.source.device};
  if (inbox.heard(name)) {
    const auto* entry = inbox.find(name);
    const bool comes =
        entry->standing == Standing::kLetIn && directory.has_place(network, name.address, entry->announced.join.id);
    return comes ? try_again(network, name) : nullptr;
  }
  if (Device* device = nullptr; elsewhere(network, name.address, device)) return device;
  ++network.faults.unknown_devices;
  board.refresh_counters();
  context.warn(network.id + "/stranger", fmt::format("{} from {}, which never joined", to_string(message.kind()),
                                                     model::quoted(to_string(message.source))));
  return nullptr;
}

void Proxy::Impl::acknowledge(const Message& message) {
  const auto* answer = std::get_if<model::Acknowledge>(&message.body);
  // An answer for a device of ours may carry any number; it is no answer to us.
  if (!answer || message.origin != context.space.self() || !message.destination.network.empty()) return;
  if (!desk.acknowledged(*answer)) demand.acknowledged(*answer);
}

Proxy::Proxy(ProxyConfig config, Scheduler& scheduler, TupleSpace& space, gateway::Gateway& gateway,
             const TypeCatalogue& types, base::LogSink& log, state::StateStore* store)
    : impl_(std::make_unique<Impl>(std::move(config), scheduler, space, gateway, types, log, store)) {}

Proxy::~Proxy() = default;

void Proxy::restore() {
  impl_->restore(std::string());
}

std::vector<std::string> Proxy::objections(const ProxyConfig& next) const {
  return impl_->objections(next);
}
std::vector<std::string> Proxy::lost_names(const std::string& network, const NetworkRules& next) const {
  return impl_->lost_names_in(network, next);
}

void Proxy::reconfigure(ProxyConfig config) {
  impl_->reconfigure(std::move(config));
}

Proxy::InboxCounters Proxy::inbox_counters() const {
  return impl_->inbox.counters();
}

std::map<std::string, std::uint64_t> Proxy::device_counts() const {
  std::map<std::string, std::uint64_t> counts;
  for (const auto& [id, network] : impl_->directory.networks()) counts[id] = network->devices.size();
  return counts;
}

void Proxy::restart(const std::string& network) {
  impl_->restart(network);
}

}  // namespace rubicon::proxy
