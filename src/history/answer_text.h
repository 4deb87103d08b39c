#pragma once

#include <string>
#include <vector>

#include "history/answer.h"
#include "history/point.h"
#include "rubicon/result.hpp"

namespace rubicon::history {

/// `number`, `words`, `text`.
std::string_view to_string(SeriesKind kind);

/// The JSON of docs/history.md#answers, on one line. Times are seconds since 1970.
std::string to_json(const Answer& answer);
/// One line for each bucket, and for each text; begins with the names of the columns. RFC 4180 with LF.
std::string to_csv(const Answer& answer);
/// `{"series":[{"key","kind","unit","words"?,"first","last"}]}`, on one line.
std::string to_json(const std::vector<SeriesEntry>& series);

/// `6541:proxy.wsn-1.7.sensor.light-1.value`.
std::string to_string(const SeriesName& name);
/// kInvalid for what has no owner or is no key.
Result<SeriesName> parse_series(std::string_view text);

/// Column names of append_point_line(), with their line end.
inline constexpr std::string_view kPointHeader = "time,owner,key,value\n";
/// One value; empty = a gap begins. RFC 4180 with LF.
void append_point_line(const SeriesName& name, WallTime time, std::string_view value, std::string& out);
/// The value as in its tuple; empty for a gap.
std::string value_text(const SeriesEntry& series, const Point& point);

}  // namespace rubicon::history
