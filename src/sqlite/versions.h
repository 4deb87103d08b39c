#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "rubicon/result.hpp"
#include "sqlite/database.h"

namespace rubicon::sqlite {

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
