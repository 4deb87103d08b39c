#pragma once

#include <optional>
#include <string>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "sqlite/own_database.h"

namespace rubicon::state {

/// An open state file whose header, tables and island were checked.
struct StateFile : sqlite::OpenFile {
  IslandId island = model::kNoOwner;
};

using sqlite::FileUse;

/// Errors as those of StateStore::open. Without `island` the file must exist and may be of any island.
Result<StateFile> open_state_file(const std::string& path, FileUse use, std::optional<IslandId> island,
                                  std::uint64_t max_bytes);

/// Renames a damaged file and SQLite's files beside it to `<path>.damaged-<UTC time>`, which is returned, so that
/// open() creates a new one. kBusy while another process has it open for writing.
Result<std::string> set_aside(const std::string& path, WallTime now);

}  // namespace rubicon::state
