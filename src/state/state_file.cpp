#include "state/state_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "state/schema.h"

namespace rubicon::state {

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
