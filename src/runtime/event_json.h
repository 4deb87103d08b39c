#pragma once

#include <string>

#include "base/result.h"
#include "tuples/tuple.h"

namespace rubicon::runtime {

/// One line of --watch: owner, key, value, mimetype, seq, write, user, event (set, deleted, expired). Times are seconds
/// since 1970, 0 = not given. A value that is not UTF-8 stands as value_hex instead of value. `through` is added if it
/// is not empty: what the tuple was found by.
std::string event_line(const tuples::Event& event, std::string_view through = {});

/// Same fields without the event, with ok and creator: the answer to `get`.
std::string tuple_line(const tuples::TupleView& tuple);

/// {"ok":false,"error":{"code","text"}}
std::string error_line(const Error& error);

bool is_utf8(std::string_view text);

}  // namespace rubicon::runtime
