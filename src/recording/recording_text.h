#pragma once

#include <string>

#include "recording/record.h"

namespace rubicon::recording {

/// Column names of append_csv_line(), with their line end.
inline constexpr std::string_view kCsvHeader =
    "seen,event,owner,key,value,encoding,media_type,creator,sequence,write,user,expire\n";

/// RFC 4180 with LF; times are seconds since 1970 with microseconds, empty = not given. Values that are no UTF-8 text
/// are in hex, and `encoding` says so.
void append_csv_line(const recording::Record& record, std::string& out);
/// The same fields as JSON; binary values as `value_hex`.
void append_json_line(const recording::Record& record, std::string& out);

/// `2026-01-31 12:00:00.250000 UTC`; seconds since 1970 where no calendar reaches.
std::string utc_text(WallTime time);

}  // namespace rubicon::recording
