#include "proxy/command_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "model/type_names.h"
#include "proxy/command.h"
#include "proxy/tuple_text.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy {

namespace {

constexpr std::size_t kMaxPerDevice = 100;
constexpr std::size_t kMaxPerIsland = 10000;

bool newest_wins(const Point& point) {
  return !point.type || point.type->report == model::Report::kState;
}

bool is_final(CommandState state) {
  return state != CommandState::kQueued && state != CommandState::kSent;
}

/// Why a command cannot be sent now.
std::string why_it_waits(const Device& device) {
  const auto& network = *device.network;
  if (can_send(network)) return fmt::format("the device is unreachable: {}", device.reason.text());
  return fmt::format("the line is {}{}{}", to_string(network.line), network.reason.empty() ? "" : ": ", network.reason);
}

/// The answer to the sender of a command that ended.
model::Outcome outcome_of(const Command& command, CommandState state) {
  switch (state) {
    case CommandState::kConfirmed:
    case CommandState::kAssumed: return model::Outcome::kSent;
    case CommandState::kRefused:
    case CommandState::kFailed: return command.outcome;
    default: return model::Outcome::kFailed;
  }
}

}  // namespace

CommandDesk::CommandDesk(ProxyContext& context, DeviceDirectory& directory, TupleMirror& mirror, Memory& memory,
                         std::function<void(Device&)> rate_changed)
    : context_(context),
      directory_(directory),
      mirror_(mirror),
      memory_(memory),
      rate_changed_(std::move(rate_changed)),
      log_(context),
      outcomes_(context.scheduler, [this](const auto& place, const auto& text) { show_ended(place, text); }),
      next_turn_(context.scheduler, [this] { start_accepted(); }) {}

CommandDesk::~CommandDesk() {
  for (const auto& [device, queue] : queues_) {
    for (const auto& command : queue) log_.ended(*command, "dropped", "the island ends");
  }
  for (const auto& command : accepted_) log_.ended(*command, "dropped", "the island ends");
}

tuples::SetDecision CommandDesk::decide_set(const tuples::RemoteSet& request) {
  Device* device = nullptr;
  const auto point = resolve_target(request, device);
  if (!point) return tuples::SetDecision::refused(point.error());
  auto key = model::without_alias(request.key);
  if (key == request.key) return accept(request, *device, **point);
  auto under_own_key = request;
  under_own_key.key = std::move(key);
  return accept_under_other_key(under_own_key, *device, **point);
}

/// The request uses a key that is not the command's own, so its value must not be stored as a tuple.
tuples::SetDecision CommandDesk::accept_under_other_key(const tuples::RemoteSet& request, Device& device,
                                                        Point& point) {
  auto decision = accept(request, device, point);
  decision.store = false;
  if (decision.verdict == tuples::Verdict::kApplied)
    std::ignore = context_.space.set(point.mirror.command, request.value);
  return decision;
}

Result<Point*> CommandDesk::resolve_target(const tuples::RemoteSet& request, Device*& device) {
  const auto tuple = context_.space.find(model::without_alias(request.key));
  if (!tuple) {
    return fail(ErrorCode::kNotFound, fmt::format("{}: no such actuator or property here", model::quoted(request.key)));
  }
  const auto place = mirror_.place_of(*tuple);
  if (!place.is_command) {
    return fail(ErrorCode::kRefused,
                fmt::format("{}: published by the island; set the .command of an actuator or a writable property",
                            model::quoted(request.key)));
  }
  device = place.device;
  return place.point;
}

tuples::SetDecision CommandDesk::accept(const tuples::RemoteSet& request, Device& device, Point& point) {
  auto value = parse_command(point, request.value);
  if (!value) return tuples::SetDecision::refused(value.error());
  if (is_rate(point) && !rate_of(*value)) {
    return tuples::SetDecision::refused(
        {ErrorCode::kOutOfRange,
         fmt::format("rate: {} is not a number of milliseconds from 1 to a day", model::quoted(request.value))});
  }
  const bool replaces = newest_wins(point) && point.commands.live > 0;
  if (!replaces && (waiting(device.number) >= kMaxPerDevice || live_ >= kMaxPerIsland)) {
    return tuples::SetDecision::refused(
        {ErrorCode::kBusy, fmt::format("{}: {} commands wait for {} already, {} on the island",
                                       model::quoted(request.key), waiting(device.number), device.key, live_)});
  }
  auto command = std::make_unique<Command>();
  command->device = device.number;
  command->point = point.number;
  command->key = request.key.substr(0, request.key.rfind('.'));
  command->creator = request.from;
  command->creator_request = request.request;
  command->commander = commander_name(context_.space, context_.config, request.from);
  write_value(point.type, *value, command->text);
  command->value = std::move(*value);
  const auto& config = context_.config;
  command->time_to_live =
      std::min(request.time_to_live_given ? request.time_to_live : config.command_time_to_live, config.queue_expiry);
  command->accepted = context_.clock.now().steady;
  command->expires = command->accepted + command->time_to_live;
  ++point.commands.live;
  ++live_;
  accepted_.push_back(std::move(command));
  next_turn_.request();
  return tuples::SetDecision::applied();
}

std::size_t CommandDesk::waiting(DeviceNumber device) const {
  const auto queue = queues_.find(device);
  const auto arrived =
      std::count_if(accepted_.begin(), accepted_.end(), [&](const auto& c) { return c->device == device; });
  return static_cast<std::size_t>(arrived) + (queue == queues_.end() ? 0 : queue->second.size());
}

void CommandDesk::start_accepted() {
  for (auto& command : std::exchange(accepted_, {})) start(std::move(command));
}

void CommandDesk::start(std::unique_ptr<Command> command) {
  auto* device = directory_.find(command->device);
  auto* point = device ? find_point(*device, command->point) : nullptr;
  if (!point) {
    --live_;
    return give_up(*command, "its device or point is gone");
  }
  if (newest_wins(*point)) supersede(*device, *point, *command);
  auto& started = *command;
  queues_[device->number].push_back(std::move(command));
  if (is_over(started)) return expire(*device, *point, started, started.reason);
  if (is_rate(*point)) return set_rate(*device, *point, started);
  takes_commands(*device) ? dispatch(*device, *point, started) : wait(*device, *point, started);
}

void CommandDesk::set_rate(Device& device, Point& point, Command& command) {
  device.rate = std::chrono::milliseconds(std::get<std::int64_t>(command.value));
  mirror_.own_value(device, point, command.value, Quality::kGood);
  settle(device, point, command, CommandState::kConfirmed, {});
  rate_changed_(device);
}

void CommandDesk::supersede(Device& device, Point& point, const Command& by) {
  const auto queue = queues_.find(device.number);
  if (queue == queues_.end()) return;
  for (std::size_t i = queue->second.size(); i-- > 0;) {
    auto& older = *queue->second[i];
    if (older.point != point.number || &older == &by) continue;
    older.by = {by.creator, by.commander, by.creator_request};
    settle(device, point, older, CommandState::kSuperseded, "by " + by.commander);
    return;  // at most one of a state's commands is live
  }
}

void CommandDesk::wait(Device& device, Point& point, Command& command) {
  const auto serial = command.request = context_.next_request();
  by_request_.emplace(serial, &command);
  command.deadline = context_.scheduler.at(command.expires, [this, serial] { deadline_passed(serial); });
  const auto& now = context_.clock.now();
  command.until = now.wall + std::chrono::ceil<std::chrono::microseconds>(command.expires - now.steady);
  change(device, point, command, CommandState::kQueued, why_it_waits(device));
}

void CommandDesk::delayed(Device& device) {
  const auto queue = queues_.find(device.number);
  if (queue == queues_.end()) return;
  const auto why = why_it_waits(device);
  for (auto& command : queue->second) {
    auto* point = find_point(device, command->point);
    if (point && !command->is_dispatched() && command->reason != why)
      change(device, *point, *command, CommandState::kQueued, why);
  }
}

/// A turn may run before the timer that is due with it, for example after the process was stopped.
bool CommandDesk::is_over(const Command& command) const {
  return command.expires <= context_.clock.now().steady;
}

void CommandDesk::expire(Device& device, Point& point, Command& command, const std::string& why) {
  settle(device, point, command, CommandState::kExpired,
         fmt::format("not sent within {}{}{}", seconds_text(command.time_to_live), why.empty() ? "" : ": ", why));
}

/// For the acknowledgement of the network.
Duration CommandDesk::answer_wait(const Device& device) const {
  return std::max(context_.config.confirmation_wait, device.network->rules.answer_time);
}

/// For the network. Never longer than the wait for its answer: a command that timed out here must not be executed
/// later.
std::chrono::milliseconds CommandDesk::time_left(const Device& device, const Command& command) const {
  return std::chrono::ceil<std::chrono::milliseconds>(
      std::min<Duration>(command.expires - context_.clock.now().steady, answer_wait(device)));
}

void CommandDesk::dispatch(Device& device, Point& point, Command& command) {
  by_request_.erase(command.request);
  const auto serial = command.request = context_.next_request();
  by_request_.emplace(serial, &command);
  command.dispatched = context_.clock.now();
  Message message;
  message.source.island = context_.space.self();
  message.destination = {context_.space.self(), device.network->id, device.address};
  if (point.id.kind == Kind::kProperty) {
    message.body = model::SetProperty{serial, point.id, command.value};
  } else {
    message.body = model::Actuate{serial, point.id, command.value, time_left(device, command)};
  }
  context_.gateway.send(std::move(message));
  await(command, answer_wait(device));
  change(device, point, command, CommandState::kQueued,
         fmt::format("waits for the acknowledgement of {}", device.network->id));
}

void CommandDesk::await(Command& command, Duration wait) {
  command.until = context_.clock.now().wall + std::chrono::ceil<std::chrono::microseconds>(wait);
  command.deadline = context_.scheduler.after(wait, [this, serial = command.request] { deadline_passed(serial); });
}

void CommandDesk::deliver(Device& device) {
  const auto queue = queues_.find(device.number);
  if (queue == queues_.end() || !takes_commands(device)) return;
  std::vector<Command*> waiting;  // a copy: expired ones leave the queue
  for (const auto& command : queue->second) {
    if (!command->is_dispatched()) waiting.push_back(command.get());
  }
  for (auto* command : waiting) {
    auto* point = find_point(device, command->point);
    if (!point) continue;
    is_over(*command) ? expire(device, *point, *command, std::string(command->reason))
                      : dispatch(device, *point, *command);
  }
}

void CommandDesk::deadline_passed(std::uint64_t serial) {
  context_.clock.refresh();
  const auto found = by_request_.find(serial);
  if (found == by_request_.end()) return;
  auto& command = *found->second;
  auto* device = directory_.find(command.device);
  auto* point = device ? find_point(*device, command.point) : nullptr;
  if (!point) {
    give_up(command, "its device or point is gone");
    return drop(command);
  }
  if (!command.is_dispatched()) {
    expire(*device, *point, command, why_it_waits(*device));
  } else if (command.state == CommandState::kQueued) {
    settle(*device, *point, command, CommandState::kTimedOut,
           "no acknowledgement within " + seconds_text(answer_wait(*device)));
  } else {
    settle(*device, *point, command, CommandState::kTimedOut,
           "no report of the device within " + seconds_text(context_.config.confirmation_wait));
  }
}

bool CommandDesk::acknowledged(const model::Acknowledge& answer) {
  const auto found = by_request_.find(answer.request);
  if (found == by_request_.end() || !found->second->is_dispatched()) return false;
  auto& command = *found->second;
  auto* device = directory_.find(command.device);
  auto* point = device ? find_point(*device, command.point) : nullptr;
  if (!point) {
    give_up(command, "its device or point is gone");
    drop(command);
    return true;
  }
  command.outcome = answer.outcome;
  if (answer.outcome == model::Outcome::kSent) {
    sent(*device, *point, command);
    return true;
  }
  const bool failed = answer.outcome == model::Outcome::kFailed || answer.outcome == model::Outcome::kUndeliverable;
  settle(*device, *point, command, failed ? CommandState::kFailed : CommandState::kRefused,
         answer.text.empty() ? std::string(to_string(answer.outcome)) : answer.text);
  return true;
}

void CommandDesk::sent(Device& device, Point& point, Command& command) {
  if (command.state != CommandState::kQueued) return;
  if (!point.details->capability->reports) {
    mirror_.assume(device, point, command.value);
    settle(device, point, command, CommandState::kAssumed, "the actuator does not report");
    return;
  }
  await(command, context_.config.confirmation_wait);
  change(device, point, command, CommandState::kSent, "waits for the device's report");
  answer(command, model::Outcome::kSent, {});
}

/// Whether a device measured after the command was sent: by the clock as it was then, or, if the clock was set back
/// since, as it is now. A time in the future was taken before the clock was set back.
bool CommandDesk::is_newer(WallTime measured, const Command& command) const {
  const auto& now = context_.clock.refresh();
  const auto& then = command.dispatched;
  if (measured >= then.wall) return true;
  return measured <= now.wall && measured >= now.wall - std::chrono::ceil<WallTime::duration>(now.steady - then.steady);
}

void CommandDesk::reported(Device& device, Point& point, const model::Reading& reading) {
  const auto queue = queues_.find(device.number);
  if (queue == queues_.end()) return;
  for (auto& command : queue->second) {
    if (command->point != point.number || !command->is_dispatched()) continue;
    // A report without a time counts as newer once the command is acknowledged: one that arrives earlier may have been
    // on its way before the command.
    const bool newer =
        reading.user_time == WallTime{} ? command->state == CommandState::kSent : is_newer(reading.user_time, *command);
    if (!newer || !confirms(reading.value, command->value)) continue;
    settle(device, point, *command, CommandState::kConfirmed, {});
    return;
  }
}

/// Published with the next change, because no reader waits for the end of an outcome.
void CommandDesk::show_ended(const KeptOutcomes::Place& place, const std::string& text) {
  auto* device = directory_.find(place.first);
  if (auto* point = device ? find_point(*device, place.second) : nullptr) point->details->ended_commands = text;
}

void CommandDesk::change(Device& device, Point& point, Command& command, CommandState state, std::string reason) {
  if (command.state != state || command.since == WallTime{}) command.since = context_.clock.now().wall;
  command.state = state;
  command.reason = std::move(reason);
  point.details->last_command = command_text(command);
  outcomes_.shown(command, is_final(state));
  point.commands.failed =
      state == CommandState::kFailed || state == CommandState::kTimedOut || state == CommandState::kExpired;
  mirror_.publish_status(device, point);
}

void CommandDesk::settle(Device& device, Point& point, Command& command, CommandState state, std::string reason) {
  --point.commands.live;
  command.until = {};
  change(device, point, command, state, std::move(reason));
  log_.ended(command, to_string(state), command.reason);
  answer(command, outcome_of(command, state), fmt::format("{}: {}", to_string(state), command.reason));
  drop(command);
  const bool taken = state == CommandState::kConfirmed || state == CommandState::kAssumed;
  if (taken && point.id.kind == Kind::kProperty) memory_.property_set(device, point);
}

void CommandDesk::give_up(Command& command, std::string_view why) {
  log_.ended(command, "dropped", why);
  answer(command, model::Outcome::kFailed, why);
}

void CommandDesk::answer(Command& command, model::Outcome outcome, std::string_view text) {
  if (!command.asker) return;
  const auto asker = *std::exchange(command.asker, std::nullopt);
  Message message;
  message.source = asker.about;
  message.destination = asker.from;
  message.body = model::Acknowledge{asker.request, outcome, std::string(text)};
  context_.gateway.send(std::move(message));
}

void CommandDesk::drop(Command& command) {
  by_request_.erase(command.request);
  --live_;
  const auto queue = queues_.find(command.device);
  std::erase_if(queue->second, [&](const auto& one) { return one.get() == &command; });
  if (queue->second.empty()) queues_.erase(queue);
}

void CommandDesk::forget(const Device& device) {
  outcomes_.forget(device.number);
  const auto queue = queues_.find(device.number);
  if (queue == queues_.end()) return;
  for (const auto& command : queue->second) {
    give_up(*command, "its device left");
    by_request_.erase(command->request);
  }
  live_ -= queue->second.size();
  queues_.erase(queue);
}

void CommandDesk::forget(const Device& device, PointNumber point) {
  outcomes_.forget({device.number, point});
  const auto queue = queues_.find(device.number);
  if (queue == queues_.end()) return;
  for (std::size_t i = queue->second.size(); i-- > 0;) {
    if (queue->second[i]->point != point) continue;
    const bool last = queue->second.size() == 1;
    give_up(*queue->second[i], "its point is gone");
    drop(*queue->second[i]);
    if (last) return;
  }
}

CommandDesk::Queue CommandDesk::release(Device& device) {
  Queue released;
  const auto take_from = [&](Queue& queue) {
    for (auto& command : queue) {
      if (command->device != device.number || command->is_dispatched()) continue;
      const auto* point = find_point(device, command->point);
      if (!point) continue;
      if (newest_wins(*point)) std::erase_if(released, [&](const auto& one) { return one->point == point->number; });
      command->deadline.cancel();
      by_request_.erase(command->request);
      --live_;
      if (command->asker) {  // only this island can answer its sender
        give_up(*command, "its device moved to another island or network");
        command.reset();
        continue;
      }
      log_.ended(*command, "moved", "its device went to another island or network");
      released.push_back(std::move(command));
    }
    std::erase(queue, nullptr);
  };
  const auto waiting = queues_.find(device.number);
  if (waiting != queues_.end()) take_from(waiting->second);
  if (waiting != queues_.end() && waiting->second.empty()) queues_.erase(waiting);
  take_from(accepted_);
  return released;
}

tuples::SetDecision CommandDesk::take_over(const tuples::RemoteSet& request, Device& device, Point& point) {
  if (point.mirror.command == TupleRef{}) {
    return tuples::SetDecision::refused(
        {ErrorCode::kRefused, fmt::format("{} of {} cannot be commanded here", point.details->id(), device.key)});
  }
  if (newest_wins(point) && (point.commands.live > 0 || !point.details->last_command.empty())) {
    return tuples::SetDecision::refused(
        {ErrorCode::kRefused, fmt::format("a newer command for {} of {} came first", point.details->id(), device.key)});
  }
  return accept_under_other_key(request, device, point);
}

}  // namespace rubicon::proxy
