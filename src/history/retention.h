#pragma once

#include <optional>
#include <string>

#include "history/store.h"
#include "rubicon/time.hpp"

namespace rubicon::history {

struct RetentionRules {
  std::optional<Duration> raw, hours;  ///< nullopt = for ever
  std::uint64_t size = 8'000'000'000;  ///< bytes
};

/// Removes what is too old, and the oldest day while the file is too large: slice by slice, so that questions between
/// them do not wait. Points become summaries of hours before they go.
///
/// It has a clock of its own, which the file keeps: that follows the clock of the machine at most four times as fast as
/// time passes while this runs. A clock that was set to next year by mistake therefore costs nothing for hours.
class Retention {
 public:
  Retention(Store& store, RetentionRules rules) : store_(store), rules_(rules) {}

  /// One slice, if one is due; to be called about once a second. Says what should be in the log, mostly nothing.
  Result<std::string> step(SteadyTime now, WallTime wall);
  /// The clock by which ages are counted; zero before the first step.
  WallTime clock() const { return clock_; }

 private:
  Result<void> advance(SteadyTime now, WallTime wall);
  Result<std::string> begin_round();
  Result<void> slice();
  Result<bool> slice_of(SeriesRow row);
  Result<void> keep_hours(SeriesRow row, const Points& points);
  Result<std::uint64_t> used_bytes();
  /// Until when the first block to end lasts.
  Result<std::optional<std::int64_t>> oldest_block();

  Store& store_;
  RetentionRules rules_;
  WallTime clock_{};
  SteadyTime last_{};
  bool started_ = false;
  SteadyTime next_round_{};
  bool in_round_ = false;
  SeriesRow next_row_ = 0;
  std::int64_t blocks_before_ = 0, hours_before_ = 0;  ///< what ended before these times goes in this round
  bool shrinking_ = false;
};

}  // namespace rubicon::history
