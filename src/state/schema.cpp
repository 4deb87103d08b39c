#include "state/schema.h"

#include <fmt/format.h>

#include <tuple>

#include "model/former_types.h"

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

constexpr const char* kSteps[] = {kVersion1, kVersion2};

}  // namespace

std::span<const char* const> schema_steps() {
  return kSteps;
}

Result<Header> read_header(Database& database, std::span<const char* const> steps) {
  constexpr const char* kDoing = "reading its header";
  const auto application = database.number("PRAGMA application_id", kDoing);
  if (!application) return fail(application.error());
  const auto version = database.number("PRAGMA user_version", kDoing);
  if (!version) return fail(version.error());
  const auto tables = database.number("SELECT count(*) FROM sqlite_schema", kDoing);
  if (!tables) return fail(tables.error());
  const auto* file = sqlite3_db_filename(database.handle(), "main");
  if (*application == 0 && *version == 0 && *tables == 0) return Header{true, 0};
  if (*application != kApplicationId) {
    return fail(ErrorCode::kRefused, fmt::format("state file {}: an SQLite database of another program", file));
  }
  const auto newest = static_cast<std::int64_t>(steps.size());
  if (*version > newest) {
    return fail(ErrorCode::kRefused, fmt::format("state file {}: made by a newer rubicon-proxy (version {}, "
                                                 "this program knows versions up to {})",
                                                 file, *version, newest));
  }
  if (*version < 1) {
    return fail(ErrorCode::kInvalid, fmt::format("state file {}: has version {}, expected 1 or more", file, *version));
  }
  return Header{false, *version};
}

namespace {

/// Runs `work` and sets the version of the file, all or nothing.
Result<void> run_step(Database& database, const std::string& work, std::size_t version) {
  const auto sql = fmt::format("BEGIN IMMEDIATE;{};PRAGMA application_id={};PRAGMA user_version={};COMMIT", work,
                               kApplicationId, version);
  auto done = database.run(sql.c_str(), "upgrading it");
  if (!done && database.in_transaction()) std::ignore = database.run("ROLLBACK", "rolling back");
  return done;
}

}  // namespace

Result<void> make_tables(Database& database, std::string_view finally) {
  return run_step(database, fmt::format("{};{}", fmt::join(schema_steps(), ";"), finally), schema_steps().size());
}

Result<void> upgrade(Database& database, std::int64_t version, std::span<const char* const> steps) {
  for (auto next = static_cast<std::size_t>(version); next < steps.size(); ++next) {
    if (auto done = run_step(database, steps[next], next + 1); !done) return done;
  }
  return {};
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
              fmt::format("state file {}: island {}, expected 1 to {}", sqlite3_db_filename(database.handle(), "main"),
                          *island, model::kMaxIslandId));
}

std::string sql_of_island(IslandId island) {
  return fmt::format("INSERT INTO meta VALUES('island',{})", number(island));
}

}  // namespace rubicon::state
