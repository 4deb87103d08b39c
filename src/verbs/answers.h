#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "rubicon/tuple_space.hpp"

// The parts of answers that are the same on the WebSocket, in REST and in the shell of a daemon (docs/api.md).
namespace rubicon::verbs {

/// The members of an answer, in the order they were given.
using Line = nlohmann::ordered_json;

/// {"code","text"}
Line error_json(const Error& error);

/// owner, key, value or b64, media, creator, sequence, write, user, expire, present.
Line tuple_json(const TupleView& tuple);

/// verdict, request, and the sequence if the owner said which one the tuple has.
Line reply_json(const tuples::Reply& reply);
/// What a reply says: no error if the owner accepted.
Result<void> verdict_of(const tuples::Reply& reply, OwnerId owner);

/// The error of a question for a tuple that is not there.
Error no_tuple(const TupleSpace& space, const Pattern& tuple);

/// One line: `begin`, such as the id of the request, then "ok", the content, and the error if there is one.
std::string answer_line(Line begin, const Result<void>& done, const Line& content = Line::object());

}  // namespace rubicon::verbs
