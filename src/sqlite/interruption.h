#pragma once

#include <functional>

#include "sqlite/database.h"

namespace rubicon::sqlite {

/// While it lives, statements of a database are asked from time to time whether they should end: they then fail with
/// kExpired. A database has one at a time, and must outlive it.
class Interruption {
 public:
  using Ends = std::function<bool()>;

  /// `ends` runs on the thread that runs the statement, after about so many steps of its program each; empty = never.
  Interruption(Database& database, Ends ends);
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  static constexpr int kSteps = 1000;

 private:
  sqlite3* database_;
  Ends ends_;
};

}  // namespace rubicon::sqlite
