#include "state/state_file.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "base/own_file.h"
#include "state/schema.h"

namespace rubicon::state {

namespace fs = std::filesystem;

namespace {

constexpr int kPageBytes = 4096;
constexpr int kMinFile = 512;  // a page; SQLite accepts some shorter files as empty

/// Resolves symbolic links, so that SQLite's files are beside the file they belong to.
std::string real_path(const std::string& path) {
  std::error_code error;
  auto real = fs::weakly_canonical(fs::absolute(path, error), error);
  return error ? path : real.string();
}

/// The same, but refuses a link in place of the file: whoever created it could choose which file is written.
Result<std::string> real_path_to_write(const std::string& path) {
  std::error_code error;
  const auto whole = fs::absolute(path, error);
  if (error) return path;
  auto real = (fs::weakly_canonical(whole.parent_path(), error) / whole.filename()).string();
  if (error) return path;
  if (fs::is_symlink(real, error))
    return fail(ErrorCode::kRefused, fmt::format("state file {}: is a symbolic link, expected the file itself", path));
  return real;
}

Result<bool> exists(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    if (errno == ENOENT) return false;
    return fail(ErrorCode::kIo, fmt::format("state file {}: {}", path, std::strerror(errno)));
  }
  if (!S_ISREG(status.st_mode))
    return fail(ErrorCode::kInvalid, fmt::format("state file {}: not a regular file", path));
  if (status.st_size > 0 && status.st_size < kMinFile) {
    return fail(ErrorCode::kInvalid,
                fmt::format("state file {}: {} bytes are no SQLite database", path, status.st_size));
  }
  return true;
}

/// SQLite also creates files beside it.
bool may_write(const std::string& path) {
  return ::access(path.c_str(), W_OK) == 0 && ::access(fs::path(path).parent_path().c_str(), W_OK | X_OK) == 0;
}

bool has_content(const std::string& path) {
  std::error_code error;
  const auto size = fs::file_size(path, error);
  return !error && size > 0;
}

void sync_folder_of(const std::string& path) {
  const auto folder = fs::path(path).parent_path();
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

Result<void> apply(Database& database, std::initializer_list<const char*> pragmas) {
  for (const auto* pragma : pragmas) {
    if (auto done = database.run(pragma, "opening"); !done) return done;
  }
  return {};
}

Result<void> tune_reader(Database& database) {
  return apply(database, {"PRAGMA mmap_size=0", "PRAGMA cell_size_check=ON", "PRAGMA temp_store=MEMORY",
                          "PRAGMA cache_size=-8192"});
}

/// A commit that lets the log grow beyond 4 MiB moves it into the file; StateStore::tidy does so earlier.
Result<void> tune_writer(Database& database, std::uint64_t max_bytes) {
  // EXTRA while a new file switches to the log: a rollback journal that reappears after a power failure would empty it.
  if (auto done = apply(database, {"PRAGMA synchronous=EXTRA"}); !done) return done;
  const auto mode = database.word("PRAGMA journal_mode=WAL", "opening");
  if (!mode) return fail(mode.error());
  // On file systems without support for the log each commit waits for the disk.
  const auto* synchronous = *mode == "wal" ? "PRAGMA synchronous=NORMAL" : "PRAGMA synchronous=FULL";
  const auto bound = fmt::format("PRAGMA max_page_count={}", std::max<std::uint64_t>(max_bytes / kPageBytes, 1));
  return apply(database, {synchronous, bound.c_str(), "PRAGMA wal_autocheckpoint=1000",
                          "PRAGMA journal_size_limit=4194304", "PRAGMA foreign_keys=ON",
                          // From now on only a foreign program can lock the file; the loop does not wait for it.
                          "PRAGMA busy_timeout=20"});
}

Result<void> check_soundness(Database& database) {
  const auto verdict = database.word("PRAGMA quick_check(1)", "checking");
  if (!verdict) return fail(verdict.error());
  if (*verdict == "ok") return {};
  const auto first = verdict->substr(0, 200);
  return fail(ErrorCode::kInvalid,
              fmt::format("state file {}: damaged: {}", sqlite3_db_filename(database.handle(), "main"), first));
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
  sync_folder_of(file.path);
  return {};
}

Result<void> verify(StateFile& file, std::optional<IslandId> island, std::uint64_t max_bytes) {
  auto& database = file.database;
  const auto header = read_header(database, schema_steps());
  if (!header) return fail(header.error());
  if (auto done = tune_reader(database); !done) return done;
  if (!header->fresh) {
    // Checked before anything is written.
    if (auto done = check_soundness(database); !done) return done;
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

/// If SQLite cannot create its files beside it, the file is read as it is, unless it has a log with later changes.
Result<Database> open_for_reading(const std::string& path) {
  auto database = Database::open(path, Database::Mode::kRead);
  if (!database) return database;
  const auto probe = database->number("SELECT count(*) FROM sqlite_schema", "reading");
  if (probe || probe.error().code == ErrorCode::kInvalid || has_content(path + "-wal")) return database;
  return Database::open(path, Database::Mode::kImmutable);
}

/// A tool may recover the file after a process that died, as SQLite does when it opens and closes files; it writes
/// nothing else.
Result<Database> open_beside(const std::string& path) {
  auto database = Database::open(path, Database::Mode::kWrite);
  if (!database || !may_write(path)) return open_for_reading(path);
  if (auto done = database->run("PRAGMA query_only=ON", "opening"); !done) return fail(done.error());
  const auto probe = database->number("SELECT count(*) FROM sqlite_schema", "reading");
  if (probe || probe.error().code == ErrorCode::kInvalid) return database;
  return open_for_reading(path);
}

Result<void> open_own(StateFile& file, bool present) {
  file.read_only = present && !may_write(file.path);
  if (!file.read_only) {
    auto lock = FileLock::take(file.path);
    if (lock) {
      file.lock = std::move(*lock);
    } else if (present && lock.error().code == ErrorCode::kRefused) {
      file.read_only = true;
    } else {
      const bool forbidden = lock.error().code == ErrorCode::kRefused;
      return fail(forbidden ? ErrorCode::kIo : lock.error().code, lock.error().text);
    }
  }
  // Earlier releases left the files readable for all, as SQLite creates them; its other files get the mode of this one.
  if (!file.read_only) {
    for (const auto* suffix : {"", "-wal", "-shm", "-journal"}) OwnFile::close_to_others(file.path + suffix);
  }
  if (!present) {
    if (auto made = OwnFile::open(file.path, O_WRONLY); !made)
      return fail(ErrorCode::kIo, fmt::format("state file {}", made.error().text));
  }
  auto database = file.read_only ? open_for_reading(file.path) : Database::open(file.path, Database::Mode::kWrite);
  if (!database) return fail(database.error());
  file.database = std::move(*database);
  return {};
}

}  // namespace

Result<StateFile> open_state_file(const std::string& path, FileUse use, std::optional<IslandId> island,
                                  std::uint64_t max_bytes) {
  StateFile file;
  if (use == FileUse::kOwn) {
    auto own = real_path_to_write(path);
    if (!own) return fail(std::move(own.error()));
    file.path = std::move(*own);
  } else {
    file.path = real_path(path);
  }
  const auto present = exists(file.path);
  if (!present) return fail(present.error());
  if (!*present && !island) return fail(ErrorCode::kNotFound, fmt::format("state file {}: does not exist", file.path));
  if (use == FileUse::kOwn) {
    if (auto done = open_own(file, *present); !done) return fail(done.error());
  } else {
    file.read_only = true;
    auto database = open_beside(file.path);
    if (!database) return fail(database.error());
    file.database = std::move(*database);
  }
  if (auto done = verify(file, island, max_bytes); !done) return fail(done.error());
  return file;
}

Result<std::string> set_aside(const std::string& path, WallTime now) {
  const auto real = real_path(path);
  auto lock = FileLock::take(real);
  if (!lock) return fail(lock.error());
  const auto seconds = std::chrono::floor<std::chrono::seconds>(now);
  const auto base = fmt::format("{}.damaged-{:%Y%m%dT%H%M%SZ}", real, fmt::gmtime(seconds));
  auto target = base;
  std::error_code error;
  for (int twin = 2; fs::exists(target, error) && twin < 1000; ++twin) target = fmt::format("{}-{}", base, twin);
  fs::rename(real, target, error);
  if (error) {
    return fail(error == std::errc::no_such_file_or_directory ? ErrorCode::kNotFound : ErrorCode::kIo,
                fmt::format("state file {}: moving it to {}: {}", real, target, error.message()));
  }
  // A log that remained would be applied to the next file.
  for (const auto* suffix : {"-wal", "-shm", "-journal"}) {
    fs::rename(real + suffix, target + suffix, error);
    if (error && error != std::errc::no_such_file_or_directory) {
      return fail(ErrorCode::kIo, fmt::format("state file {}: moving {}{}: {}", real, real, suffix, error.message()));
    }
  }
  sync_folder_of(real);
  return target;
}

}  // namespace rubicon::state
