#include "island/command_key.h"

#include <fmt/format.h>

#include <tuple>
#include <utility>

#include "model/json_members.h"
#include "proxy/commander.h"

namespace rubicon::island {

namespace {

constexpr tuples::SetOptions kJson{"application/json", {}, {}};

}  // namespace

CommandKey::CommandKey(Place place, model::PointKey key, Calls calls)
    : place_(place), key_(std::move(key)), calls_(std::move(calls)), next_(place_.scheduler, [this] { run_next(); }) {
  std::ignore = place_.space.declare(key_.command());
  policy_ = place_.space.add_policy({place_.space.self(), key_.command()},
                                    [this](const tuples::RemoteSet& set) { return decide(set); });
}

CommandKey::~CommandKey() {
  for (const auto& key : {key_.command(), key_.status(), key_.description()}) std::ignore = place_.space.erase(key);
}

void CommandKey::describe(const model::PointDescription& description) {
  std::ignore = place_.space.set(key_.description(), model::point_description_to_json(description), kJson);
}

void CommandKey::show() {
  auto text = model::dump(calls_.status ? calls_.status() : nlohmann::ordered_json::object());
  if (last_) {
    text.pop_back();
    text += fmt::format("{}\"command\":{}}}", text.size() > 1 ? "," : "", model::command_status_to_json(*last_));
  }
  if (text == shown_) return;
  shown_ = std::move(text);
  std::ignore = place_.space.set(key_.status(), shown_, kJson);
}

/// One that takes time is alone: the outcome of the last command is that of the one under way.
tuples::SetDecision CommandKey::decide(const tuples::RemoteSet& set) {
  if (calls_.begin && (is_under_way_ || !waiting_.empty()))
    return tuples::SetDecision::refused({ErrorCode::kBusy, "the same command is under way, wait for its outcome"});
  if (waiting_.size() >= kMostWaiting)
    return tuples::SetDecision::refused({ErrorCode::kBusy, "too many commands wait to be carried out"});
  if (auto good = calls_.check(set.value); !good) return tuples::SetDecision::refused(std::move(good.error()));
  waiting_.push_back(
      {{set.from, proxy::commander_name(place_.space, place_.config, set.from), set.request}, set.value});
  next_.request();
  return tuples::SetDecision::applied();
}

void CommandKey::run_next() {
  auto now = std::move(waiting_.front());
  waiting_.pop_front();
  if (!waiting_.empty()) next_.request();
  ++begun_;
  const auto done = calls_.begin ? begin(now.text) : calls_.run(now.text);
  last_ = {{}, std::move(now.commander), std::move(now.text), {}, {}, {}, {}};
  if (!done || !calls_.begin) return end(done);
  is_under_way_ = true;
  patience_ = place_.scheduler.after(calls_.longest, [this] {
    is_under_way_ = false;
    set_state("timed-out", "there is no outcome yet");
  });
  set_state("sent", {}, calls_.longest);
}

Result<void> CommandKey::begin(const std::string& text) {
  return calls_.begin(text, lifetime_.guard([this, number = begun_](const Result<void>& outcome) {
    if (is_under_way_ && number == begun_) end(outcome);
  }));
}

void CommandKey::end(const Result<void>& outcome) {
  is_under_way_ = false;
  patience_.cancel();
  if (outcome) return set_state("confirmed", {});
  set_state(outcome.error().code == ErrorCode::kIo ? "failed" : "refused", outcome.error().text);
}

void CommandKey::set_state(std::string_view state, std::string reason, Duration longest) {
  last_->state = state;
  last_->reason = std::move(reason);
  last_->since = place_.scheduler.wall_now();
  last_->until =
      longest > Duration::zero() ? last_->since + std::chrono::ceil<std::chrono::microseconds>(longest) : WallTime{};
  show();
}

}  // namespace rubicon::island
