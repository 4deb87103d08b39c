#include "client/remote_set_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "model/point_keys.h"

namespace rubicon::client {

namespace {

/// A device that left may have moved; its new island has this long to report the command (docs/roaming.md).
constexpr Duration kMove = std::chrono::seconds(2);
constexpr Duration kDefaultTimeToLive = std::chrono::seconds(5);
/// Islands name shorter times; a larger one is cut to this.
constexpr Duration kMaxState = std::chrono::hours(24 * 366);

bool is_final(std::string_view state) {
  return state != "queued" && state != "sent" && !state.empty();
}

/// How long the state may last by the island's own clock; ours may be another.
Duration longest_of(const model::CommandStatus& command) {
  if (command.until <= command.since) return Duration(0);
  return std::min<Duration>(command.until - command.since, kMaxState);
}

/// The commander that superseded a command.
std::string name_of(const model::Commander& commander) {
  return commander.name.empty() ? fmt::format("component {}", number(commander.creator)) : commander.name;
}

}  // namespace

RemoteSetTracker::RemoteSetTracker(Scheduler& scheduler, TupleSpace& space, OwnerId owner, std::string_view key,
                                   std::string_view value, OutcomeCall ended, Duration time_to_live, Duration patience,
                                   OutcomeCall under_way, tuples::ReplyCall replied, const tuples::SetOptions& options,
                                   tuples::ReplyCall noted)
    : scheduler_(scheduler),
      self_(space.self()),
      owner_(owner),
      is_command_(key.ends_with(".command")),
      ended_(std::move(ended)),
      on_progress_(std::move(under_way)),
      replied_(std::move(replied)),
      margin_(patience) {
  has_states_ = is_command_ && (model::point_of(key) || model::is_of_island(key));
  if (is_command_) watch_point(space, {std::string(model::parent_key(key))});
  const auto lives = time_to_live > Duration(0) ? time_to_live : kDefaultTimeToLive;
  wait(lives);
  tuples::ReplyCall answer = lifetime_.guard([this](const tuples::Reply& reply) { answered(reply); });
  if (noted) {
    answer = [noted = std::move(noted), tell = std::move(answer)](const tuples::Reply& reply) {
      noted(reply);
      tell(reply);
    };
  }
  outcome_.request = space.set_remote(owner, key, value, lives, std::move(answer), options);
}

void RemoteSetTracker::watch_point(TupleSpace& space, const model::PointKey& point) {
  all_described_ = owner_ == self_;  // own tuples come before the reply
  description_ = space.subscribe(
      {owner_, point.description()}, {.passive = true},
      [this](const tuples::Event& event) {
        const auto about = model::point_description_from_json(event.tuple.value);
        has_states_ |= about && !about->report.empty();
        is_state_ = about && about->report == "state";
      },
      [this](OwnerId) {
        all_described_ = true;
        if (applied_) end_without_states();
      });
  status_ = space.subscribe({std::nullopt, point.status()}, {.passive = true},
                            [this](const tuples::Event& event) { status_changed(event); });
}

void RemoteSetTracker::wait(Duration longest) {
  timeout_ = scheduler_.after(longest + margin_, [this] { time_out(); });
}

/// By the island's own times the command has ended, but no outcome arrived.
void RemoteSetTracker::time_out() {
  if (outcome_.state.empty()) {
    outcome_.reason = "the owner did not answer";
  } else {
    outcome_.reason = fmt::format("no news of it since it was {}{}{}", outcome_.state,
                                  outcome_.reason.empty() ? "" : ": ", outcome_.reason);
  }
  outcome_.state = "timed-out";
  outcome_.until = {};
  end();
}

void RemoteSetTracker::answered(const tuples::Reply& reply) {
  if (!ended_) return;
  const auto watch = lifetime_.watch();
  const auto call = replied_;
  if (call) call(reply);  // may destroy this
  if (watch.ended()) return;
  if (reply.verdict == tuples::Verdict::kApplied) {
    applied_ = true;
    if (!reply.text.empty()) outcome_.reason = reply.text;
    return end_without_states();
  }
  outcome_.state = to_string(reply.verdict);
  outcome_.reason = reply.text;
  end();
}

/// The reply is the outcome, unless a status reports it.
void RemoteSetTracker::end_without_states() {
  if (!ended_ || has_states_ || seen_ || !all_described_) return;
  outcome_.state = "applied";
  end();
}

void RemoteSetTracker::status_changed(const tuples::Event& event) {
  if (!ended_) return;
  const auto& tuple = event.tuple;
  if (event.kind != EventKind::kSet) {
    if (tuple.owner == owner_) device_left();
    return;
  }
  // With many commanders the outcomes beside it are a long list, which each of their commands would read.
  if (!seen_ && tuple.value.find(fmt::to_string(outcome_.request)) == tuple.value.npos) return;
  const auto command = model::command_status_from_json(tuple.value);
  if (!command) return;
  if (command->commander.creator != self_ || command->commander.request != outcome_.request) {
    // Before the reply, the status may belong to a request with the same number from an earlier start.
    if (const auto ended =
            !applied_ ? std::nullopt : model::command_outcome_from_json(tuple.value, self_, outcome_.request)) {
      outcome_.state = ended->state;
      outcome_.reason = ended->reason;
      outcome_.until = {};
      return end();
    }
    if (tuple.owner == owner_) superseded_by(command->commander);
    return;
  }
  owner_ = tuple.owner;
  move_.cancel();
  seen_ = true;
  outcome_.state = command->state;
  outcome_.reason = command->reason;
  outcome_.until = command->until;
  if (is_final(outcome_.state)) return end();
  if (const auto longest = longest_of(*command); longest > Duration(0)) wait(longest);
  const auto call = on_progress_;
  const auto outcome = outcome_;
  if (call) call(outcome);  // may destroy this
}

void RemoteSetTracker::device_left() {
  move_ = scheduler_.after(kMove, [this] {
    outcome_.state = "failed";
    outcome_.reason = "the device left";
    end();
  });
}

/// The status of a newer command, without the outcome of ours beside it, though ours was there before.
void RemoteSetTracker::superseded_by(const model::Commander& by) {
  if (!seen_ || !is_state_) return;
  outcome_.state = "timed-out";
  outcome_.reason = fmt::format("not known how it ended before the command of {} came", name_of(by));
  end();
}

void RemoteSetTracker::end() {
  status_.reset();
  description_.reset();
  timeout_.cancel();
  move_.cancel();
  const auto call = std::exchange(ended_, nullptr);
  const auto outcome = outcome_;
  if (call) call(outcome);  // may destroy this
}

}  // namespace rubicon::client
