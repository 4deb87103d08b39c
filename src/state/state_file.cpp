#include "state/state_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "model/type_names.h"

namespace rubicon::state {

namespace {

/// `device` is small, because it is written with every batch of values; what changes only with a new announcement
/// has a table of its own. Rows are never used twice (AUTOINCREMENT), so that the row of a forgotten device never names
/// another one. Times are microseconds since 1970. `value.form` is the alternative of model::Value.
constexpr const char* kVersion1 = R"sql(
CREATE TABLE meta(name TEXT PRIMARY KEY, value ANY) STRICT, WITHOUT ROWID;
CREATE TABLE device(
  row INTEGER PRIMARY KEY AUTOINCREMENT,
  network TEXT NOT NULL,
  address TEXT NOT NULL,
  id TEXT NOT NULL,
  decision INTEGER NOT NULL,
  name TEXT NOT NULL,
  wanted_id TEXT NOT NULL,
  first_seen INTEGER NOT NULL,
  last_heard INTEGER NOT NULL,
  UNIQUE(network, address)) STRICT;
CREATE TABLE announcement(
  device INTEGER PRIMARY KEY REFERENCES device(row) ON DELETE CASCADE,
  capabilities BLOB NOT NULL,
  point_ids BLOB NOT NULL) STRICT;
CREATE TABLE value(
  device INTEGER NOT NULL REFERENCES device(row) ON DELETE CASCADE,
  kind INTEGER NOT NULL,
  type INTEGER NOT NULL,
  instance TEXT NOT NULL,
  form INTEGER NOT NULL,
  value ANY,
  heard INTEGER NOT NULL,
  changed INTEGER NOT NULL,
  user_time INTEGER NOT NULL,
  set_by_user INTEGER NOT NULL,
  PRIMARY KEY(device, kind, type, instance)) STRICT, WITHOUT ROWID;
)sql";

/// Names and areas given by users.
constexpr const char* kVersion2 = R"sql(
ALTER TABLE device ADD COLUMN given_name TEXT NOT NULL DEFAULT '';
ALTER TABLE device ADD COLUMN area TEXT NOT NULL DEFAULT '';
)sql";

/// What networks remember.
constexpr const char* kVersion3 = R"sql(
CREATE TABLE memory(
  network TEXT NOT NULL,
  name TEXT NOT NULL,
  value BLOB NOT NULL,
  PRIMARY KEY(network, name)) STRICT, WITHOUT ROWID;
)sql";

constexpr const char* kSteps[] = {kVersion1, kVersion2, kVersion3};

sqlite::Format format_of(std::span<const char* const> steps) {
  return {kApplicationId, "rubicon-proxy", steps};
}

}  // namespace

std::span<const char* const> schema_steps() {
  return kSteps;
}

Result<Header> read_header(Database& database, std::span<const char* const> steps) {
  return sqlite::read_header(database, format_of(steps));
}

Result<void> make_tables(Database& database, std::string_view finally) {
  return sqlite::make_tables(database, format_of(schema_steps()), finally);
}

Result<void> upgrade(Database& database, std::int64_t version, std::span<const char* const> steps) {
  return sqlite::upgrade(database, version, format_of(steps));
}

Result<void> rename_types(Database& database) {
  constexpr const char* kDoing = "replacing former types";
  std::string sql;
  for (const auto& former : model::former_types()) {
    const auto id = static_cast<unsigned>(former.id), now = static_cast<unsigned>(former.now);
    const auto properties = fmt::format("kind={} AND substr(instance,1,{})='{}-'", static_cast<int>(Kind::kProperty),
                                        former.name.size() + 1, former.name);
    const auto there = database.number(
        fmt::format("SELECT EXISTS(SELECT 1 FROM value WHERE type={} OR ({}))", id, properties).c_str(), kDoing);
    if (!there) return fail(there.error());
    if (*there == 0) continue;
    // A value that exists under both names is the latest under the newer one.
    sql +=
        fmt::format("UPDATE OR IGNORE value SET type={} WHERE type={};DELETE FROM value WHERE type={};", now, id, id);
    sql += fmt::format(
        "UPDATE OR IGNORE value SET instance='{}'||substr(instance,{}) WHERE {};DELETE FROM value WHERE {};",
        former.called, former.name.size() + 1, properties, properties);
  }
  if (sql.empty()) return {};
  auto done = database.run(("BEGIN IMMEDIATE;" + sql + "COMMIT").c_str(), kDoing);
  if (!done && database.in_transaction()) std::ignore = database.run("ROLLBACK", "rolling back");
  return done;
}

Result<IslandId> read_island(Database& database) {
  const auto island = database.number("SELECT value FROM meta WHERE name='island'", "reading which island it is of");
  if (!island) return fail(island.error());
  if (*island >= 1 && *island <= model::kMaxIslandId) return IslandId(static_cast<std::uint32_t>(*island));
  return fail(ErrorCode::kInvalid,
              fmt::format("state file {}: island {}, expected 1 to {}", database.path(), *island, model::kMaxIslandId));
}

std::string sql_of_island(IslandId island) {
  return fmt::format("INSERT INTO meta VALUES('island',{})", number(island));
}

namespace {

constexpr const char* kNoun = "state file";
constexpr int kPageBytes = 4096;

/// A commit that lets the log grow beyond 4 MiB moves it into the file; StateStore::tidy does so earlier.
Result<void> tune_writer(Database& database, std::uint64_t max_bytes) {
  // EXTRA while a new file switches to the log: a rollback journal that reappears after a power failure would empty it.
  if (auto done = sqlite::apply(database, {"PRAGMA synchronous=EXTRA"}); !done) return done;
  const auto mode = database.word("PRAGMA journal_mode=WAL", "opening");
  if (!mode) return fail(mode.error());
  // On file systems without support for the log each commit waits for the disk.
  const auto* synchronous = *mode == "wal" ? "PRAGMA synchronous=NORMAL" : "PRAGMA synchronous=FULL";
  const auto bound = fmt::format("PRAGMA max_page_count={}", std::max<std::uint64_t>(max_bytes / kPageBytes, 1));
  return sqlite::apply(
      database, {synchronous, bound.c_str(), "PRAGMA wal_autocheckpoint=1000", "PRAGMA journal_size_limit=4194304",
                 "PRAGMA foreign_keys=ON",
                 // From now on only a foreign program can lock the file; the loop does not wait for it.
                 "PRAGMA busy_timeout=20"});
}

Result<void> check_island(StateFile& file, std::optional<IslandId> wanted) {
  const auto island = read_island(file.database);
  if (!island) return fail(island.error());
  file.island = *island;
  if (!wanted || *wanted == *island) return {};
  return fail(ErrorCode::kRefused, fmt::format("state file {}: of island {}, expected island {}", file.path,
                                               number(*island), number(*wanted)));
}

Result<void> initialise(StateFile& file, std::optional<IslandId> island) {
  if (!island || file.read_only) {
    return fail(ErrorCode::kInvalid, fmt::format("state file {}: empty", file.path));
  }
  if (auto done = make_tables(file.database, sql_of_island(*island)); !done) return done;
  file.island = *island;
  // Moves the tables from the log into the file: after a power failure SQLite would drop the log of an empty file.
  if (auto done = file.database.run("PRAGMA wal_checkpoint(FULL)", "creating it"); !done) return done;
  sqlite::sync_folder_of(file.path);
  return {};
}

Result<void> verify(StateFile& file, std::optional<IslandId> island, std::uint64_t max_bytes) {
  auto& database = file.database;
  const auto header = read_header(database, schema_steps());
  if (!header) return fail(header.error());
  if (auto done = sqlite::tune_reader(database); !done) return done;
  if (!header->fresh) {
    // Checked before anything is written.
    if (auto done = sqlite::check_soundness(database); !done) return done;
    if (auto done = check_island(file, island); !done) return done;
  }
  if (!file.read_only) {
    if (auto done = tune_writer(database, max_bytes); !done) return done;
  }
  if (header->fresh) return initialise(file, island);
  const auto newest = static_cast<std::int64_t>(schema_steps().size());
  if (!file.read_only) {
    if (auto done = upgrade(database, header->version, schema_steps()); !done) return done;
    return rename_types(database);
  }
  if (header->version == newest) return {};
  return fail(ErrorCode::kRefused,
              fmt::format("state file {}: of an older version, and there is no permission to upgrade it", file.path));
}

}  // namespace

Result<StateFile> open_state_file(const std::string& path, FileUse use, std::optional<IslandId> island,
                                  std::uint64_t max_bytes) {
  auto opened = sqlite::open_file(kNoun, path, use, island.has_value());
  if (!opened) return fail(std::move(opened.error()));
  StateFile file{std::move(*opened)};
  if (auto done = verify(file, island, max_bytes); !done) return fail(done.error());
  return file;
}

Result<std::string> set_aside(const std::string& path, WallTime now) {
  return sqlite::set_aside(kNoun, path, now);
}

}  // namespace rubicon::state
