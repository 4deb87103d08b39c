#pragma once

#include <string>

#include "base/own_file.h"

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

}  // namespace rubicon::sqlite
