#pragma once

#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

#include "base/own_file.h"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "sqlite/database.h"

namespace rubicon::sqlite {

/// The right to write a file of SQLite: an advisory lock on `<path>-lock` beside it, which ends with the process.
/// SQLite's own locks are not used, so that others can read while a program writes. The empty lock file remains.
class FileLock {
 public:
  FileLock() = default;  ///< holds nothing

  /// kBusy: it is locked, by another process or by this one; kRefused: no permission to create the lock file; kIo:
  /// everything else, also a lock file that is a symbolic link, so that it does not pass for a missing permission.
  /// Error texts call the file `noun`.
  static Result<FileLock> take(const char* noun, const std::string& path);

 private:
  explicit FileLock(OwnFile side) : side_(std::move(side)) {}

  OwnFile side_;
};

// What all programs do with files of SQLite that are theirs: private, locked by their writer, never through a symbolic
// link. `noun` says in error texts what kind of file it is.

enum class FileUse {
  kOwn,   ///< writes; only reads without permission to write
  kRead,  ///< reads, while another process may write
};

struct OpenFile {
  std::string path;  ///< without symbolic links
  FileLock lock;     // destroyed last, after SQLite has closed the file
  Database database;
  bool read_only = false;
};

/// Opens or creates the file, and checks nothing in it. kNotFound: it does not exist, and `create` is false; kInvalid:
/// no database; kRefused: a symbolic link; kBusy: another process has it open for writing; kIo: it cannot be read or
/// created.
Result<OpenFile> open_file(const char* noun, const std::string& path, FileUse use, bool create);

Result<void> apply(Database& database, std::initializer_list<const char*> pragmas);
/// Settings for reading a file that may be damaged.
Result<void> tune_reader(Database& database);
/// kInvalid: damaged. Reads the whole file.
Result<void> check_soundness(Database& database);

/// Puts the name of a new file on the disk.
void sync_folder_of(const std::string& path);
/// Renames a damaged file and SQLite's files beside it to `<path>.damaged-<UTC time>`, which is returned, so that
/// open_file() creates a new one. kBusy while another process has it open for writing.
Result<std::string> set_aside(const char* noun, const std::string& path, WallTime now);

/// What a program writes into files of one kind.
struct Format {
  std::int64_t application = 0;        ///< in the header of each (SQLite's application_id)
  const char* program = "";            ///< that makes them, for error texts
  std::span<const char* const> steps;  ///< the SQL at index N brings a file of version N to version N + 1
};

/// The header of a file.
struct Header {
  bool fresh = false;  ///< the file is empty
  std::int64_t version = 0;
};

/// kRefused: the file is of another program, or of a newer version than the last step; kInvalid: its version never was.
Result<Header> read_header(Database& database, const Format& format);

/// Makes the tables of the newest version in an empty file, then runs the SQL `finally`, all in one transaction: a
/// process that dies meanwhile leaves an empty file.
Result<void> make_tables(Database& database, const Format& format, std::string_view finally);
/// Applies the missing steps, each in one transaction: a process that dies meanwhile leaves a file of some version.
Result<void> upgrade(Database& database, std::int64_t version, const Format& format);

}  // namespace rubicon::sqlite
