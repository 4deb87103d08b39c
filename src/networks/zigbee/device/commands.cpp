#include "networks/zigbee/device/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/text.h"

namespace rubicon::networks::zigbee::device {

namespace {

using model::Outcome;

constexpr std::string_view kSuperseded = "superseded by a newer command";

bool supersedes(const Command& newer, const Command& older) {
  return newer.property == older.property && !newer.event && !older.event;
}

/// The keys of one set message must differ.
bool has_key(const std::vector<Command>& batch, const Command& command) {
  return std::any_of(batch.begin(), batch.end(), [&](const Command& one) { return one.property == command.property; });
}

std::string set_payload(const std::vector<Command>& batch) {
  std::string json = "{";
  for (const auto& command : batch) {
    if (json.size() > 1) json += ',';
    append_key(json, command.key);
    json += ':';
    json += command.json;
  }
  return json + "}";
}

Outcome outcome_of(const Error& error) {
  return error.code == ErrorCode::kBusy ? Outcome::kBusy : Outcome::kUndeliverable;
}

}  // namespace

void append_key(std::string& json, std::string_view key) {
  json += '"';
  for (const char c : key) {
    if (c == '"' || c == '\\') json += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      base::append(json, "\\u{:04x}", static_cast<unsigned>(c));
    else
      json += c;
  }
  json += '"';
}

Commands::Commands(Scheduler& scheduler, Callbacks calls)
    : scheduler_(scheduler),
      callbacks_(std::move(calls)),
      turn_(scheduler, [this] { flush(); }),
      deadline_(scheduler, [this] { flush(); }) {}

Result<void> Commands::add(Command command, bool sleeps, Duration time_to_live) {
  if (waiting_.size() + published_.size() + echoless_.size() >= kMaxPending)
    return fail(ErrorCode::kBusy, fmt::format("{}: {} commands wait already", command.key, kMaxPending));
  const auto now = scheduler_.now();
  const auto longest = sleeps ? kAnswerTime : kEchoTime;
  const auto life = time_to_live > Duration(0) ? std::min(time_to_live, longest) : longest;
  command.expires = now + life;
  command.answer_by = sleeps ? command.expires : now + kAnswerTime;
  for (const auto& older : waiting_) {
    if (supersedes(command, older)) answer(older, Outcome::kFailed, std::string(kSuperseded));
  }
  std::erase_if(waiting_, [&](const Command& older) { return supersedes(command, older); });
  waiting_.push_back(std::move(command));
  turn_.request();
  return {};
}

const Command* Commands::awaiting(std::size_t property) const {
  const auto found = std::find_if(published_.begin(), published_.end(),
                                  [&](const Command& command) { return command.property == property; });
  return found == published_.end() ? nullptr : &*found;
}

void Commands::echo(const Command& command) {
  answer(command, Outcome::kSent, {});
  published_.erase(published_.begin() + (&command - published_.data()));
  if (!waiting_.empty()) turn_.request();
}

void Commands::taken() {
  if (answered_ < messages_) answer_message(echoless_, ++answered_, Outcome::kSent, {});
}

void Commands::not_taken(const std::string& why) {
  if (answered_ == messages_) return;
  ++answered_;
  hold_until_ = {};
  for (auto* list : {&published_, &echoless_}) answer_message(*list, answered_, Outcome::kRefused, why);
  if (!waiting_.empty()) turn_.request();
}

void Commands::answer_message(std::vector<Command>& list, std::uint64_t message, Outcome outcome,
                              const std::string& why) {
  std::erase_if(list, [&](const Command& command) {
    if (command.message != message) return false;
    answer(command, outcome, why);
    return true;
  });
}

void Commands::end(Outcome outcome, const std::string& why) {
  hold_until_ = {};
  for (auto* list : {&published_, &echoless_, &waiting_}) {
    for (const auto& command : std::exchange(*list, {})) answer(command, outcome, why);
  }
}

void Commands::flush() {
  sweep();
  publish_waiting();
  deadline_.set_at(next_time());
}

void Commands::publish_waiting() {
  if (!published_.empty() && scheduler_.now() < hold_until_) return;
  std::vector<Command> batch;
  for (auto& command : std::exchange(waiting_, {})) {
    if (has_key(batch, command)) publish(std::exchange(batch, {}));
    batch.push_back(std::move(command));
  }
  if (!batch.empty()) publish(std::move(batch));
}

void Commands::publish(std::vector<Command> batch) {
  const auto done = callbacks_.publish(set_payload(batch));
  hold_until_ = scheduler_.now() + kHold;
  if (done) ++messages_;
  for (auto& command : batch) {
    command.message = messages_;
    if (!done)
      answer(command, outcome_of(done.error()), done.error().text);
    else
      sent(std::move(command));
  }
}

void Commands::sent(Command command) {
  command.published = scheduler_.wall_now();
  callbacks_.published(command);
  command.answer_by = std::min(command.answer_by, std::max(scheduler_.now() + kEchoTime, command.expires));
  if (!command.echoed) return echoless_.push_back(std::move(command));
  std::erase_if(published_, [&](const Command& older) {
    if (!supersedes(command, older)) return false;
    answer(older, Outcome::kFailed, std::string(kSuperseded));
    return true;
  });
  published_.push_back(std::move(command));
}

void Commands::sweep() {
  const auto now = scheduler_.now();
  std::erase_if(waiting_, [&](const Command& command) {
    if (command.expires > now) return false;
    answer(command, Outcome::kUndeliverable, "not sent: Zigbee2MQTT did not confirm the command before it");
    return true;
  });
  std::erase_if(published_, [&](const Command& command) {
    if (command.answer_by > now) return false;
    answer(
        command, Outcome::kUndeliverable,
        "Zigbee2MQTT did not confirm that it sent the command: the device does not answer, or sleeps, the broker "
        "dropped it, or the value was rejected (see the log of Zigbee2MQTT); a device that sleeps may still execute it "
        "when it wakes");
    return true;
  });
  std::erase_if(echoless_, [&](const Command& command) {
    if (command.answer_by > now) return false;
    answer(command, Outcome::kSent, {});
    return true;
  });
}

SteadyTime Commands::next_time() const {
  auto next = SteadyTime::max();
  for (const auto& command : waiting_) next = std::min({next, command.expires, hold_until_});
  for (const auto* list : {&published_, &echoless_}) {
    for (const auto& command : *list) next = std::min(next, command.answer_by);
  }
  return next;
}

void Commands::answer(const Command& command, Outcome outcome, std::string text) {
  callbacks_.answer(command.request, outcome, std::move(text));
}

}  // namespace rubicon::networks::zigbee::device
