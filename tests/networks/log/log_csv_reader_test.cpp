#include <gtest/gtest.h>

#include "networks/log/csv_mapping.h"
#include "networks/log/file_chain.h"
#include "networks/log/file_time.h"

namespace rubicon::networks::log {
namespace {

std::vector<TextLine> lines_of(std::string_view content, std::size_t piece = 1 << 20) {
  LineReader reader;
  std::vector<TextLine> lines;
  const auto drain = [&] {
    while (auto line = reader.next()) lines.push_back(std::move(*line));
  };
  for (std::size_t at = 0; at < content.size(); at += piece) {
    reader.feed(base::as_bytes(content.substr(at, piece)));
    drain();
  }
  reader.end();
  drain();
  return lines;
}

std::vector<std::string> texts_of(std::string_view content, std::size_t piece = 1 << 20) {
  std::vector<std::string> texts;
  for (const TextLine& line : lines_of(content, piece)) texts.push_back(line.text);
  return texts;
}

using Texts = std::vector<std::string>;

Texts cells_of(std::string_view line, std::string_view separators) {
  std::vector<std::string_view> cells;
  split_cells(line, separators, cells);
  return {cells.begin(), cells.end()};
}

TEST(LineReader, TakesEitherLineEndAndDropsTheByteOrderMark) {
  EXPECT_EQ(texts_of("\xef\xbb\xbf"
                     "a\r\nb\nc\r\n"),
            (Texts{"a", "b", "c"}));
}

TEST(LineReader, GivesALastLineWithoutLineEnd) {
  EXPECT_EQ(texts_of("a\n\nb"), (Texts{"a", "", "b"}));
  EXPECT_EQ(texts_of(""), Texts{});
}

TEST(LineReader, IsTheSameInPiecesOfAnySize) {
  for (const std::size_t piece : {1u, 2u, 3u, 5u})
    EXPECT_EQ(texts_of("\xef\xbb\xbf"
                       "one\r\ntwo\n\nthree",
                       piece),
              (Texts{"one", "two", "", "three"}))
        << piece;
}

TEST(LineReader, NamesOffsetAndNumber) {
  const auto lines = lines_of("ab\r\ncd\n");
  EXPECT_EQ(lines.at(1).offset, 4u);
  EXPECT_EQ(lines.at(1).number, 2u);
  EXPECT_EQ(lines.at(1).bytes, 3u);
}

TEST(LineReader, SkipsALineThatIsTooLongAndGoesOnBehindIt) {
  for (const std::size_t piece : {1000u, 65'536u, 1u << 20}) {
    const auto lines = lines_of("a\n" + std::string(300'000, 'x') + "\nb\n", piece);
    ASSERT_EQ(lines.size(), 3u) << piece;
    EXPECT_TRUE(lines[1].too_long);
    EXPECT_EQ(lines[1].text, "");
    EXPECT_EQ(lines[1].offset, 2u);
    EXPECT_EQ(lines[1].bytes, 300'001u);
    EXPECT_EQ(lines[2].text, "b");
    EXPECT_EQ(lines[2].offset, 300'003u);
  }
}

TEST(LineReader, ReportsAHugeLastLine) {
  const auto lines = lines_of(std::string(300'000, 'x'), 1000);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_TRUE(lines[0].too_long);
  EXPECT_EQ(lines[0].bytes, 300'000u);
}

TEST(SplitCells, TrimsCellsAndKeepsEmptyOnes) {
  EXPECT_EQ(cells_of(" a , b,,c ", ","), (Texts{"a", "b", "", "c"}));
  EXPECT_EQ(cells_of("a,b,", ","), (Texts{"a", "b", ""}));
  EXPECT_EQ(cells_of("", ","), (Texts{""}));
}

TEST(SplitCells, BlanksSeparateOnlyLinesWithoutAnotherSeparator) {
  EXPECT_EQ(cells_of("1, 2, 3", ", "), (Texts{"1", "2", "3"}));
  EXPECT_EQ(cells_of("1  2 3 ", ", "), (Texts{"1", "2", "3"}));
  EXPECT_EQ(cells_of("1;2,3", ",;"), (Texts{"1", "2", "3"}));
}

TEST(SplitCells, QuotesProtectSeparators) {
  EXPECT_EQ(cells_of("\"a,b\", c", ","), (Texts{"a,b", "c"}));
  EXPECT_EQ(cells_of("\"a b\" c", " "), (Texts{"a b", "c"}));
  EXPECT_EQ(cells_of("\"open,c", ","), (Texts{"\"open", "c"}));
}

TEST(NumberOf, TakesDecimalNumbersOnly) {
  EXPECT_EQ(number_of("-0.90476"), -0.90476);
  EXPECT_EQ(number_of("+3"), 3.0);
  EXPECT_EQ(number_of("1e3"), 1000.0);
  for (const char* text : {"", "NaN", "nan", "inf", "-inf", "0x10", "1,5", "1.5 ", "abc", "1e999", "--1"})
    EXPECT_EQ(number_of(text), std::nullopt) << text;
}

TEST(IsoTime, ReadsZonesFractionsAndDates) {
  const WallTime noon = std::chrono::sys_days(std::chrono::year(2026) / 1 / 31) + std::chrono::hours(12);
  const auto moment = [](std::string_view text) { return parse_iso_time(text).value_or(FileTime{}).time; };
  for (const auto* text : {"2026-01-31T12:00:00Z", "2026-01-31 12:00", "2026-01-31T13:00:00+01:00",
                           "2026-01-31T06:30:00-0530", "2026-01-31 20:00:00 +08:00"})
    EXPECT_EQ(moment(text), noon) << text;
  EXPECT_EQ(moment("2026-01-31T12:00:00.25Z"), noon + std::chrono::milliseconds(250));
  EXPECT_EQ(moment("2026-01-31"), noon - std::chrono::hours(12));
  EXPECT_EQ(moment("2026-01-31T24:00:00Z"), noon + std::chrono::hours(12));
  EXPECT_TRUE(parse_iso_time("2026-01-31 12:00")->is_local);
  EXPECT_FALSE(parse_iso_time("2026-01-31 12:00Z")->is_local);
  EXPECT_FALSE(parse_iso_time("2026-01-31 12:00 +00:00")->is_local);
}

TEST(IsoTime, RefusesEverythingElse) {
  for (const char* text :
       {"", "2026", "2026-13-01", "2026-02-30", "2026-01-31T25:00", "2026-01-31T24:01", "2026-01-31 12:00 ",
        "2026-01-31T12:00:00X", "31.1.2026", "2026-01-31T12:00:00.Z", "2026-01-31T12:00:00+1", "2026--1-31"})
    EXPECT_FALSE(parse_iso_time(text)) << text;
}

std::optional<RecordTime> time_in(TimeUnit unit, std::string_view cell) {
  CsvMapping mapping;
  mapping.time_unit = unit;
  return time_of(mapping, cell, std::nullopt);
}

TEST(TimeOf, CountsInTheUnitOfTheColumn) {
  using namespace std::chrono_literals;
  EXPECT_EQ(time_in(TimeUnit::kMilliseconds, "250"), 250ms);
  EXPECT_EQ(time_in(TimeUnit::kSeconds, "0.5"), 500ms);
  EXPECT_EQ(time_in(TimeUnit::kMinutes, "2"), 2min);
  EXPECT_EQ(time_in(TimeUnit::kUnixMilliseconds, "1500"), 1500ms);
  EXPECT_EQ(time_in(TimeUnit::kIso, "1970-01-01T00:00:01Z"), 1s);
  EXPECT_EQ(time_in(TimeUnit::kHours, "1e300"), std::nullopt);
  EXPECT_EQ(time_in(TimeUnit::kSeconds, "soon"), std::nullopt);
}

TEST(TimeZones, TheSecondOfTwoEqualLocalTimesIsKnownByWhatCameBefore) {
  using namespace std::chrono_literals;
  const auto berlin = TimeZone::load("Europe/Berlin");
  ASSERT_TRUE(berlin) << berlin.error().text;
  const auto at = [&](std::string_view local, std::optional<WallTime> previous) {
    return berlin->moment_of(parse_iso_time(local)->time, previous);
  };
  const auto utc = [](std::string_view text) { return parse_iso_time(text)->time; };
  EXPECT_EQ(at("2025-07-01 12:00", std::nullopt), utc("2025-07-01T10:00Z"));
  EXPECT_EQ(at("2025-12-01 12:00:00.5", std::nullopt), utc("2025-12-01T11:00:00.5Z"));
  const auto first = at("2025-10-26 02:15", utc("2025-10-25T23:30Z"));
  EXPECT_EQ(first, utc("2025-10-26T00:15Z"));
  EXPECT_EQ(at("2025-10-26 02:15", at("2025-10-26 02:45", first)), utc("2025-10-26T01:15Z"));
  EXPECT_EQ(at("2025-10-26 02:15", first), first) << "an equal time is no step back";
  EXPECT_EQ(at("2026-03-29 02:30", std::nullopt), utc("2026-03-29T01:30Z")) << "clocks left it out";
  EXPECT_EQ(TimeZone::load("Europe/Nowhere").error().code, ErrorCode::kNotFound);
}

TEST(TimeFormats, AreThoseOfStrptime) {
  const auto read = [](std::string_view format, std::string_view text) {
    const auto time = parse_time(format, text);
    return time ? std::optional(time->time) : std::nullopt;
  };
  const auto expected = parse_iso_time("2018-09-20T12:13:34.5Z")->time;
  EXPECT_EQ(read("%d.%m.%Y %H:%M:%E*S", "20.09.2018 12:13:34.5"), expected);
  EXPECT_EQ(read("%d.%m.%Y %H:%M:%E*S %z", "20.09.2018 14:13:34.5 +0200"), expected);
  EXPECT_TRUE(parse_time("%d.%m.%Y", "20.09.2018")->is_local);
  EXPECT_FALSE(parse_time("%d.%m.%Y %z", "20.09.2018 +0200")->is_local);
  EXPECT_FALSE(parse_time("%d.%m.%Y %E*z", "20.09.2018 +02:00:00")->is_local);
  EXPECT_EQ(read("%d.%m.%Y", "20.09.30000"), std::nullopt);
  EXPECT_EQ(read("%d.%m.%Y", "2018-09-20"), std::nullopt);
  EXPECT_EQ(read("%d.%m.%Y", "infinite-future"), std::nullopt);
}

}  // namespace
}  // namespace rubicon::networks::log
