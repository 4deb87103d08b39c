#pragma once

#include <functional>
#include <optional>
#include <stop_token>

#include "sqlite/database.h"

namespace rubicon::sqlite {

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
