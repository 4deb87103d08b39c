#include "sqlite/interruption.h"

#include <gtest/gtest.h>

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
