#pragma once

#include <string>

#include "base/own_file.h"

namespace rubicon::state {

/// The right to write a state file: an advisory lock on `<path>-lock` beside it, which ends with the process. SQLite's
/// own locks stay free, so that readers come in while an island runs. The side file stays behind; it is empty.
class FileLock {
 public:
  FileLock() = default;  ///< holds nothing

  /// kBusy: somebody else has it (also in this process); kRefused: no side file may be made there; kIo: anything else,
  /// also a side file that is a symbolic link: an island that took it for a folder it may only read would forget.
  static Result<FileLock> take(const std::string& path);

 private:
  explicit FileLock(OwnFile side) : side_(std::move(side)) {}

  OwnFile side_;
};

}  // namespace rubicon::state
