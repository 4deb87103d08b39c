#include "history/store.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "model/json_members.h"
#include "model/json_text.h"
#include "sqlite/database.h"
#include "sqlite/own_database.h"

namespace rubicon::history {

namespace {

using sqlite::Database;

constexpr std::array<const char*, 2> kSteps{R"sql(
CREATE TABLE meta(name TEXT PRIMARY KEY, value INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE series(id INTEGER PRIMARY KEY, owner INTEGER NOT NULL, key TEXT NOT NULL, kind INTEGER NOT NULL,
  unit TEXT NOT NULL, words TEXT NOT NULL, UNIQUE(owner,key));
CREATE TABLE journal(id INTEGER PRIMARY KEY, time INTEGER NOT NULL, data BLOB NOT NULL);
CREATE TABLE block(series INTEGER NOT NULL, start INTEGER NOT NULL, part INTEGER NOT NULL, until INTEGER NOT NULL,
  count INTEGER NOT NULL, gaps INTEGER NOT NULL, minimum REAL, maximum REAL, sum REAL, last REAL, data BLOB NOT NULL,
  PRIMARY KEY(series,start,part)) WITHOUT ROWID;
CREATE TABLE hour(series INTEGER NOT NULL, start INTEGER NOT NULL, until INTEGER NOT NULL, count INTEGER NOT NULL,
  minimum REAL, maximum REAL, sum REAL, last REAL, PRIMARY KEY(series,start)) WITHOUT ROWID;
CREATE TABLE text(series INTEGER NOT NULL, time INTEGER NOT NULL, value TEXT NOT NULL,
  PRIMARY KEY(series,time)) WITHOUT ROWID;
)sql",
                                            R"sql(
ALTER TABLE block ADD COLUMN first REAL;
ALTER TABLE block ADD COLUMN area REAL;
ALTER TABLE block ADD COLUMN held INTEGER;
ALTER TABLE hour ADD COLUMN first REAL;
ALTER TABLE hour ADD COLUMN area REAL;
ALTER TABLE hour ADD COLUMN held INTEGER;
)sql"};

sqlite::Format format() {
  return {kApplicationId, "rubicon", kSteps};
}

Result<void> tune_writer(Database& database) {
  // EXTRA while a new file switches to the log: a rollback journal that reappears after a power failure would empty it.
  if (auto done = sqlite::apply(database, {"PRAGMA synchronous=EXTRA"}); !done) return done;
  const auto mode = database.word("PRAGMA journal_mode=WAL", "opening");
  if (!mode) return fail(mode.error());
  // On file systems without support for the log each commit waits for the disk.
  const auto* synchronous = *mode == "wal" ? "PRAGMA synchronous=NORMAL" : "PRAGMA synchronous=FULL";
  return sqlite::apply(database, {synchronous, "PRAGMA wal_autocheckpoint=512", "PRAGMA journal_size_limit=8388608"});
}

Result<void> create(sqlite::OpenFile& file) {
  if (file.read_only) return fail(ErrorCode::kInvalid, fmt::format("{} {}: empty", file.database.noun(), file.path));
  if (auto done = sqlite::apply(file.database, {"PRAGMA page_size=8192"}); !done) return done;
  if (auto done = tune_writer(file.database); !done) return done;
  if (auto done = sqlite::make_tables(file.database, format(), ""); !done) return done;
  // Moves the tables from the log into the file: after a power failure SQLite would drop the log of an empty file.
  if (auto done = file.database.run("PRAGMA wal_checkpoint(FULL)", "creating it"); !done) return done;
  sqlite::sync_folder_of(file.path);
  return {};
}

/// The file has content that no database begins with (https://www.sqlite.org/fileformat.html, 1.3): a wrong name in a
/// configuration, perhaps.
bool is_no_database(const std::string& path) {
  constexpr std::string_view kBegin("SQLite format 3\0", 16);
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  std::ifstream file(path, std::ios::binary);
  std::array<char, kBegin.size()> begin{};
  file.read(begin.data(), begin.size());
  const std::string_view found(begin.data(), static_cast<std::size_t>(file.gcount()));
  return !found.empty() && found != kBegin;
}

Result<void> verify(sqlite::OpenFile& file, bool thorough, const std::stop_token& stop) {
  const auto header = sqlite::read_header(file.database, format());
  if (!header) return fail(header.error());
  if (auto done = sqlite::tune_reader(file.database); !done) return done;
  if (header->fresh) return create(file);
  if (thorough) {
    const sqlite::Interruption interruption(file.database, {}, stop, sqlite::Interruption::kCheckSteps);
    if (auto done = sqlite::check_soundness(file.database); !done) return done;
  }
  if (file.read_only) return {};
  if (auto done = tune_writer(file.database); !done) return done;
  return sqlite::upgrade(file.database, header->version, format());
}

}  // namespace

Result<sqlite::OpenFile> open_history_file(const std::string& path, sqlite::FileUse use, bool thorough, bool create,
                                           const std::stop_token& stop) {
  if (is_no_database(path))
    return fail(ErrorCode::kRefused, fmt::format("{} {}: is not an SQLite database", kNoun, path));
  auto file = sqlite::open_file(kNoun, path, use, create && use == sqlite::FileUse::kOwn);
  if (!file) return file;
  if (auto done = verify(*file, thorough, stop); !done) return fail(done.error());
  return file;
}

using sqlite::Query;
using sqlite::Statement;

Result<void> prepare_statements(sqlite::Database& database, StoreStatements& statements, bool has_areas) {
  struct Text {
    Statement StoreStatements::*statement;
    const char *sql, *doing;
  };
  constexpr const char* kBlocks = "writing a block";
  for (const auto& text : {
           Text{&StoreStatements::insert_series, "INSERT INTO series(owner,key,kind,unit,words) VALUES(?,?,?,?,?)",
                "writing a series"},
           Text{&StoreStatements::update_series, "UPDATE series SET kind=?,unit=?,words=? WHERE id=?",
                "writing a series"},
           Text{&StoreStatements::insert_journal, "INSERT INTO journal VALUES(?,?,?)", "writing its journal"},
           Text{&StoreStatements::trim_journal, "DELETE FROM journal WHERE id<?", "shortening its journal"},
           Text{&StoreStatements::last_block,
                "SELECT start,part,until,count,gaps,data FROM block WHERE series=? ORDER BY start DESC,part DESC LIMIT "
                "1",
                kBlocks},
           Text{&StoreStatements::next_part, "SELECT coalesce(max(part)+1,0) FROM block WHERE series=? AND start=?",
                kBlocks},
           Text{&StoreStatements::insert_block,
                has_areas ? "INSERT INTO block VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?)"
                          : "INSERT INTO block VALUES(?,?,?,?,?,?,?,?,?,?,?)",
                kBlocks},
           Text{&StoreStatements::delete_block, "DELETE FROM block WHERE series=? AND start=? AND part=?", kBlocks},
           Text{&StoreStatements::insert_text, "INSERT OR REPLACE INTO text VALUES(?,?,?)", "writing a text"},
           Text{&StoreStatements::put_meta, "INSERT OR REPLACE INTO meta VALUES(?,?)", "writing its times"},
       }) {
    auto prepared = database.prepare(text.sql, text.doing);
    if (!prepared) return fail(prepared.error());
    statements.*text.statement = std::move(*prepared);
  }
  return {};
}

Result<std::optional<std::int64_t>> Store::meta(const char* name) {
  auto statement = file_.database.prepare("SELECT value FROM meta WHERE name=?", "reading its times");
  if (!statement) return fail(statement.error());
  Query query(*statement);
  const auto there = query.text(name).next();
  if (!there) return fail(there.error());
  return *there ? std::optional(query.integer_at(0)) : std::nullopt;
}

Result<void> Store::put_meta(const char* name, std::int64_t value) {
  return Query(sql_.put_meta).text(name).integer(value).run();
}

Result<bool> Store::remove_if_empty(SeriesRow row) {
  if (!series_.at(row).open.empty()) return false;
  // The row with the highest id stays: SQLite would give the id to the next series, and the journal may still name it.
  auto remove = file_.database.prepare(
      "DELETE FROM series WHERE id=?1 AND id<(SELECT max(id) FROM series) AND NOT EXISTS(SELECT 1 FROM block WHERE "
      "series=?1) AND NOT EXISTS(SELECT 1 FROM hour WHERE series=?1) AND NOT EXISTS(SELECT 1 FROM text WHERE "
      "series=?1)",
      "removing a series");
  if (!remove) return fail(remove.error());
  Query query(*remove);
  if (auto done = query.integer(row).run(); !done) return fail(done.error());
  return query.changes() > 0;
}

void Store::forget(SeriesRow row) {
  const auto known = series_.find(row);
  if (known == series_.end()) return;
  names_.erase(known->second.declaration.name);
  series_.erase(known);
  for (auto& slot : slots_) {
    if (slot.row == row) slot.row = 0;
  }
}

std::string words_to_text(const std::vector<std::string>& words) {
  return model::dump(nlohmann::json(words));
}

std::vector<std::string> words_from_text(std::string_view text) {
  const auto tree = model::parse_json(text);
  std::vector<std::string> words;
  if (!tree.is_array()) return words;
  for (const auto& word : tree) {
    if (!word.is_string()) return {};
    words.push_back(word.get<std::string>());
  }
  return words;
}

}  // namespace rubicon::history
