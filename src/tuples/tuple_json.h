#pragma once

#include <string>

#include "base/printable.h"
#include "rubicon/result.hpp"
#include "rubicon/tuple.hpp"

namespace rubicon::tuples {

/// One line of --watch: owner, key, value, mimetype, seq, write, user, time, event (set, deleted, expired). `write` and
/// `user` are seconds since 1970, 0 = not given; `time` is the user time, else the write time, as ISO 8601 with offset.
/// A value that is not UTF-8 is written as value_hex instead of value. `through`, the meta tuple that led to
/// the tuple, is added if it is not empty.
std::string event_line(const tuples::Event& event, std::string_view through = {});

/// The same members without the event, with ok and creator: the answer to `get`.
std::string tuple_line(const tuples::TupleView& tuple);

/// {"ok":false,"error":{"code","text"}}
std::string error_line(const Error& error);

}  // namespace rubicon::tuples
