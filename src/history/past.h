#pragma once

#include <vector>

#include "history/buckets.h"
#include "history/store.h"

namespace rubicon::history {

/// What the series of the question were: blocks, open points, and the summaries of hours where there are no blocks any
/// more. kInvalid: a question beyond its limits, or a damaged file; kExpired: an interruption; kIo: it cannot be read.
Result<Answer> answer(Store& store, const Question& question);

/// The series that match.
Result<std::vector<SeriesEntry>> list_series(Store& store, const Pattern& pattern, const SeriesRange& range = {});

/// Visits the points of one series in [from, to), in order of time, gaps too. Stops when `visit` returns false.
Result<void> each_point(Store& store, SeriesRow row, std::int64_t from, std::int64_t to,
                        const std::function<bool(const Point&)>& visit);
/// The same for the texts of a series.
Result<void> each_text(Store& store, SeriesRow row, std::int64_t from, std::int64_t to,
                       const std::function<bool(const TextValue&)>& visit);

}  // namespace rubicon::history
