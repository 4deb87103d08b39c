#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "rubicon/tuple.hpp"

namespace rubicon::web::api {

/// Longer values, and those that are not UTF-8, are not sent with a subscription: a client asks for them by REST.
inline constexpr std::size_t kMaxSentValue = 16UL * 1024;

/// The time that a list shows: of the measurement, else of the write.
WallTime time_of(const TupleView& tuple);
/// What follows the number of a key in the frames of a subscription (docs/api.md): `"686.6",17,1795234047.25`, with
/// `full`, or without the value, a fifth member.
void append_update(const TupleView& tuple, bool full, std::string& out);
/// The answer to `get`: owner, key, value or b64, media, creator, sequence, write, user, expire, present.
nlohmann::ordered_json whole_tuple(const TupleView& tuple);

}  // namespace rubicon::web::api
