#include "sqlite/versions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <tuple>

namespace rubicon::sqlite {

namespace {

/// Runs `work` and sets the version of the file, all or nothing.
Result<void> run_step(Database& database, const Format& format, const std::string& work, std::size_t version) {
  const auto sql = fmt::format("BEGIN IMMEDIATE;{};PRAGMA application_id={};PRAGMA user_version={};COMMIT", work,
                               format.application, version);
  auto done = database.run(sql.c_str(), "upgrading it");
  if (!done && database.in_transaction()) std::ignore = database.run("ROLLBACK", "rolling back");
  // Rows that the next version does not take are damage.
  if (!done && done.error().code == ErrorCode::kDuplicate) done.error().code = ErrorCode::kInvalid;
  return done;
}

}  // namespace

Result<Header> read_header(Database& database, const Format& format) {
  constexpr const char* kDoing = "reading its header";
  const auto application = database.number("PRAGMA application_id", kDoing);
  if (!application) return fail(application.error());
  const auto version = database.number("PRAGMA user_version", kDoing);
  if (!version) return fail(version.error());
  const auto tables = database.number("SELECT count(*) FROM sqlite_schema", kDoing);
  if (!tables) return fail(tables.error());
  if (*application == 0 && *version == 0 && *tables == 0) return Header{true, 0};
  const auto file = fmt::format("{} {}", database.noun(), database.path());
  if (*application != format.application) {
    return fail(ErrorCode::kRefused, fmt::format("{}: an SQLite database of another program", file));
  }
  const auto newest = static_cast<std::int64_t>(format.steps.size());
  if (*version > newest) {
    return fail(ErrorCode::kRefused, fmt::format("{}: made by a newer {} (version {}, this program knows versions up "
                                                 "to {})",
                                                 file, format.program, *version, newest));
  }
  if (*version < 1) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: has version {}, expected 1 or more", file, *version));
  }
  return Header{false, *version};
}

Result<void> make_tables(Database& database, const Format& format, std::string_view finally) {
  const auto work = fmt::format("{};{}", fmt::join(format.steps, ";"), finally);
  return run_step(database, format, work, format.steps.size());
}

Result<void> upgrade(Database& database, std::int64_t version, const Format& format) {
  for (auto next = static_cast<std::size_t>(version); next < format.steps.size(); ++next) {
    if (auto done = run_step(database, format, format.steps[next], next + 1); !done) return done;
  }
  return {};
}

}  // namespace rubicon::sqlite
