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

/// Removes what is too old, and the oldest day while the file is too large or the disk almost full: slice by slice, so
/// that questions between them do not wait. Points become summaries of hours before they go. While the file is too
/// large, points, texts and summaries get shorter in proportion: what is oldest, measured by how long it may stay,
/// goes first. Series of which nothing is left go as well.
///
/// It has a clock of its own. Beyond the latest time that it ever had, which the file keeps, it follows the clock of
/// the machine at most four times as fast as time passes while this runs. A clock that was set to next year by mistake
/// therefore costs nothing for hours; one that was behind costs nothing at all.
class Retention {
 public:
  Retention(Store& store, RetentionRules rules) : store_(store), rules_(rules) {}

  /// One slice, if one is due; to be called about once a second. `free`: bytes that the disk has left; nullopt = not
  /// known. Says what should be in the log, mostly nothing.
  Result<std::string> step(SteadyTime now, WallTime wall, std::optional<std::uint64_t> free = std::nullopt);
  /// The clock by which ages are counted; zero before the first step.
  WallTime clock() const { return clock_; }

 private:
  Result<void> advance(SteadyTime now, WallTime wall);
  Result<void> begin_round();
  /// Why the file must become smaller; empty = it need not.
  Result<std::string> too_large(std::optional<std::uint64_t> free);
  Result<std::string> shrink(const std::string& why);
  Result<void> slice();
  Result<bool> slice_of(SeriesRow row);
  Result<void> keep_hours(SeriesRow row, Points points);
  /// The first of the times that `sql` finds for each series.
  Result<std::optional<std::int64_t>> oldest(const char* sql);

  Store& store_;
  RetentionRules rules_;
  WallTime clock_{};
  std::optional<WallTime> highest_{};  ///< that the clock ever was; nullopt: it was never plausible
  SteadyTime last_{};
  bool started_ = false;
  SteadyTime next_round_{}, next_look_{};
  bool in_round_ = false;
  SeriesRow next_row_ = 0;
  std::vector<SeriesRow> removed_;                                        ///< in this slice
  std::int64_t blocks_before_ = 0, texts_before_ = 0, hours_before_ = 0;  ///< what ended before goes in this round
};

}  // namespace rubicon::history
