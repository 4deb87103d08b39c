#pragma once

#include <string>

#include "recording/record.h"

namespace rubicon::recording {

/// Column names of append_csv_line(), with their line end.
inline constexpr std::string_view kCsvHeader =
    "seen,event,owner,key,value,encoding,media_type,creator,sequence,write,user,expire\n";

/// Appends one field by RFC 4180, in quotation marks where that is necessary.
void append_csv_cell(std::string_view text, std::string& out);
/// A line by RFC 4180 with LF. Times are seconds since 1970 with microseconds, empty = not given. Values that are not
/// UTF-8 are in hexadecimal digits, with the encoding `hex`.
void append_csv_line(const recording::Record& record, std::string& out);
/// The same fields as JSON; binary values as `value_hex`.
void append_json_line(const recording::Record& record, std::string& out);

/// `2026-01-31 12:00:00.250000 UTC`; in seconds since 1970 for years before 1970 and after 9999.
std::string utc_text(WallTime time);

}  // namespace rubicon::recording
