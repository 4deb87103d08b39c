#pragma once

#include <span>
#include <string>
#include <string_view>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "state/sqlite.h"

namespace rubicon::state {

/// Stands in the header of every state file (SQLite's application_id): `RbnS`.
inline constexpr std::int64_t kApplicationId = 0x52626e53;

/// SQL that brings a file of version N, the index in the table, to version N + 1. Steps are added, never changed.
std::span<const char* const> schema_steps();

/// What the header of a file says.
struct Header {
  bool fresh = false;  ///< nothing in it yet
  std::int64_t version = 0;
};

/// kInvalid: another program's file; kRefused: of a newer version than `steps` make.
Result<Header> read_header(Database& database, std::span<const char* const> steps);

/// Makes an empty file one of the newest version, `finally` (SQL) included, in one transaction: a process that dies
/// before its end leaves an empty file.
Result<void> make_tables(Database& database, std::string_view finally);
/// Applies the steps the file lacks, each as one transaction: a process that dies between two of them leaves a file of
/// a whole version.
Result<void> bring_up(Database& database, std::int64_t version, std::span<const char* const> steps);
/// Values under former names and numbers of types get those of today; nothing is written where there are none.
Result<void> rename_types(Database& database);
/// The last step of making a file: whose it is.
std::string sql_of_island(IslandId island);

/// The island a file belongs to; kInvalid when it says none.
Result<IslandId> read_island(Database& database);

}  // namespace rubicon::state
