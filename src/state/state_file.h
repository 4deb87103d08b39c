#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "sqlite/database.h"
#include "sqlite/own_database.h"

namespace rubicon::state {

using sqlite::Database;
using sqlite::Query;
using sqlite::Statement;

/// In the header of every state file (SQLite's application_id): `RbnS`.
inline constexpr std::int64_t kApplicationId = 0x52626e53;

/// The SQL at index N brings a file of version N to version N + 1. Steps are added, never changed.
std::span<const char* const> schema_steps();

using sqlite::Header;

/// kRefused: the file is of another program, or of a newer version than the last step; kInvalid: its version never was.
Result<Header> read_header(Database& database, std::span<const char* const> steps);

/// Makes the tables of the newest version in an empty file, then runs the SQL `finally`, all in one transaction: a
/// process that dies meanwhile leaves an empty file.
Result<void> make_tables(Database& database, std::string_view finally);
/// Applies the missing steps, each in one transaction: a process that dies meanwhile leaves a file of some version.
Result<void> upgrade(Database& database, std::int64_t version, std::span<const char* const> steps);
/// Replaces former names and numbers of types (model/type_names.h); writes nothing if there are none.
Result<void> rename_types(Database& database);
/// The SQL that stores the island of a new file.
std::string sql_of_island(IslandId island);

/// The island a file belongs to; kInvalid if it names none.
Result<IslandId> read_island(Database& database);

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
