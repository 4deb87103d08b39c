#include "sqlite/database.h"

#include <gtest/gtest.h>

#include <functional>
#include <stop_token>

#include "support/folder.h"

namespace rubicon::sqlite {
namespace {

constexpr const char* kLong =
    "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n LIMIT 100000) SELECT max(i) FROM n";

TEST(Interruption, EndsAStatementThatRuns) {
  auto database = Database::open("test file", ":memory:", Database::Mode::kCreate).value();
  int asked = 0;
  {
    const Interruption third(database, [&] { return ++asked == 3; });
    const auto ended = database.number(kLong, "counting");
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().code, ErrorCode::kExpired);
    EXPECT_NE(ended.error().text.find("counting: interrupted"), std::string::npos) << ended.error().text;
  }
  EXPECT_EQ(asked, 3);
  EXPECT_EQ(database.number(kLong, "counting").value_or(0), 100'000);
  EXPECT_EQ(asked, 3);
}

TEST(Interruption, EndsACheck) {
  auto database = Database::open("test file", ":memory:", Database::Mode::kCreate).value();
  ASSERT_TRUE(
      database.run("CREATE TABLE t(a INTEGER PRIMARY KEY,b TEXT NOT NULL);"
                   "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n LIMIT 5000)"
                   "INSERT INTO t SELECT i,'text' FROM n",
                   "filling"));
  const Interruption once(database, [] { return true; });
  EXPECT_EQ(database.word("PRAGMA quick_check(1)", "checking").error().code, ErrorCode::kExpired);
}

/// A disk below SQLite that calls `on_read` before each read.
struct ReadingDisk {
  static inline std::function<void()> on_read;
  static inline sqlite3_io_methods methods{};
  static inline const sqlite3_io_methods* real = nullptr;
  static inline sqlite3_vfs disk{};
  static inline sqlite3_vfs* system = nullptr;

  ReadingDisk() {
    system = sqlite3_vfs_find(nullptr);
    disk = *system;
    disk.zName = "reading";
    disk.xOpen = [](sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out) {
      const int code = system->xOpen(system, name, file, flags, out);
      if (code != SQLITE_OK || (flags & SQLITE_OPEN_MAIN_DB) == 0) return code;
      real = file->pMethods;
      methods = *real;
      methods.xRead = [](sqlite3_file* from, void* to, int size, sqlite3_int64 at) {
        if (on_read) on_read();
        return real->xRead(from, to, size, at);
      };
      file->pMethods = &methods;
      return code;
    };
    sqlite3_vfs_register(&disk, 1);
  }
  ~ReadingDisk() {
    on_read = nullptr;
    sqlite3_vfs_unregister(&disk);
  }
};

TEST(Interruption, ARequestToStopEndsACheckWhileItReadsATable) {
  const support::Folder folder;
  const ReadingDisk disk;
  auto database = Database::open("test file", folder / "t", Database::Mode::kCreate).value();
  // The cache is smaller than the table.
  ASSERT_TRUE(
      database.run("PRAGMA mmap_size=0; PRAGMA cache_size=10; CREATE TABLE t(a INTEGER PRIMARY KEY,b TEXT NOT NULL);"
                   "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n LIMIT 1000)"
                   "INSERT INTO t SELECT i,printf('%.3000c','x') FROM n",
                   "filling"));
  std::stop_source stop;
  const Interruption interruption(database, {}, stop.get_token(), Interruption::kCheckSteps);
  int reads = 0;
  ReadingDisk::on_read = [&] {
    if (++reads == 100) stop.request_stop();
  };
  EXPECT_EQ(database.word("PRAGMA quick_check(1)", "checking").error().code, ErrorCode::kExpired);
  EXPECT_GE(reads, 100);
  EXPECT_LT(reads, 110);
}

TEST(Interruption, ARequestThatCameBeforeEndsAlsoAShortCheck) {
  auto database = Database::open("test file", ":memory:", Database::Mode::kCreate).value();
  ASSERT_TRUE(database.run("CREATE TABLE t(a)", "filling"));
  std::stop_source stop;
  stop.request_stop();
  {
    const Interruption interruption(database, {}, stop.get_token(), Interruption::kCheckSteps);
    EXPECT_EQ(database.word("PRAGMA quick_check(1)", "checking").error().code, ErrorCode::kExpired);
  }
  EXPECT_EQ(database.word("PRAGMA quick_check(1)", "checking").value_or("none"), "ok");
}

TEST(Interruption, WithoutAConditionNothingEnds) {
  auto database = Database::open("test file", ":memory:", Database::Mode::kCreate).value();
  const Interruption never(database, {});
  EXPECT_TRUE(database.number(kLong, "counting"));
}

TEST(Database, ARowThatATableDoesNotTakeIsADuplicate) {
  auto database = Database::open("test file", ":memory:", Database::Mode::kCreate).value();
  ASSERT_TRUE(database.run("CREATE TABLE t(a UNIQUE); INSERT INTO t VALUES(1)", "filling"));
  EXPECT_EQ(database.run("INSERT INTO t VALUES(1)", "filling").error().code, ErrorCode::kDuplicate);
}

}  // namespace
}  // namespace rubicon::sqlite
