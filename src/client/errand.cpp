#include "client/errand.h"

#include <fmt/format.h>

#include <utility>

#include "client/json_fields.h"

namespace rubicon::client {

namespace {

constexpr std::string_view kCommand = ".command";
/// A device that left may have moved: so long its new island has to tell of the command (docs/roaming.md).
constexpr Duration kMove = std::chrono::seconds(2);
constexpr Duration kDefaultTimeToLive = std::chrono::seconds(5);

bool is_final(std::string_view state) {
  return state != "queued" && state != "sent" && !state.empty();
}

}  // namespace

Errand::Errand(Scheduler& scheduler, TupleSpace& space, OwnerId owner, std::string_view key, std::string_view value,
               Ended ended, Duration time_to_live, Duration patience)
    : scheduler_(scheduler),
      self_(space.self()),
      owner_(owner),
      is_command_(key.ends_with(kCommand)),
      ended_(std::move(ended)) {
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
  patience_ = scheduler.after(lives + patience, [this] {
    if (outcome_.state.empty()) outcome_ = {"timed-out", "the owner did not answer", outcome_.request};
    end();
  });
  outcome_.request = space.set_remote(owner, key, value, time_to_live,
                                      [this, alive = std::weak_ptr<bool>(alive_)](const tuples::Reply& reply) {
                                        if (alive.lock()) answered(reply);
                                      });
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
  if (is_final(outcome_.state)) end();
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
  const auto number_of = [&by](const char* name) {
    const auto found = by.find(name);
    return found != by.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
  };
  outcome_.state = "superseded";
  outcome_.reason = fmt::format("by request {} of {}", number_of("request"), number_of("creator"));
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
