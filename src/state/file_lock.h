#pragma once

#include <string>

#include "base/result.h"

namespace rubicon::state {

/// The right to write a state file: an advisory lock on `<path>-lock` beside it, which ends with the process. SQLite's
/// own locks stay free, so that readers come in while an island runs. The side file stays behind; it is empty.
class FileLock {
 public:
  FileLock() = default;  ///< holds nothing
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&& other) noexcept;
  ~FileLock();

  /// kBusy: somebody else has it (also in this process); kRefused: no side file may be made there; kIo: anything else.
  static Result<FileLock> take(const std::string& path);

 private:
  explicit FileLock(int descriptor) : descriptor_(descriptor) {}

  int descriptor_ = -1;
};

}  // namespace rubicon::state
