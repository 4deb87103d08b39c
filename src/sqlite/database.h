#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "base/bytes.h"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::sqlite {

/// SQLite's last error: damage is kInvalid, writing a read-only file kRefused, a lock of another process kBusy, a
/// value that is too large kOutOfRange, a row that its table does not take kDuplicate, an Interruption kExpired, the
/// rest kIo. The text names the file, the action and the cause. `noun` says what kind of file it is: `state file`.
Error sqlite_error(const char* noun, sqlite3* database, std::string_view doing);

/// A prepared statement, to be used by Query. The database must outlive it.
class Statement {
 public:
  Statement() = default;
  /// `damaged` is set when the statement finds damage.
  Statement(sqlite3_stmt* statement, const char* noun, const char* doing, bool* damaged)
      : statement_(statement), noun_(noun), doing_(doing), damaged_(damaged) {}

 private:
  friend class Query;
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  const char* noun_ = "";
  const char* doing_ = "";  ///< for error texts: `reading a device`
  bool* damaged_ = nullptr;
};

/// One use of a statement: bind its parameters in order, step, read columns. The statement is ready for the next use
/// when the query goes out of scope. Bound texts and blobs must outlive the query.
class Query {
 public:
  explicit Query(Statement& statement)
      : statement_(statement.statement_.get()),
        noun_(statement.noun_),
        doing_(statement.doing_),
        damaged_(statement.damaged_) {}
  ~Query();
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  Query& integer(std::int64_t value);
  Query& time(WallTime value);  ///< as microseconds since 1970-01-01 UTC
  Query& real(double value);
  Query& text(std::string_view value);
  Query& blob(ByteView value);
  Query& null();

  /// True: a row can be read; false: there are no more.
  Result<bool> next();
  /// For statements without rows.
  Result<void> run();
  /// Rows the last insert, update or delete of the connection changed.
  std::int64_t changes() const;
  std::int64_t last_row() const;

  /// SQLITE_INTEGER, SQLITE_FLOAT, SQLITE_TEXT, SQLITE_BLOB, SQLITE_NULL.
  int type_of(int column) const;
  std::int64_t integer_at(int column) const;
  double real_at(int column) const;
  WallTime time_at(int column) const;          ///< of microseconds since 1970-01-01 UTC
  std::string_view text_at(int column) const;  ///< valid until the next step
  ByteView blob_at(int column) const;          ///< valid until the next step

 private:
  void keep(int code);

  sqlite3_stmt* statement_;
  const char* noun_;
  const char* doing_;
  bool* damaged_;
  int bound_ = 0;
  int failure_ = SQLITE_OK;
};

/// A connection to one file. Throws nothing.
class Database {
 public:
  enum class Mode {
    kCreate,     ///< reads and writes; creates the file if it does not exist
    kWrite,      ///< reads and writes an existing file
    kRead,       ///< reads
    kImmutable,  ///< reads a file that no process writes, without further files beside it
  };
  /// `noun`, for error texts, must outlive it.
  static Result<Database> open(const char* noun, const std::string& path, Mode mode);

  Result<void> run(const char* sql, const char* doing);
  Result<Statement> prepare(const char* sql, const char* doing);
  /// First column of the first row; kInvalid if there is none.
  Result<std::int64_t> number(const char* sql, const char* doing);
  Result<std::string> word(const char* sql, const char* doing);

  /// Every committed transaction is on the disk when this returns.
  Result<void> sync();
  /// A statement has found the file damaged. kInvalid without this: a table is missing or has other columns.
  bool damaged() const { return *damaged_; }
  bool in_transaction() const { return sqlite3_get_autocommit(database_.get()) == 0; }
  sqlite3* handle() const { return database_.get(); }
  const char* noun() const { return noun_; }
  std::string path() const;

 private:
  struct Close {
    void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
  };
  Error error(const char* doing);

  std::unique_ptr<bool> damaged_ = std::make_unique<bool>(false);  // statements have its address
  std::unique_ptr<sqlite3, Close> database_;
  const char* noun_ = "";
};

/// While it lives, statements of a database can be ended: they then fail with kExpired. A database has one at a time,
/// and must outlive it.
class Interruption {
 public:
  using Ends = std::function<bool()>;

  /// About so many steps of a statement's program are between two calls of `ends`.
  static constexpr int kSteps = 1000;
  /// A check of the file takes few steps, and each of them long.
  static constexpr int kCheckSteps = 1;

  /// `ends` runs on the thread that runs the statement; empty = never. It is not called while a check reads a table. A
  /// request to `stop`, by any thread, ends that as well.
  Interruption(Database& database, Ends ends, std::stop_token stop = {}, int steps = kSteps);
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

 private:
  struct Interrupt {
    sqlite3* database;
    void operator()() const { sqlite3_interrupt(database); }
  };

  sqlite3* database_;
  Ends ends_;
  std::stop_token stop_;
  // Its end waits for a call on another thread: the database is not closed meanwhile.
  std::optional<std::stop_callback<Interrupt>> on_stop_;
};

}  // namespace rubicon::sqlite
