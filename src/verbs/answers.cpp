#include "verbs/answers.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/bytes.h"
#include "base/text.h"
#include "model/json_members.h"
#include "rubicon/key.hpp"
#include "tuples/refusals.h"

namespace rubicon::verbs {

Line error_json(const Error& error) {
  return {{"code", to_string(error.code)}, {"text", error.text}};
}

Line tuple_json(const TupleView& tuple) {
  const bool is_text = base::is_utf8(tuple.value);
  return {{"owner", number(tuple.owner)},
          {"key", tuple.key},
          {is_text ? "value" : "b64", is_text ? std::string(tuple.value) : base::to_base64(tuple.value)},
          {"media", tuple.media_type},
          {"creator", number(tuple.creator)},
          {"sequence", tuple.sequence},
          {"write", model::seconds_json(tuple.write_time)},
          {"user", model::seconds_json(tuple.user_time)},
          {"expire", model::seconds_json(tuple.expire_time)},
          {"present", tuple.owner_present}};
}

Line reply_json(const tuples::Reply& reply) {
  Line line{{"verdict", to_string(reply.verdict)}, {"request", reply.request}};
  if (reply.sequence != 0) line["sequence"] = reply.sequence;
  return line;
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
  return fail(tuples::no_component(owner));
}

Error no_tuple(const TupleSpace& space, const Pattern& tuple) {
  const auto owner = tuple.owner.value_or(model::kNoOwner);
  const auto peers = space.peers();
  const bool is_there = owner == space.self() || std::find(peers.begin(), peers.end(), owner) != peers.end();
  if (is_there) return {ErrorCode::kNotFound, fmt::format("no tuple {}", to_string(tuple))};
  return tuples::no_component(owner);
}

std::string answer_line(Line begin, const Result<void>& done, const Line& content) {
  begin["ok"] = done.has_value();
  begin.update(content);
  if (!done) begin["error"] = error_json(done.error());
  return model::dump(begin);
}

}  // namespace rubicon::verbs
