#include "bridges/command_desk.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::bridges {

namespace {

constexpr Duration kPatience = std::chrono::seconds(15);

tuples::RemoteSet remote_set(const PointEntry& point, std::string_view value) {
  tuples::RemoteSet set;
  set.owner = point.device->island;
  set.key = point.key + ".command";
  set.value = value;
  set.media_type = "text/plain";
  return set;
}

}  // namespace

Result<void> CommandDesk::check(const PointEntry& point, std::string_view value, std::string_view sender) const {
  if (value.size() > kMaxText)
    return fail(ErrorCode::kOutOfRange, fmt::format("{} bytes, expected at most {}", value.size(), kMaxText));
  if (under_way_.size() >= kMaxUnderWay)
    return fail(ErrorCode::kBusy, fmt::format("{} commands are under way already", kMaxUnderWay));
  return may(remote_set(point, value), sender);
}

/// The configuration of the bridge first, then the rights of the island; what they refuse is in the audit.
Result<void> CommandDesk::may(const tuples::RemoteSet& set, std::string_view sender) const {
  const tuples::Member member{"bridge:" + host_.name};
  Result<void> answer;
  if (!takes_command(scope_, set.key))
    answer = fail(ErrorCode::kRefused,
                  fmt::format("{} may not set {}: its `commands` do not name it", member.name, set.key));
  if (!host_.judge) return answer;
  if (answer) answer = host_.judge->may_set(member, set);
  if (!answer)
    host_.judge->answered(member, sender, set, {{}, 0, Verdict::kRefused, answer.error().code, answer.error().text});
  return answer;
}

void CommandDesk::send(const PointEntry& point, std::string_view value, std::string_view sender, Duration lives,
                       client::OutcomeCall ended) {
  const auto asker = "bridge:" + host_.name;
  tuples::ReplyCall noted;
  if (host_.judge) {
    noted = [judge = host_.judge, asker, from = std::string(sender),
             set = remote_set(point, value)](const Reply& reply) { judge->answered({asker}, from, set, reply); };
  }
  const auto at = under_way_.insert(under_way_.end(), Running{});
  const auto finish = [this, at, call = std::move(ended)](const client::Outcome& outcome) {
    call(outcome);
    under_way_.erase(at);
  };
  SetOptions options;
  options.asker = asker;
  at->tracker = std::make_unique<client::RemoteSetTracker>(host_.scheduler, host_.space, point.device->island,
                                                           point.key + ".command", value, finish, lives, kPatience,
                                                           nullptr, nullptr, options, std::move(noted));
  if (host_.judge) at->spoken_for = host_.judge->speak_for({asker}, host_.space.self(), at->tracker->request());
}

}  // namespace rubicon::bridges
