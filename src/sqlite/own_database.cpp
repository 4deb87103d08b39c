#include "sqlite/own_database.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <tuple>
#include <utility>

#include "base/clocks.h"
#include "base/own_file.h"

namespace rubicon::sqlite {

Result<FileLock> FileLock::take(const char* noun, const std::string& path) {
  const auto side = path + "-lock";
  // Reading is enough to lock, also a file that another user created.
  auto opened = OwnFile::open(side, O_RDONLY | O_NONBLOCK);
  if (!opened) {
    const auto code = opened.error().code == ErrorCode::kRefused ? ErrorCode::kRefused : ErrorCode::kIo;
    return fail(code, fmt::format("{} {}: its lock {}", noun, path, opened.error().text));
  }
  FileLock lock(std::move(*opened));
  if (::flock(lock.side_.get(), LOCK_EX | LOCK_NB) == 0) return lock;
  if (errno == EWOULDBLOCK) {
    return fail(ErrorCode::kBusy, fmt::format("{} {}: another process has it open for writing", noun, path));
  }
  return fail(ErrorCode::kIo, fmt::format("{} {}: locking {}: {}", noun, path, side, std::strerror(errno)));
}

namespace fs = std::filesystem;

namespace {

constexpr int kMinFile = 512;  // a page; SQLite accepts some shorter files as empty

/// Resolves symbolic links, so that SQLite's files are beside the file they belong to.
std::string real_path(const std::string& path) {
  std::error_code error;
  auto real = fs::weakly_canonical(fs::absolute(path, error), error);
  return error ? path : real.string();
}

/// The same, but refuses a link in place of the file, because the creator of the link could choose which file is
/// written.
Result<std::string> real_path_to_write(const char* noun, const std::string& path) {
  std::error_code error;
  const auto whole = fs::absolute(path, error);
  if (error) return path;
  auto real = (fs::weakly_canonical(whole.parent_path(), error) / whole.filename()).string();
  if (error) return path;
  if (fs::is_symlink(real, error))
    return fail(ErrorCode::kRefused, fmt::format("{} {}: is a symbolic link, expected the file itself", noun, path));
  return real;
}

Result<bool> exists(const char* noun, const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    if (errno == ENOENT) return false;
    return fail(ErrorCode::kIo, fmt::format("{} {}: {}", noun, path, std::strerror(errno)));
  }
  if (!S_ISREG(status.st_mode)) return fail(ErrorCode::kInvalid, fmt::format("{} {}: not a regular file", noun, path));
  if (status.st_size > 0 && status.st_size < kMinFile) {
    return fail(ErrorCode::kInvalid, fmt::format("{} {}: {} bytes are no SQLite database", noun, path, status.st_size));
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

/// If SQLite cannot create its files beside it, the file is read as it is, unless it has a log with later changes.
Result<Database> open_for_reading(const char* noun, const std::string& path) {
  auto database = Database::open(noun, path, Database::Mode::kRead);
  if (!database) return database;
  const auto probe = database->number("SELECT count(*) FROM sqlite_schema", "reading");
  if (probe || probe.error().code == ErrorCode::kInvalid || has_content(path + "-wal")) return database;
  return Database::open(noun, path, Database::Mode::kImmutable);
}

/// A tool may recover the file after a process that died, as SQLite does when it opens and closes files; it writes
/// nothing else.
Result<Database> open_beside(const char* noun, const std::string& path) {
  auto database = Database::open(noun, path, Database::Mode::kWrite);
  if (!database || !may_write(path)) return open_for_reading(noun, path);
  if (auto done = database->run("PRAGMA query_only=ON", "opening"); !done) return fail(done.error());
  const auto probe = database->number("SELECT count(*) FROM sqlite_schema", "reading");
  if (probe || probe.error().code == ErrorCode::kInvalid) return database;
  return open_for_reading(noun, path);
}

Result<void> open_own(const char* noun, OpenFile& file, bool present) {
  file.read_only = present && !may_write(file.path);
  if (!file.read_only) {
    auto lock = FileLock::take(noun, file.path);
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
      return fail(ErrorCode::kIo, fmt::format("{} {}", noun, made.error().text));
  }
  auto database =
      file.read_only ? open_for_reading(noun, file.path) : Database::open(noun, file.path, Database::Mode::kWrite);
  if (!database) return fail(database.error());
  file.database = std::move(*database);
  return {};
}

}  // namespace

void sync_folder_of(const std::string& path) {
  const auto folder = fs::path(path).parent_path();
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

Result<OpenFile> open_file(const char* noun, const std::string& path, FileUse use, bool create) {
  OpenFile file;
  if (use == FileUse::kOwn) {
    auto own = real_path_to_write(noun, path);
    if (!own) return fail(std::move(own.error()));
    file.path = std::move(*own);
  } else {
    file.path = real_path(path);
  }
  const auto present = exists(noun, file.path);
  if (!present) return fail(present.error());
  if (!*present && !create) return fail(ErrorCode::kNotFound, fmt::format("{} {}: does not exist", noun, file.path));
  if (use == FileUse::kOwn) {
    if (auto done = open_own(noun, file, *present); !done) return fail(done.error());
    return file;
  }
  file.read_only = true;
  auto database = open_beside(noun, file.path);
  if (!database) return fail(database.error());
  file.database = std::move(*database);
  return file;
}

Result<void> apply(Database& database, std::initializer_list<const char*> pragmas) {
  for (const auto* pragma : pragmas) {
    if (auto done = database.run(pragma, "opening"); !done) return done;
  }
  return {};
}

Result<void> tune_reader(Database& database) {
  return apply(database, {"PRAGMA mmap_size=0", "PRAGMA cell_size_check=ON", "PRAGMA temp_store=MEMORY",
                          "PRAGMA cache_size=-2048"});
}

Result<void> check_soundness(Database& database) {
  const auto verdict = database.word("PRAGMA quick_check(1)", "checking");
  if (!verdict) return fail(verdict.error());
  if (*verdict == "ok") return {};
  const auto first = verdict->substr(0, 200);
  return fail(ErrorCode::kInvalid, fmt::format("{} {}: damaged: {}", database.noun(), database.path(), first));
}

Result<std::string> set_aside(const char* noun, const std::string& path, WallTime now) {
  const auto real = real_path(path);
  auto lock = FileLock::take(noun, real);
  if (!lock) return fail(lock.error());
  const auto stem = fmt::format("{}.damaged-{}", real, base::utc_text(now, "%Y%m%dT%H%M%SZ"));
  auto target = stem;
  std::error_code error;
  for (int twin = 2; fs::exists(target, error) && twin < 1000; ++twin) target = fmt::format("{}-{}", stem, twin);
  fs::rename(real, target, error);
  if (error) {
    return fail(error == std::errc::no_such_file_or_directory ? ErrorCode::kNotFound : ErrorCode::kIo,
                fmt::format("{} {}: moving it to {}: {}", noun, real, target, error.message()));
  }
  // A log that remained would be applied to the next file.
  for (const auto* suffix : {"-wal", "-shm", "-journal"}) {
    fs::rename(real + suffix, target + suffix, error);
    if (error && error != std::errc::no_such_file_or_directory) {
      return fail(ErrorCode::kIo, fmt::format("{} {}: moving {}{}: {}", noun, real, real, suffix, error.message()));
    }
  }
  sync_folder_of(real);
  return target;
}

namespace {

/// Runs `work` and sets the version of the file, all or nothing.
Result<void> run_step(Database& database, const Format& format, const std::string& work, std::size_t version) {
  const auto sql = fmt::format("BEGIN IMMEDIATE;{};PRAGMA application_id={};PRAGMA user_version={};COMMIT", work,
                               format.application, version);
  auto done = database.run(sql.c_str(), "upgrading it");
  if (!done && database.in_transaction()) std::ignore = database.run("ROLLBACK", "rolling back");
  // Rows that the next version does not take are damage.
  if (!done && done.error().code == ErrorCode::kDuplicate) done.error().code = ErrorCode::kInvalid;
  return done;
}

}  // namespace

Result<Header> read_header(Database& database, const Format& format) {
  constexpr const char* kDoing = "reading its header";
  const auto application = database.number("PRAGMA application_id", kDoing);
  if (!application) return fail(application.error());
  const auto version = database.number("PRAGMA user_version", kDoing);
  if (!version) return fail(version.error());
  const auto tables = database.number("SELECT count(*) FROM sqlite_schema", kDoing);
  if (!tables) return fail(tables.error());
  if (*application == 0 && *version == 0 && *tables == 0) return Header{true, 0};
  const auto file = fmt::format("{} {}", database.noun(), database.path());
  if (*application != format.application) {
    return fail(ErrorCode::kRefused, fmt::format("{}: an SQLite database of another program", file));
  }
  const auto newest = static_cast<std::int64_t>(format.steps.size());
  if (*version > newest) {
    return fail(ErrorCode::kRefused, fmt::format("{}: made by a newer {} (version {}, this program knows versions up "
                                                 "to {})",
                                                 file, format.program, *version, newest));
  }
  if (*version < 1) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: has version {}, expected 1 or more", file, *version));
  }
  return Header{false, *version};
}

Result<void> make_tables(Database& database, const Format& format, std::string_view finally) {
  const auto work = fmt::format("{};{}", fmt::join(format.steps, ";"), finally);
  return run_step(database, format, work, format.steps.size());
}

Result<void> upgrade(Database& database, std::int64_t version, const Format& format) {
  for (auto next = static_cast<std::size_t>(version); next < format.steps.size(); ++next) {
    if (auto done = run_step(database, format, format.steps[next], next + 1); !done) return done;
  }
  return {};
}

}  // namespace rubicon::sqlite
