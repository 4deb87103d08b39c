#include "web/api/tracked_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "model/json_members.h"
#include "model/point_keys.h"
#include "rubicon/key.hpp"
#include "verbs/answers.h"
#include "web/api/naming.h"
#include "web/api/route.h"

namespace rubicon::web::api {

namespace {

/// How long to wait for the outcome of a command that must have ended.
constexpr Duration kUsualWait = std::chrono::seconds(15);

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

TrackedSet::TrackedSet(Context& context, const SetRequest& request, Callbacks calls)
    : callbacks_(std::move(calls)), is_command_(may_have_states(request.key) && !request.append) {
  const auto asker = "token:" + request.caller.name;
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
  if (!is_command_) {
    const auto number = verbs::send(space, request, on_reply, asker);
    if (!request.append) *spoken_for = context.permission.speak_for(request.caller, space.self(), number);
  } else {
    tracker_ = std::make_unique<client::RemoteSetTracker>(
        context.scheduler, space, request.owner, request.key, request.value,
        [this](const client::Outcome& outcome) { change_state(outcome, true); }, request.time_to_live, kUsualWait,
        [this](const client::Outcome& outcome) { change_state(outcome, false); }, on_reply,
        verbs::options_of(request, asker), std::move(record));
  }
}

void TrackedSet::reply(const tuples::Reply& reply) {
  if (std::exchange(replied_, true)) return;
  accepted_ = reply.verdict == tuples::Verdict::kApplied;
  callbacks_.replied(reply);
}

/// The first state may be faster than the reply: it implies that the owner accepted. A request that was refused ends
/// with the reply.
void TrackedSet::change_state(const client::Outcome& outcome, bool is_final) {
  tuples::Reply implied;
  implied.request = outcome.request;
  reply(implied);
  if (accepted_) callbacks_.state_changed(outcome, is_final);
}

namespace {

struct StateAnswer {
  std::string_view state;
  unsigned status;
  ErrorCode code;  ///< of the error where the status is one
};
constexpr std::array<StateAnswer, 11> kStates{{{"applied", 200, {}},
                                               {"confirmed", 200, {}},
                                               {"assumed", 200, {}},
                                               {"queued", 202, {}},
                                               {"sent", 202, {}},
                                               {"no-such-owner", 404, ErrorCode::kNotFound},
                                               {"refused", 409, ErrorCode::kRefused},
                                               {"superseded", 409, ErrorCode::kRefused},
                                               {"failed", 502, ErrorCode::kUnreachable},
                                               {"timed-out", 504, ErrorCode::kExpired},
                                               {"expired", 504, ErrorCode::kExpired}}};

const StateAnswer& answer_of(std::string_view state) {
  const auto found =
      std::find_if(kStates.begin(), kStates.end(), [state](const auto& one) { return one.state == state; });
  return found == kStates.end() ? *(kStates.end() - 3) : *found;  // a state of later islands: failed
}

/// A request that cannot be meant is not a conflict with what the island has.
unsigned status_of(const StateAnswer& answer, const std::optional<Error>& error) {
  if (!error || answer.status != 409) return answer.status;
  if (error->code == ErrorCode::kNotFound) return 404;
  return error->code == ErrorCode::kInvalid || error->code == ErrorCode::kOutOfRange ? 400 : answer.status;
}

constexpr Duration kMaxWait = std::chrono::minutes(9);  // the server ends what is not answered after ten
/// An owner that is there replies in this time.
constexpr Duration kReplyTime = std::chrono::seconds(5);

/// What curl and forms send unless they are given another type.
constexpr std::string_view kFormType = "application/x-www-form-urlencoded";

/// The members of a set, from the path, the query, the headers and the body.
Result<verbs::Set> read_put(Call& call) {
  const auto verb = call.query.text_or("do", "set");
  if (verb != "set" && verb != "append") return fail(verbs::no_verb(verb, {"append", "set"}));
  call.query.add("key", call.parts[0] + ":" + call.parts[1]);
  call.query.add("value", call.request.body);
  const auto type = call.request.header("content-type");
  if (!type.empty() && !type.starts_with(kFormType)) call.query.add("media", type);
  return verbs::read_set(call.query, verb == "append", call.context.scheduler.wall_now());
}

}  // namespace

unsigned status_of_outcome(std::string_view state) {
  return answer_of(state).status;
}

PutExchange::PutExchange(Context& context, SetRequest request, Duration wait, Respond respond)
    : context_(context),
      request_(std::move(request)),
      wait_(wait),
      respond_(std::move(respond)),
      start_(context.scheduler.now()) {
  TrackedSet::Callbacks calls{[this](const tuples::Reply& reply) { replied(reply); },
                              [this](const client::Outcome& outcome, bool is_final) {
                                outcome_ = outcome;
                                if (is_final) finish();
                              }};
  outcome_.state = "sent";
  outcome_.reason = "the owner has not replied yet";
  patience_ = context_.scheduler.after(std::max(wait_, kReplyTime), [this] { finish(); });
  set_ = std::make_unique<TrackedSet>(context, request_, std::move(calls));
}

void PutExchange::replied(const tuples::Reply& reply) {
  const auto verdict = verbs::verdict_of(reply, request_.owner);
  outcome_.request = reply.request;
  outcome_.reason.clear();
  outcome_.state = verdict ? "applied" : std::string(to_string(reply.verdict));
  if (!verdict) {
    outcome_.reason = verdict.error().text;
    return finish(verdict.error());
  }
  if (!may_have_states(request_.key) || request_.append) return finish();
  outcome_.state = "queued";  // until the status says more
  patience_ = context_.scheduler.at(std::max(start_ + wait_, context_.scheduler.now()), [this] { finish(); });
}

/// The set reports its end, so it is destroyed in a later turn, with this.
void PutExchange::finish(std::optional<Error> error) {
  if (!respond_) return;
  patience_.cancel();
  const auto& answer = answer_of(outcome_.state);
  nlohmann::ordered_json tree;
  tree["owner"] = number(request_.owner);
  tree["key"] = request_.key;
  tree["state"] = outcome_.state;
  tree["reason"] = outcome_.reason;
  tree["request"] = outcome_.request;
  if (outcome_.until != WallTime{}) tree["until"] = model::seconds_json(outcome_.until);
  tree["seconds"] = std::chrono::duration<double>(context_.scheduler.now() - start_).count();
  if (answer.status >= 400 && !error)
    error = Error{answer.code, outcome_.reason.empty() ? outcome_.state : outcome_.state + ": " + outcome_.reason};
  if (error) tree["error"] = verbs::error_json(*error);
  auto response = json_response(tree, status_of(answer, error));
  if (may_have_states(request_.key))
    response.headers.emplace_back("Location",
                                  fmt::format("/api/v1/tuples/{}/{}", number(request_.owner),
                                              model::PointKey{std::string(model::parent_key(request_.key))}.status()));
  lifetime_.post(context_.scheduler, [respond = std::exchange(respond_, nullptr), response = std::move(response)] {
    respond(response);  // may destroy this
  });
}

std::unique_ptr<Exchange> put_tuple(Call& call) {
  const auto naming = verbs::naming_of(call.request.parameter("do").value_or("set"));
  if (auto later = with_key_in_path(call, naming ? naming->last : "value", put_tuple)) return std::move(*later);
  const auto wait = call.query.span_or("wait", kUsualWait, std::chrono::seconds(1), kMaxWait);
  auto set = read_put(call);
  if (!set) return call.refuse(set.error());
  SetRequest request{std::move(*set), call.request.caller};
  auto& context = call.context;
  if (auto good = context.permission.check_set(request.caller, request, call.take_command()); !good)
    return call.refuse(good.error());
  ++context.counters.commands;
  return std::make_unique<PutExchange>(context, std::move(request), wait, call.respond);
}

}  // namespace rubicon::web::api
