#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "history/series.h"
#include "model/point_tuples.h"
#include "rubicon/key.hpp"
#include "rubicon/tuple.hpp"

namespace rubicon::history {

/// The present time on two clocks: the clock of the tuples' times, which may be set, and a steady one.
struct Instant {
  WallTime wall{};
  SteadyTime steady{};

  /// In a recording both go on together.
  static Instant recorded(WallTime time) { return {time, SteadyTime(time.time_since_epoch())}; }
};

/// Makes points of the changes of tuples: numbers of texts, gaps where the quality of a point is not good, one point
/// where many are equal. Knows no file and no clock.
class Intake {
 public:
  explicit Intake(std::vector<Pattern> exclude) : exclude_(std::move(exclude)) {}

  /// Series that the file has: their kinds and words stay.
  void seed(const std::vector<Declaration>& known);
  /// A tuple was set: the value of a series, or the status or the description of a point.
  void changed(const TupleView& tuple, const Instant& now);
  /// A tuple was deleted, expired or is lost.
  void gone(OwnerId owner, std::string_view key, const Instant& now);
  /// To be called each few seconds: repeats steady values, and no longer waits for what does not come.
  void tick(const Instant& now);
  /// What came since the last time.
  Batch take(WallTime now);

  /// Points beyond this (of Batch::bytes) are dropped until take(), and counted; a mark of a gap follows them.
  void limit(std::size_t bytes) { limit_ = bytes; }
  std::size_t bytes() const { return bytes_; }
  std::uint64_t dropped() const { return dropped_; }
  /// Values that do not fit their series: a word among numbers, a text of more than kMaxTextLength bytes.
  std::uint64_t unfit() const { return unfit_; }
  /// Series with such values since the last call, each once in a run: at most kMaxNamedEntries.
  std::vector<Declaration> take_unfit() { return std::exchange(named_, {}); }
  /// Tuples that were not taken because there are kMaxSeries already.
  std::uint64_t refused() const { return refused_; }

  static constexpr std::size_t kMaxTextLength = 4096;
  static constexpr std::size_t kMaxWords = 256;
  static constexpr std::size_t kMaxNamedEntries = 20;
  static constexpr std::size_t kMaxSeries = 100'000;

 private:
  struct Held {
    WallTime time;
    std::string text;
  };
  struct Series {
    Slot slot = 0;
    Declaration declaration{};
    bool excluded = false;
    bool kind_known = false;
    bool seeded = false;    ///< the file has it
    bool declared = false;  ///< in a batch, as it is now
    bool point = false;     ///< has a status and a description
    std::optional<Quality> quality{};
    bool described = false;
    bool event = false;  ///< each value counts, and none is in force later
    std::string data_type{};
    SteadyTime seen{};            ///< first
    std::optional<Held> held{};   ///< a value that waits for the quality, or for it to become good
    std::optional<Point> last{};  ///< stored
    bool gap_due = false;         ///< `last` is the mark of a gap that found no room yet
    bool unfit = false;           ///< it had a value that does not fit
    std::int64_t skipped = 0;     ///< time of the latest value that equals it and was not stored; 0 = none
    std::string text{};           ///< the last value
    bool live = false;            ///< its times are those of the clock

    bool observed() const { return !quality || *quality == Quality::kGood || *quality == Quality::kAssumed; }
  };
  struct Hash {
    std::size_t operator()(const std::pair<OwnerId, std::string_view>& name) const;
  };

  /// nullptr: there are too many.
  Series* series_of(OwnerId owner, std::string_view key, const Instant& now);
  static bool early(const Series& series, const Instant& now);
  void value(Series& series, std::string_view text, WallTime time, const Instant& now);
  void quality(Series& series, Quality quality, WallTime time, const Instant& now);
  void describe(Series& series, std::string_view json, const Instant& now);
  void release(Series& series, const Instant& now);
  void store(Series& series, std::string_view text, WallTime time);
  void decide_kind(Series& series, std::string_view text);
  void store_number(Series& series, std::string_view text, std::int64_t time);
  void store_word(Series& series, std::string_view text, std::int64_t time);
  void store_text(Series& series, std::string_view text, std::int64_t time);
  void put(Series& series, const Point& point);
  void mark_gap(Series& series, WallTime time);
  void emit(Series& series, const Point& point);
  bool write_gap(Series& series);
  bool room(Series& series, std::size_t bytes);
  void drop(Series& series, std::int64_t gap);
  void refuse(Series& series);

  std::vector<Pattern> exclude_;
  std::deque<Series> series_;                                                   ///< by slot
  std::unordered_map<std::pair<OwnerId, std::string_view>, Slot, Hash> slots_;  ///< the keys are in series_
  std::string key_;                                                             ///< of a value, put together
  Batch batch_;
  std::size_t limit_ = kMaxWaitingCount, bytes_ = 0;
  std::vector<Declaration> named_;
  std::uint64_t dropped_ = 0, unfit_ = 0, refused_ = 0;
};

}  // namespace rubicon::history
