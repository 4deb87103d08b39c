#include "sqlite/database.h"

#include <fmt/format.h>

#include <cstring>
#include <utility>

namespace rubicon::sqlite {

namespace {

/// Longer texts and blobs can only come from a damaged file.
constexpr int kMaxField = 4 << 20;
constexpr int kBusyTimeoutMs = 500;  // a tool may read, or SQLite recover the file

ErrorCode code_of(int extended) {
  switch (extended & 0xff) {
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
    case SQLITE_MISMATCH:
    case SQLITE_ERROR: return ErrorCode::kInvalid;  // a table is missing or has other columns
    case SQLITE_BUSY:
    case SQLITE_LOCKED: return ErrorCode::kBusy;
    case SQLITE_READONLY: return ErrorCode::kRefused;
    case SQLITE_TOOBIG: return ErrorCode::kOutOfRange;
    case SQLITE_CONSTRAINT: return ErrorCode::kDuplicate;
    case SQLITE_INTERRUPT: return ErrorCode::kExpired;
    default: return ErrorCode::kIo;
  }
}

bool system_failed(int extended) {
  const auto code = extended & 0xff;
  return code == SQLITE_IOERR || code == SQLITE_FULL || code == SQLITE_CANTOPEN;
}

bool found_damage(sqlite3* database) {
  const auto code = sqlite3_errcode(database) & 0xff;
  return code == SQLITE_CORRUPT || code == SQLITE_NOTADB;
}

/// The path as a `file:` URI.
std::string uri_of(const std::string& path, Database::Mode mode) {
  std::string out = "file:";
  for (const char c : path) {
    if (c == '?' || c == '#' || c == '%') {
      out += fmt::format("%{:02x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  if (mode == Database::Mode::kImmutable) out += "?immutable=1";
  return out;
}

int flags_of(Database::Mode mode) {
  const int common = SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_PRIVATECACHE | SQLITE_OPEN_EXRESCODE;
  switch (mode) {
    case Database::Mode::kCreate: return common | SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
    case Database::Mode::kWrite: return common | SQLITE_OPEN_READWRITE;
    default: return common | SQLITE_OPEN_READONLY;
  }
}

/// Keeps a hostile file from running code (https://www.sqlite.org/security.html, "Untrusted SQLite Database
/// Files").
void distrust(sqlite3* database) {
  sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(database, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(database, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_limit(database, SQLITE_LIMIT_LENGTH, kMaxField);
}

}  // namespace

Error sqlite_error(const char* noun, sqlite3* database, std::string_view doing) {
  const int code = sqlite3_extended_errcode(database);
  const auto* file = sqlite3_db_filename(database, "main");
  auto text = fmt::format("{} {}: {}: {}", noun, file ? file : "", doing, sqlite3_errmsg(database));
  const int system = sqlite3_system_errno(database);
  if (system_failed(code) && system != 0) text += fmt::format(" ({})", std::strerror(system));
  return {code_of(code), std::move(text)};
}

Query::~Query() {
  sqlite3_reset(statement_);
  sqlite3_clear_bindings(statement_);
}

void Query::keep(int code) {
  if (failure_ == SQLITE_OK) failure_ = code;
}

Query& Query::integer(std::int64_t value) {
  keep(sqlite3_bind_int64(statement_, ++bound_, value));
  return *this;
}

Query& Query::real(double value) {
  keep(sqlite3_bind_double(statement_, ++bound_, value));
  return *this;
}

Query& Query::time(WallTime value) {
  return integer(value.time_since_epoch().count());
}

Query& Query::text(std::string_view value) {
  const auto* bytes = value.data() ? value.data() : "";  // a null pointer would bind NULL
  keep(sqlite3_bind_text64(statement_, ++bound_, bytes, value.size(), SQLITE_STATIC, SQLITE_UTF8));
  return *this;
}

Query& Query::blob(ByteView value) {
  const auto* bytes = value.data() ? static_cast<const void*>(value.data()) : "";
  keep(sqlite3_bind_blob64(statement_, ++bound_, bytes, value.size(), SQLITE_STATIC));
  return *this;
}

Query& Query::null() {
  keep(sqlite3_bind_null(statement_, ++bound_));
  return *this;
}

Result<bool> Query::next() {
  if (failure_ == SQLITE_OK) {
    const int code = sqlite3_step(statement_);
    if (code == SQLITE_ROW) return true;
    if (code == SQLITE_DONE) return false;
  }
  auto* database = sqlite3_db_handle(statement_);
  if (found_damage(database)) *damaged_ = true;
  return fail(sqlite_error(noun_, database, doing_));
}

Result<void> Query::run() {
  while (true) {
    const auto row = next();
    if (!row) return fail(row.error());
    if (!*row) return {};
  }
}

std::int64_t Query::changes() const {
  return sqlite3_changes64(sqlite3_db_handle(statement_));
}

std::int64_t Query::last_row() const {
  return sqlite3_last_insert_rowid(sqlite3_db_handle(statement_));
}

int Query::type_of(int column) const {
  return sqlite3_column_type(statement_, column);
}

std::int64_t Query::integer_at(int column) const {
  return sqlite3_column_int64(statement_, column);
}

WallTime Query::time_at(int column) const {
  return WallTime(std::chrono::microseconds(integer_at(column)));
}

double Query::real_at(int column) const {
  return sqlite3_column_double(statement_, column);
}

std::string_view Query::text_at(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  if (!text) return {};
  return {text, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

ByteView Query::blob_at(int column) const {
  const auto* bytes = static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_, column));
  if (!bytes) return {};
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

Result<Database> Database::open(const char* noun, const std::string& path, Mode mode) {
  sqlite3* opened = nullptr;
  const int code = sqlite3_open_v2(uri_of(path, mode).c_str(), &opened, flags_of(mode), nullptr);
  Database database;
  database.database_.reset(opened);
  database.noun_ = noun;
  if (!opened) return fail(ErrorCode::kIo, fmt::format("{} {}: opening: out of memory", noun, path));
  if (code != SQLITE_OK) {
    auto error = sqlite_error(noun, opened, "opening");
    // Without a connection SQLite does not know the name of the file either.
    return fail(error.code, fmt::format("{} {}: opening: {} ({})", noun, path, sqlite3_errmsg(opened),
                                        std::strerror(sqlite3_system_errno(opened))));
  }
  distrust(opened);
  sqlite3_busy_timeout(opened, kBusyTimeoutMs);
  return database;
}

Error Database::error(const char* doing) {
  if (found_damage(handle())) *damaged_ = true;
  return sqlite_error(noun_, handle(), doing);
}

Result<void> Database::run(const char* sql, const char* doing) {
  if (sqlite3_exec(database_.get(), sql, nullptr, nullptr, nullptr) == SQLITE_OK) return {};
  return fail(error(doing));
}

Result<Statement> Database::prepare(const char* sql, const char* doing) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v3(database_.get(), sql, -1, SQLITE_PREPARE_PERSISTENT, &statement, nullptr) == SQLITE_OK) {
    return Statement(statement, noun_, doing, damaged_.get());
  }
  return fail(error(doing));
}

Result<std::int64_t> Database::number(const char* sql, const char* doing) {
  auto statement = prepare(sql, doing);
  if (!statement) return fail(statement.error());
  Query query(*statement);
  const auto row = query.next();
  if (!row) return fail(row.error());
  if (*row && query.type_of(0) == SQLITE_INTEGER) return query.integer_at(0);
  return fail(ErrorCode::kInvalid, fmt::format("{} {}: {}: expected a number, there is none", noun_, path(), doing));
}

Result<std::string> Database::word(const char* sql, const char* doing) {
  auto statement = prepare(sql, doing);
  if (!statement) return fail(statement.error());
  Query query(*statement);
  const auto row = query.next();
  if (!row) return fail(row.error());
  return *row ? std::string(query.text_at(0)) : std::string();
}

std::string Database::path() const {
  const auto* file = sqlite3_db_filename(handle(), "main");
  return file ? file : "";
}

Result<void> Database::sync() {
  // Commits are in the write-ahead log, which synchronous=NORMAL does not sync (https://www.sqlite.org/wal.html,
  // "Performance Considerations"); its own file object does it without the cost of a checkpoint.
  sqlite3_file* log = nullptr;
  if (sqlite3_file_control(handle(), "main", SQLITE_FCNTL_JOURNAL_POINTER, &log) != SQLITE_OK) {
    return fail(sqlite_error(noun_, handle(), "syncing"));
  }
  if (!log || !log->pMethods) return {};  // no log: each commit was synced
  if (log->pMethods->xSync(log, SQLITE_SYNC_NORMAL) == SQLITE_OK) return {};
  return fail(ErrorCode::kIo, fmt::format("{} {}: syncing to the disk: {}", noun_, path(), std::strerror(errno)));
}

Interruption::Interruption(Database& database, Ends ends, std::stop_token stop, int steps)
    : database_(database.handle()), ends_(std::move(ends)), stop_(std::move(stop)) {
  if (!ends_ && !stop_.stop_possible()) return;
  // SQLite forgets an interrupt that comes before a statement begins: each one asks at its begin, too.
  const auto ask = [](void* self) {
    const auto& one = *static_cast<Interruption*>(self);
    return one.stop_.stop_requested() || (one.ends_ && one.ends_()) ? 1 : 0;
  };
  sqlite3_progress_handler(database_, steps, ask, this);
  on_stop_.emplace(stop_, Interrupt{database_});
}

Interruption::~Interruption() {
  on_stop_.reset();
  sqlite3_progress_handler(database_, 0, nullptr, nullptr);
}

}  // namespace rubicon::sqlite
