#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "base/text.h"
#include "rubicon/tuple.hpp"

namespace rubicon::tuples {

/// The value of a tuple as text; in hexadecimal digits where it is not UTF-8.
std::string value_text(const TupleView& tuple);

/// The one form of a tuple in JSON lines: owner, key, value, mimetype, seq, write, user, time. `write` and `user` are
/// seconds since 1970, 0 = not given; `time` is the user time, else the write time, as ISO 8601 with offset. A value
/// that is not UTF-8 is in value_hex instead of value.
nlohmann::ordered_json tuple_json(const TupleView& tuple);

/// One line of --watch: the tuple, and event (set, deleted, expired). `through`, if not empty, names the meta tuple
/// that led to it.
std::string event_line(const tuples::Event& event, std::string_view through = {});

}  // namespace rubicon::tuples
