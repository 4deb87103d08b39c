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

tuples::SetDecision CommandKey::decide(const tuples::RemoteSet& set) {
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
  const auto done = calls_.run(now.text);
  const auto* state = done ? "confirmed" : done.error().code == ErrorCode::kIo ? "failed" : "refused";
  last_ = {state,
           std::move(now.commander),
           std::move(now.text),
           place_.scheduler.wall_now(),
           {},
           done ? std::string() : done.error().text,
           {}};
  show();
}

}  // namespace rubicon::island
