#include "client/errand.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "model/point_keys.h"

namespace rubicon::client {

namespace {

/// A device that left may have moved: so long its new island has to tell of the command (docs/roaming.md).
constexpr Duration kMove = std::chrono::seconds(2);
constexpr Duration kDefaultTimeToLive = std::chrono::seconds(5);
/// No island says more; of a larger number this much is waited for.
constexpr Duration kLongestState = std::chrono::hours(24 * 366);

bool is_final(std::string_view state) {
  return state != "queued" && state != "sent" && !state.empty();
}

/// How long the state may last by the island's own clock; ours may be another.
Duration longest_of(const model::CommandStatus& command) {
  if (command.until <= command.since) return Duration(0);
  return std::min<Duration>(command.until - command.since, kLongestState);
}

/// Who superseded a command, by the status of the newer one.
std::string name_of(const model::Commander& commander) {
  return commander.name.empty() ? fmt::format("component {}", number(commander.creator)) : commander.name;
}

}  // namespace

Errand::Errand(Scheduler& scheduler, TupleSpace& space, OwnerId owner, std::string_view key, std::string_view value,
               OutcomeCall ended, Duration time_to_live, Duration patience, OutcomeCall under_way)
    : scheduler_(scheduler),
      self_(space.self()),
      owner_(owner),
      is_command_(model::last_part(key) == "command"),
      ended_(std::move(ended)),
      under_way_(std::move(under_way)),
      margin_(patience) {
  if (is_command_) {
    const model::PointKey point{std::string(model::parent_key(key))};
    description_ = space.subscribe({owner, point.description()}, {.passive = true}, [this](const tuples::Event& event) {
      const auto about = model::point_description_from_json(event.tuple.value);
      is_state_ = about && about->report == "state";
    });
    status_ = space.subscribe({std::nullopt, point.status()}, {.passive = true},
                              [this](const tuples::Event& event) { stated(event); });
  }
  const auto lives = time_to_live > Duration(0) ? time_to_live : kDefaultTimeToLive;
  wait(lives);
  outcome_.request = space.set_remote(owner, key, value, lives,
                                      lifetime_.guard([this](const tuples::Reply& reply) { answered(reply); }));
}

void Errand::wait(Duration longest) {
  patience_ = scheduler_.after(longest + margin_, [this] { unheard(); });
}

/// Its time is over by all that is known, so that it is not under way any more: how it ended is not known.
void Errand::unheard() {
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

void Errand::answered(const tuples::Reply& reply) {
  if (!ended_) return;
  if (reply.verdict == tuples::Verdict::kApplied) {
    if (is_command_) return;  // its status tells the rest
    outcome_.state = "applied";
  } else {
    outcome_.state = to_string(reply.verdict);
    outcome_.reason = reply.text;
  }
  end();
}

void Errand::stated(const tuples::Event& event) {
  if (!ended_) return;
  const auto& tuple = event.tuple;
  if (event.kind != EventKind::kSet) {
    if (tuple.owner == owner_) left();
    return;
  }
  const auto command = model::command_status_from_json(tuple.value);
  if (!command) return;
  if (command->commander.creator != self_ || command->commander.request != outcome_.request) {
    if (tuple.owner == owner_) displaced(command->commander);
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
  const auto call = under_way_;
  const auto outcome = outcome_;
  if (call) call(outcome);  // may end this
}

void Errand::left() {
  move_ = scheduler_.after(kMove, [this] {
    outcome_.state = "failed";
    outcome_.reason = "the device left";
    end();
  });
}

/// Of several changes within a turn of the owner only the last one is told: that a newer command took the place of
/// ours may be seen by that one alone.
void Errand::displaced(const model::Commander& by) {
  if (!seen_ || !is_state_) return;
  outcome_.state = "superseded";
  outcome_.reason = "by " + name_of(by);
  end();
}

void Errand::end() {
  status_.reset();
  description_.reset();
  patience_.cancel();
  move_.cancel();
  const auto call = std::exchange(ended_, nullptr);
  const auto outcome = outcome_;
  if (call) call(outcome);  // may end this
}

}  // namespace rubicon::client
