#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "base/log.h"
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
/// goes first. Empty series go as well.
///
/// It has a clock of its own. Beyond the latest time that it ever had, which the file keeps, it follows the clock of
/// the machine at most four times as fast as time passes while this runs. So if a clock was set to next year by
/// mistake, nothing is lost for hours; if it was behind, nothing is lost at all.
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

/// The worker's side of a history: opens the file, writes batches and removes what is old; after a failure it tries
/// again. A damaged file is set aside.
class Keeper {
 public:
  /// Bytes that may still be written beside a file; nullopt = not known.
  using FreeSpace = std::function<std::optional<std::uint64_t>(const std::string& path)>;

  Keeper(std::string path, RetentionRules rules);
  Keeper(std::string path, RetentionRules rules, FreeSpace free)
      : path_(std::move(path)), rules_(rules), free_(std::move(free)) {}

  /// What the loop should know.
  struct Report {
    bool opened = false;  ///< just now; then `series` are those of the file
    std::vector<Declaration> series{};
    std::uint64_t points = 0;    ///< written since the last report
    std::uint64_t dropped = 0;   ///< since the last report: points that the file does not take
    std::size_t waiting = 0;     ///< bytes of what could not be written yet
    std::size_t unwritten = 0;   ///< points of what could not be written yet
    std::uint64_t failures = 0;  ///< since the last report
    std::string reason{};        ///< why nothing can be written; empty = all is written
    std::uint64_t bytes = 0;     ///< of the file
    std::vector<std::pair<base::LogLevel, std::string>> log{};
  };
  /// Writes a batch and does what is due. `now` and `wall` are those of the loop.
  Report work(Batch batch, SteadyTime now, WallTime wall);
  /// Writes the last batch and what waits, also in a pause after a failure, and waits for the disk. The file is not
  /// checked for that: the next start does it. What still waits in the report is lost.
  Report finish(Batch batch, SteadyTime now, WallTime wall);
  /// Only finish() follows: the check of the file, and a question, end early. May be called from any thread.
  void end() { ending_.request_stop(); }
  std::stop_token ending() const { return ending_.get_token(); }

  /// nullptr while the file is not open; `why` says why.
  Store* store() { return store_.get(); }
  Error why() const;

 private:
  enum class Check { kWhole, kHeader };
  void work_due(SteadyTime now, WallTime wall);
  void try_open(WallTime wall);
  Result<std::unique_ptr<Store>> open_store() const;
  void close();
  void set_aside(WallTime wall);
  void write_waiting(WallTime wall);
  Result<void> write_in_order();
  void failed(const Error& error);
  void maintain(SteadyTime now, WallTime wall);
  void note(base::LogLevel level, std::string text) { report_.log.emplace_back(level, std::move(text)); }

  std::string path_;
  RetentionRules rules_;
  FreeSpace free_;
  std::stop_source ending_;
  std::unique_ptr<Store> store_;
  std::unique_ptr<Retention> retention_;
  std::vector<Declaration> slots_;  ///< what the source declared, for a new file
  std::deque<Batch> waiting_;
  Check check_ = Check::kWhole;  ///< of a file that is opened
  Report report_;
  std::string reason_;
  SteadyTime now_{}, try_again_{}, sync_{}, measure_{};
  Duration pause_{0};
  bool unsynced_ = false;
  std::uint64_t bytes_ = 0;
};

}  // namespace rubicon::history
