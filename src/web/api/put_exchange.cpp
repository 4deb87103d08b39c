#include "web/api/put_exchange.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "model/json_members.h"
#include "model/point_keys.h"
#include "web/api/media_type.h"
#include "web/api/route.h"

namespace rubicon::web::api {

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

/// A request that cannot be meant is no conflict with what the island has.
unsigned status_of(const StateAnswer& answer, const std::optional<Error>& error) {
  if (!error || answer.status != 409) return answer.status;
  if (error->code == ErrorCode::kNotFound) return 404;
  return error->code == ErrorCode::kInvalid || error->code == ErrorCode::kOutOfRange ? 400 : answer.status;
}

constexpr Duration kUsualWait = std::chrono::seconds(15);
constexpr Duration kLongestWait = std::chrono::minutes(9);  // the server ends what is not answered after ten
/// An owner that is there replies in this time.
constexpr Duration kReplyTime = std::chrono::seconds(5);

/// What curl and forms send unless they are given another type.
constexpr std::string_view kFormType = "application/x-www-form-urlencoded";

Result<SetRequest> read_put(Call& call) {
  SetRequest request;
  const auto owner = owner_of(call.parts[0]);
  if (!owner) return fail(owner.error());
  request.owner = *owner;
  request.key = call.parts[1];
  request.value = call.request.body;
  if (auto good = model::check_key(request.key); !good) return fail(good.error());
  request.caller = call.request.caller;
  request.append = call.query.flag("append");
  const auto field = call.request.header("content-type");
  request.media_type = request.append ? "" : "text/plain";
  if (!field.empty() && !field.starts_with(kFormType)) {
    auto type = media_type_of(field);
    if (!type) return fail(type.error());
    request.media_type = std::move(*type);
  }
  const auto now = call.context.scheduler.wall_now();
  request.time_to_live = call.query.duration("ttl", Duration(0), kLongestRequest);
  request.sequence = call.query.count("sequence");
  request.user_time = call.query.time("user", {}, now);
  request.lifetime = call.query.duration("lifetime", Duration(0), kLongestRequest);
  return request;
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
  TrackedSet::Calls calls{[this](const tuples::Reply& reply) { replied(reply); },
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
  const auto verdict = verdict_of(reply, request_.owner);
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
  if (error) tree["error"] = {{"code", to_string(error->code)}, {"text", error->text}};
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
  auto request = read_put(call);
  const auto wait = call.query.duration("wait", kUsualWait, kLongestWait);
  if (!request) return call.refuse(request.error());
  if (auto good = call.query.end(); !good) return call.refuse(good.error());
  auto& context = call.context;
  if (auto good = context.permission.check_set(request->caller, *request, call.take_command()); !good)
    return call.refuse(good.error());
  ++context.counters.commands;
  return std::make_unique<PutExchange>(context, std::move(*request), wait, call.respond);
}

}  // namespace rubicon::web::api
