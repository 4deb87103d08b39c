#pragma once

#include <optional>
#include <string>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "state/file_lock.h"
#include "state/sqlite.h"

namespace rubicon::state {

/// An open state file whose header, form and island are right.
struct StateFile {
  std::string path;
  FileLock lock;  // goes last: nobody else may open for writing before SQLite has closed
  Database database;
  IslandId island = model::kNoOwner;
  bool read_only = false;
};

enum class FileUse {
  kOwn,   ///< write; without permission, read
  kRead,  ///< read beside somebody who may write
};

/// Errors as StateStore::open. Without an island any is right and the file must exist.
Result<StateFile> open_state_file(const std::string& path, FileUse use, std::optional<IslandId> island,
                                  std::uint64_t max_bytes);

/// Moves a damaged file and what SQLite keeps beside it to `<path>.damaged-<UTC time>`, which is the answer, so that
/// open() makes a new one. kBusy while another process has it open for writing.
Result<std::string> set_aside(const std::string& path, WallTime now);

}  // namespace rubicon::state
