#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "apps/rubicon/live_island.h"

namespace rubicon::cli {
namespace {

using testing::HasSubstr;

TEST(HistoryCommand, CompactCreatesNoFile) {
  Folder folder;
  const auto compacted = rubicon({"history", folder.file("typo.history"), "compact"});
  EXPECT_EQ(compacted.code, 1) << compacted.output;
  EXPECT_THAT(compacted.errors, HasSubstr("does not exist"));
  EXPECT_FALSE(std::filesystem::exists(folder.file("typo.history")));
}

TEST(HistoryCommand, LeavesAFileThatIsNoHistory) {
  Folder folder;
  const auto notes = folder.write("notes.txt", std::string(2000, 'n'));
  for (const auto* command : {"info", "compact"}) {
    const auto refused = rubicon({"history", notes, command});
    EXPECT_EQ(refused.code, 1) << refused.output;
    EXPECT_THAT(refused.errors, HasSubstr("is not an SQLite database"));
  }
  EXPECT_FALSE(std::filesystem::exists(notes + "-lock"));
}

/// The history of the demo's recording.
class DemoHistory : public testing::Test {
 protected:
  void SetUp() override {
    const auto filled = ask({"import", RUBICON_SOURCE_DIR "/examples/recordings/demo_hour.rec", "--end", kEnd});
    ASSERT_EQ(filled.code, 0) << filled.errors;
    imported_ = filled.output;
  }
  Outcome ask(std::vector<std::string> words) const {
    words.insert(words.begin(), {"history", file_});
    return rubicon(std::move(words));
  }
  nlohmann::json ask_json(std::vector<std::string> words) const {
    words.emplace_back("--json");
    const auto outcome = ask(std::move(words));
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return nlohmann::json::parse(outcome.output, nullptr, false);
  }
  static long lines_in(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }
  /// The values that are in the file, without the marks of gaps.
  static long values_in(const std::string& csv) {
    std::istringstream text(csv);
    long count = -1;  // the names of the columns
    for (std::string line; std::getline(text, line);) count += line.ends_with(',') ? 0 : 1;
    return count;
  }

  static constexpr const char* kEnd = "2026-02-01T12:00:00Z";
  static constexpr const char* kTemperatures = "*:proxy.*.*.sensor.temperature-1.value";
  Folder folder_;
  std::string file_ = folder_.file("demo.history");
  std::string imported_;
};

TEST_F(DemoHistory, SeriesHaveTheShortNamesOfPoints) {
  const auto whole = ask({"export", kTemperatures});
  EXPECT_GT(lines_in(whole.output), 10) << whole.errors;
  EXPECT_EQ(ask({"export", "*.temperature-1"}).output, whole.output);
  EXPECT_EQ(ask({"query", "nobody.temperature-1"}).code, 8);
  EXPECT_EQ(ask({"query", "a..b"}).code, 2);
}

TEST(HistoryCommand, ReadsTheHistoryOfARunningIsland) {
  const PrivateNetwork alone;
  if (!alone.entered()) GTEST_SKIP() << alone.reason();
  Folder folder;
  const auto island = started(folder.write("home.yaml", small_island(6541) + "history: {file: own.history}\n"));
  for (const auto* word : {"small", "6541"}) {
    auto info = rubicon({"history", word, "info", "--json"});
    for (int i = 0; i < 200 && info.code != 0; ++i)  // the file is made with the first values
      info = rubicon({"history", word, "info", "--json"});
    ASSERT_EQ(info.code, 0) << info.errors;
    EXPECT_EQ(lines_of(info).at(0)["file"], std::filesystem::canonical(folder.file("own.history")).string());
  }
  const auto nobody = rubicon({"history", "attic", "info"});
  EXPECT_EQ(nobody.code, 1);
  EXPECT_THAT(nobody.errors, HasSubstr("attic"));
}

TEST_F(DemoHistory, InfoCountsWhatIsThere) {
  const auto info = ask_json({"info"});
  EXPECT_EQ(info["file"], std::filesystem::canonical(file_).string());
  EXPECT_GT(info["series"], 20);
  EXPECT_GT(info["points"], 1000);
  EXPECT_EQ(info["open"], 0);
  EXPECT_EQ(info["damaged"], 0);
  EXPECT_EQ(info["bytes"], std::filesystem::file_size(file_));
  EXPECT_THAT(imported_, HasSubstr(" points of "));
  const auto text = ask({"info"});
  EXPECT_THAT(text.output, HasSubstr(fmt::format("series: {}\n", info["series"].get<int>())));
  EXPECT_THAT(text.output, HasSubstr("damage: none\n"));
}

TEST_F(DemoHistory, QueryListsItsSeries) {
  const auto series = ask_json({"query"})["series"];
  EXPECT_EQ(series.size(), ask_json({"info"})["series"].get<std::size_t>());
  for (const auto& one : series) {
    EXPECT_LE(one["first"].get<double>(), one["last"].get<double>());
    EXPECT_LE(one["last"].get<double>(), 1'769'947'200 + 5) << "moved to the end that was asked for";
    EXPECT_GE(one["first"].get<double>(), 1'769'947'200 - 2 * 3600);
  }
  EXPECT_THAT(ask({"query"}).output, HasSubstr("SERIES"));
}

TEST_F(DemoHistory, QueryShowsBucketsInEachForm) {
  const auto answer =
      ask_json({"query", kTemperatures, "--from", "2026-02-01T11:00:00Z", "--to", kEnd, "--buckets", "10"});
  EXPECT_EQ(answer["bucket"], 600);
  ASSERT_FALSE(answer["series"].empty());
  long buckets = 0;
  for (const auto& one : answer["series"]) {
    EXPECT_EQ(one["unit"], "Cel");
    EXPECT_LE(one["t"].size(), 10U);
    buckets += static_cast<long>(one["t"].size());
  }
  EXPECT_GT(buckets, 5);
  const auto csv =
      ask({"query", kTemperatures, "--from", "2026-02-01T11:00:00Z", "--to", kEnd, "--buckets", "10", "--csv"});
  EXPECT_THAT(csv.output, testing::StartsWith("time,key,count,first,minimum,maximum,mean,last\n"));
  EXPECT_EQ(lines_in(csv.output), 1 + buckets);
  const auto table = ask({"query", kTemperatures, "--from", "2026-02-01T11:00:00Z", "--to", kEnd});
  EXPECT_THAT(table.output, HasSubstr("MEAN"));
  EXPECT_THAT(table.output, HasSubstr(", Cel\n"));
}

TEST_F(DemoHistory, QueryNamesWhatIsWrong) {
  EXPECT_EQ(ask({"query", "1:nothing.here"}).code, 8);
  EXPECT_THAT(ask({"query", "1:nothing.here"}).errors, HasSubstr("no series fits"));
  EXPECT_EQ(ask({"query", kTemperatures, "--from", "yesterday"}).code, 2);
  EXPECT_EQ(ask({"query", kTemperatures, "--buckets", "0"}).code, 2);
  EXPECT_THAT(ask({"query", kTemperatures, "--from", "1h", "--to", "2h"}).errors, HasSubstr("not after its beginning"));
}

TEST_F(DemoHistory, ExportWritesEachValue) {
  const auto all = ask({"export"});
  EXPECT_THAT(all.output, testing::StartsWith("time,owner,key,value\n"));
  const auto info = ask_json({"info"});
  EXPECT_EQ(values_in(all.output), info["points"].get<long>() + info["texts"].get<long>());
  const auto some = ask({"export", kTemperatures, "--from", "2026-02-01T11:30:00Z", "--to", "2026-02-01T11:40:00Z"});
  EXPECT_GT(lines_in(some.output), 1);
  EXPECT_LT(lines_in(some.output), lines_in(all.output) / 3);
  std::istringstream lines(some.output);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) EXPECT_THAT(line, HasSubstr(".temperature-1.value,"));
}

TEST_F(DemoHistory, CompactChangesNoValue) {
  const auto before = ask({"export"}).output;
  const auto compacted = ask({"compact"});
  EXPECT_EQ(compacted.code, 0) << compacted.errors;
  EXPECT_THAT(compacted.output, HasSubstr(fmt::format("{} bytes, before ", std::filesystem::file_size(file_))));
  EXPECT_EQ(ask({"export"}).output, before);
  EXPECT_FALSE(std::filesystem::exists(file_ + "-wal"));
}

}  // namespace
}  // namespace rubicon::cli
