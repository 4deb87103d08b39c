#include "client/errand.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "client/json_fields.h"

namespace rubicon::client {

namespace {

constexpr std::string_view kCommand = ".command";
/// A device that left may have moved: so long its new island has to tell of the command (docs/roaming.md).
constexpr Duration kMove = std::chrono::seconds(2);
constexpr Duration kDefaultTimeToLive = std::chrono::seconds(5);
/// No island says more; of a larger number this much is waited for.
constexpr Duration kLongestState = std::chrono::hours(24 * 366);

bool is_final(std::string_view state) {
  return state != "queued" && state != "sent" && !state.empty();
}

/// Zero if it is missing, or no time.
double seconds_of(const nlohmann::json& tree, const char* name) {
  const auto found = tree.find(name);
  return found != tree.end() && found->is_number() ? found->get<double>() : 0;
}

/// How long the state may last by the island's own clock; ours may be another.
Duration longest_of(const nlohmann::json& command) {
  const auto seconds = seconds_of(command, "until") - seconds_of(command, "since");
  if (!(seconds > 0)) return Duration(0);
  constexpr double kMost = std::chrono::duration<double>(kLongestState).count();
  return seconds >= kMost ? kLongestState
                          : std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds));
}

WallTime until_of(const nlohmann::json& command) {
  const auto seconds = seconds_of(command, "until");
  constexpr double kMost = 1e11;  // beyond the year 5000
  return WallTime(std::chrono::microseconds(seconds > 0 && seconds < kMost ? std::llround(seconds * 1e6) : 0));
}

/// Who superseded a command, by the status of the newer one.
std::string name_of(const nlohmann::json& command) {
  auto name = text_of(command, "commander");
  if (!name.empty()) return name;
  const auto creator = command.find("creator");
  return fmt::format("component {}",
                     creator != command.end() && creator->is_number_unsigned() ? creator->get<std::uint64_t>() : 0);
}

}  // namespace

Errand::Errand(Scheduler& scheduler, TupleSpace& space, OwnerId owner, std::string_view key, std::string_view value,
               OutcomeCall ended, Duration time_to_live, Duration patience, OutcomeCall under_way)
    : scheduler_(scheduler),
      self_(space.self()),
      owner_(owner),
      is_command_(key.ends_with(kCommand)),
      ended_(std::move(ended)),
      under_way_(std::move(under_way)),
      margin_(patience) {
  if (is_command_) {
    const std::string point(key.substr(0, key.size() - kCommand.size()));
    description_ =
        space.subscribe({owner, point + ".description"}, {{}, {}, 0, true}, [this](const tuples::Event& event) {
          const auto about = nlohmann::json::parse(event.tuple.value, nullptr, false);
          is_state_ = about.is_object() && text_of(about, "report") == "state";
        });
    status_ = space.subscribe({std::nullopt, point + ".status"}, {{}, {}, 0, true},
                              [this](const tuples::Event& event) { stated(event); });
  }
  const auto lives = time_to_live > Duration(0) ? time_to_live : kDefaultTimeToLive;
  wait(lives);
  outcome_.request = space.set_remote(owner, key, value, lives,
                                      [this, alive = std::weak_ptr<bool>(alive_)](const tuples::Reply& reply) {
                                        if (alive.lock()) answered(reply);
                                      });
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
  const auto status = nlohmann::json::parse(tuple.value, nullptr, false);
  if (!status.is_object() || !status.contains("command") || !status["command"].is_object()) return;
  const auto& command = status["command"];
  const auto is = [&](const char* name, std::uint64_t wanted) {
    const auto found = command.find(name);
    return found != command.end() && found->is_number_unsigned() && *found == wanted;
  };
  if (!is("creator", number(self_)) || !is("request", outcome_.request)) {
    if (tuple.owner == owner_) displaced(command);
    return;
  }
  owner_ = tuple.owner;
  move_.cancel();
  seen_ = true;
  outcome_.state = text_of(command, "state");
  outcome_.reason = text_of(command, "reason");
  outcome_.until = until_of(command);
  if (is_final(outcome_.state)) return end();
  if (const auto longest = longest_of(command); longest > Duration(0)) wait(longest);
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
void Errand::displaced(const nlohmann::json& by) {
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
