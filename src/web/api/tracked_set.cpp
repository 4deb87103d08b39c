#include "web/api/tracked_set.h"

#include <fmt/format.h>

#include <utility>

#include "rubicon/key.hpp"

namespace rubicon::web::api {

namespace {

/// Without rights no audit says who asked, and the owner knows the page only: the log says which token it was, once a
/// minute for each tuple of a token. Empty where there are no tokens.
std::function<void(const tuples::Reply&)> noted_in_log(Context& context, const SetRequest& request) {
  if (!context.access.rules().needs_token) return nullptr;
  return [log = context.set_log, name = request.caller.name, peer = request.caller.peer, owner = request.owner,
          key = request.key, value = request.value](const tuples::Reply& reply) {
    log->info(fmt::format("{}/{}:{}", name, number(owner), key),
              fmt::format("token {} of {}: {}:{} = {}, {}", model::quoted(name), peer, number(owner), key,
                          model::quoted(value), to_string(reply.verdict)));
  };
}

}  // namespace

bool may_have_states(std::string_view key) {
  return key.ends_with(".command");
}

Result<void> verdict_of(const tuples::Reply& reply, OwnerId owner) {
  switch (reply.verdict) {
    case tuples::Verdict::kApplied: return {};
    case tuples::Verdict::kRefused: return fail(reply.code, reply.text);
    case tuples::Verdict::kExpired:
    case tuples::Verdict::kTimedOut:
      return fail(ErrorCode::kExpired, fmt::format("component {}: {}", number(owner), reply.text));
    case tuples::Verdict::kNoSuchOwner: break;
  }
  return fail(ErrorCode::kNotFound, fmt::format("no component {} is present", number(owner)));
}

TrackedSet::TrackedSet(Context& context, const SetRequest& request, Calls calls)
    : calls_(std::move(calls)), is_command_(may_have_states(request.key) && !request.append) {
  const auto asker = "token:" + request.caller.name;
  const tuples::SetOptions options{request.media_type, request.user_time, request.lifetime, request.sequence, asker};
  auto record = context.permission.recorder(request);
  if (!record) record = noted_in_log(context, request);
  tuples::ReplyCall on_reply = lifetime_.guard([this](const tuples::Reply& answer) { reply(answer); });
  auto& space = context.space;
  const auto spoken_for = std::make_shared<tuples::Handle>();
  if (!is_command_ && record) {
    on_reply = [record, spoken_for, tell = std::move(on_reply)](const tuples::Reply& answer) {
      record(answer);
      tell(answer);
    };
  }
  if (request.append) {
    space.append_remote(request.owner, request.key, request.value, request.time_to_live, on_reply, options);
  } else if (!is_command_) {
    const auto number =
        space.set_remote(request.owner, request.key, request.value, request.time_to_live, on_reply, options);
    *spoken_for = context.permission.speak_for(request.caller, space.self(), number);
  } else {
    tracker_ = std::make_unique<client::RemoteSetTracker>(
        context.scheduler, space, request.owner, request.key, request.value,
        [this](const client::Outcome& outcome) { change_state(outcome, true); }, request.time_to_live, request.patience,
        [this](const client::Outcome& outcome) { change_state(outcome, false); }, on_reply, options, std::move(record));
  }
}

void TrackedSet::reply(const tuples::Reply& reply) {
  if (std::exchange(replied_, true)) return;
  accepted_ = reply.verdict == tuples::Verdict::kApplied;
  calls_.replied(reply);
}

/// The first state may be faster than the reply: it implies that the owner accepted. A request that was refused ends
/// with the reply.
void TrackedSet::change_state(const client::Outcome& outcome, bool is_final) {
  tuples::Reply implied;
  implied.request = outcome.request;
  reply(implied);
  if (accepted_) calls_.state_changed(outcome, is_final);
}

}  // namespace rubicon::web::api
