#pragma once

#include <chrono>
#include <optional>

#include "rubicon/time.hpp"

namespace rubicon::networks::log {

/// Time as recordings write it; microseconds, so that any calendar fits.
using RecordTime = std::chrono::microseconds;

/// From the times in a recording to the times of its replay: a gap in the recording is a pause divided by the speed, a
/// step backwards is no pause, and pauses may have an upper limit. Drift-free: every due time counts from the start.
class ReplayClock {
 public:
  /// Speed 0 = as fast as possible. `start` = how much of the recording is passed over at once.
  ReplayClock(double speed, std::optional<Duration> longest_gap, Duration start);

  /// The recording begins (again) now.
  void restart(SteadyTime now);
  /// The next record's time has nothing to do with the last one's: it comes `gap` after it.
  void break_off(RecordTime gap);
  /// Takes the next record's time; gives how far into the recording it is.
  RecordTime advance(RecordTime time);

  bool passed_over(RecordTime position) const { return position < start_; }
  SteadyTime due(RecordTime position) const;
  bool went_back() const { return went_back_; }
  bool as_fast_as_possible() const { return speed_ == 0; }

 private:
  double speed_;
  std::optional<RecordTime> longest_gap_;
  RecordTime start_;
  SteadyTime started_{};
  RecordTime position_{0};
  RecordTime pending_{0};
  std::optional<RecordTime> last_;
  bool went_back_ = false;
};

}  // namespace rubicon::networks::log
