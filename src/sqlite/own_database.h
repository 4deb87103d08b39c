#pragma once

#include <initializer_list>
#include <string>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "sqlite/database.h"
#include "sqlite/file_lock.h"

namespace rubicon::sqlite {

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

}  // namespace rubicon::sqlite
