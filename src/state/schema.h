#pragma once

#include <span>
#include <string>
#include <string_view>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "sqlite/database.h"
#include "sqlite/versions.h"

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
/// Replaces former names and numbers of types (model/former_types.h); writes nothing if there are none.
Result<void> rename_types(Database& database);
/// The SQL that stores the island of a new file.
std::string sql_of_island(IslandId island);

/// The island a file belongs to; kInvalid if it names none.
Result<IslandId> read_island(Database& database);

}  // namespace rubicon::state
