#pragma once

#include <stop_token>
#include <string>

#include "sqlite/own_database.h"

namespace rubicon::history {

/// In error texts.
inline constexpr const char* kNoun = "history";
/// In the header of every file (SQLite's application_id): `RbnH`.
inline constexpr std::int64_t kApplicationId = 0x52626e48;
/// From this version on blocks and hours have the columns `first`, `area` and `held`.
inline constexpr std::int64_t kAreasSince = 2;

/// Opens a file whose header and tables were checked; the whole file if `thorough`. kOwn creates it if `create`. Errors
/// as those of sqlite::open_file; kInvalid: a damaged database; kRefused: no database, one of another program, or of a
/// newer version; kExpired: `stop` ended it. What is refused is left as it is.
Result<sqlite::OpenFile> open_history_file(const std::string& path, sqlite::FileUse use, bool thorough, bool create,
                                           const std::stop_token& stop = {});

}  // namespace rubicon::history
