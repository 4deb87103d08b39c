#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "history/blocks.h"
#include "history/series.h"
#include "rubicon/key.hpp"
#include "sqlite/own_database.h"

namespace rubicon::history {

/// Row of a series in the file.
using SeriesRow = std::int64_t;

/// The statements that a store uses again and again.
struct StoreStatements {
  sqlite::Statement insert_series, update_series, insert_journal, trim_journal, last_block, next_part, insert_block,
      delete_block, insert_text, put_meta;
};

/// The file of a history, for one thread: writes batches, and keeps the points that are not in blocks yet. A process
/// that dies at any instant leaves the file as it was after one of the batches; after a power failure the last seconds
/// may be missing.
class Store {
 public:
  /// Errors of open_history_file(); kRefused also: a table is missing or has other columns. A writer marks a gap in
  /// each series that was observed when the one before it ended. A reader sees the file as it is now, as long as it has
  /// it open.
  static Result<std::unique_ptr<Store>> open(const std::string& path, sqlite::FileUse use, bool thorough,
                                             bool create = true, const std::stop_token& stop = {});

  struct Series {
    Declaration declaration;
    OpenPoints open;
    std::int64_t first_journal = 0;  ///< row with the first open point
    std::size_t next_limit = kBlockPoints;
  };

  /// All or nothing; after a failure the batch may be written again. Slots are those of one source at a time.
  /// kOutOfRange: it never can be written.
  Result<void> write(const Batch& batch);
  /// Closes all open points into blocks: for a file that its writer leaves for long.
  Result<void> close_all();
  /// Forgets what slots mean: another source begins.
  void forget_slots() { slots_.clear(); }
  /// Removes the row of a series that has neither blocks nor summaries nor texts, unless it has open points; to be
  /// called in a transaction. True: it went; call forget() once that is in the file. A slot may still name the series:
  /// its next point brings the series back.
  Result<bool> remove_if_empty(SeriesRow row);
  void forget(SeriesRow row);
  /// Everything written is on the disk when this returns.
  Result<void> sync();

  const std::map<SeriesRow, Series>& series() const { return series_; }
  std::optional<SeriesRow> find(const SeriesName& name) const;
  /// Until when the file was written: milliseconds since 1970; 0 = never.
  std::int64_t alive() const { return alive_; }
  sqlite::Database& database() { return file_.database; }
  BlockCodec& codec() { return codec_; }
  const std::string& path() const { return file_.path; }
  bool read_only() const { return file_.read_only; }
  /// Blocks and hours say how long each value was in force: not in a file of an earlier release that is only read.
  bool has_areas() const { return has_areas_; }
  std::uint64_t damaged() const { return damaged_; }  ///< rows that could not be read
  void count_damage() { ++damaged_; }

  /// A number that stays with the file.
  Result<std::optional<std::int64_t>> meta(const char* name);
  Result<void> put_meta(const char* name, std::int64_t value);
  /// Does `work` in a transaction. kBusy: there is not enough memory.
  Result<void> transact(const std::function<Result<void>()>& work);

 private:
  explicit Store(sqlite::OpenFile file) : file_(std::move(file)) {}
  struct Writing;

  Result<void> prepare();
  Result<void> load_series();
  Result<void> replay_journal();
  void replay(std::int64_t row, ByteView data);
  void mark_gaps();

  Result<void> write_rows(const Batch& batch, Writing& writing);
  Result<SeriesRow> put_series(const Declaration& declaration, Writing& writing);
  void plan(Writing& writing, std::int64_t now);
  void plan_aged(Writing& writing, std::int64_t now);
  Result<void> write_block(SeriesRow row, Points points);
  Result<void> insert_block(SeriesRow row, const Points& points);
  Result<bool> join_last(SeriesRow row, Points& points);
  Result<void> write_journal(Writing& writing, WallTime time);
  Result<void> insert_journal(std::int64_t row, WallTime time, ByteView plain);
  Result<void> trim_journal();
  void apply(Writing& writing, std::int64_t now);

  sqlite::OpenFile file_;
  BlockCodec codec_;
  StoreStatements sql_;
  std::map<SeriesRow, Series> series_;
  std::map<SeriesName, SeriesRow> names_;
  struct SlotState {
    Declaration declaration;
    SeriesRow row = 0;  ///< 0 = not in the file yet
  };
  std::vector<SlotState> slots_;
  std::vector<std::pair<SeriesRow, Point>> marks_;  ///< of gaps, for the next batch
  std::int64_t alive_ = 0;
  bool has_areas_ = false;
  std::int64_t next_journal_ = 1;
  SeriesRow next_aged_ = 0;  ///< where the search for old open points continues
  unsigned writes_ = 0;
  std::uint64_t damaged_ = 0;
};

/// The words of a series in its row, and back.
std::string words_to_text(const std::vector<std::string>& words);
std::vector<std::string> words_from_text(std::string_view text);

Result<void> prepare_statements(sqlite::Database& database, StoreStatements& statements, bool has_areas);

/// In error texts.
inline constexpr const char* kNoun = "history";
/// In the header of every file (SQLite's application_id): `RbnH`.
inline constexpr std::int64_t kApplicationId = 0x52626e48;
/// From this version on blocks and hours have the columns `first`, `area` and `held`.
inline constexpr std::int64_t kAreasSince = 2;

/// Opens a file whose header and tables were checked; the whole file if `thorough`. kOwn creates it if `create`. Errors
/// as those of sqlite::open_file; kInvalid: a damaged database; kRefused: no database, one of another program, or of a
/// newer version; kExpired: `stop` ended it. What is refused is left as it is.
Result<sqlite::OpenFile> open_history_file(const std::string& path, sqlite::FileUse use, bool thorough, bool create,
                                           const std::stop_token& stop = {});

}  // namespace rubicon::history
