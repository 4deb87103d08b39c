#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>

#include "networks/log/log_support.h"

namespace rubicon::networks::log {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class LogCsv : public testing::Test {
 protected:
  /// Opens a table with a `room` device of a temperature and a humidity column, plus these options.
  void open(const std::string& content, std::vector<std::pair<std::string, ConfigNode>> options = {}) {
    listener_.files.files["room.csv"] = content;
    std::vector<std::pair<std::string, ConfigNode>> all{
        {"format", scalar("csv")},
        {"file", scalar("room.csv")},
        {"map",
         map({{"room", map({{"name", scalar("Room")},
                            {"columns", map({{"t", sensor("temperature-1")}, {"h", sensor("humidity-1")}})}})}})}};
    const bool has_time = std::any_of(options.begin(), options.end(), [](const auto& option) {
      return option.first == "period" || option.first == "time";
    });
    if (!has_time) all.emplace_back("period", scalar("1s"));
    all.insert(all.end(), options.begin(), options.end());
    open_options(map(std::move(all)));
  }

  /// The same with a file of tests/cases/log and its own columns.
  void open_case(const std::string& name, std::vector<std::pair<std::string, ConfigNode>> columns,
                 std::vector<std::pair<std::string, ConfigNode>> options = {}) {
    std::ifstream file(RUBICON_SOURCE_DIR "/tests/cases/log/" + name, std::ios::binary);
    listener_.files.files[name] = {std::istreambuf_iterator<char>(file), {}};
    std::vector<std::pair<std::string, ConfigNode>> all{
        {"format", scalar("csv")},
        {"file", scalar(name)},
        {"speed", scalar("max")},
        {"time", map({{"column", scalar("Zeit")}, {"unit", scalar("iso")}})},
        {"map", map({{"room", map({{"columns", map(std::move(columns))}})}})}};
    all.insert(all.end(), options.begin(), options.end());
    open_options(map(std::move(all)));
  }

  void open_options(ConfigNode options) {
    made_ = make_log(listener_, std::move(options), types_, directory_);
    ASSERT_NE(made_.network, nullptr) << (made_.errors.empty() ? "" : made_.errors.front());
    const auto opened = made_.network->open();
    ASSERT_TRUE(opened.has_value()) << opened.error().text;
  }

  std::vector<std::string> values() const {
    std::vector<std::string> texts;
    for (const model::Reading& reading : listener_.readings()) texts.push_back(model::to_text(reading.value));
    return texts;
  }

  TypeCatalogue types_;
  std::string directory_;
  Listener listener_;
  Made made_;
};

TEST_F(LogCsv, ItsSensorsAreGivenTheDeadlineOfTheOptions) {
  open("t,h\n20.5,40\n", {{"deadline", scalar("90s")}});
  listener_.time.run_for(500ms);
  const auto joins = listener_.of<model::Join>();
  ASSERT_EQ(joins.size(), 1u);
  for (const auto& capability : std::get<model::Join>(joins[0].second.body).capabilities) {
    EXPECT_EQ(capability.deadline, Duration(90s));
  }
}

TEST_F(LogCsv, JoinsTheDeviceAndPlaysARowEachPeriod) {
  open("t,h\n20.5,40\n20.6,41\n");
  listener_.time.run_for(500ms);
  const auto joins = listener_.of<model::Join>();
  ASSERT_EQ(joins.size(), 1u);
  EXPECT_EQ(joins[0].second.source.device, "room");
  const auto& join = std::get<model::Join>(joins[0].second.body);
  EXPECT_EQ(join.name, "Room");
  ASSERT_EQ(join.capabilities.size(), 2u);
  EXPECT_EQ(join.capabilities[0].point, (model::PointId{Kind::kSensor, types_.find("temperature")->id, "1"}));
  EXPECT_EQ(join.capabilities[0].access, model::Access::kRead);
  EXPECT_THAT(values(), ElementsAre("20.5", "40"));
  listener_.time.run_for(500ms);
  EXPECT_THAT(values(), ElementsAre("20.5", "40", "20.6", "41"));
  EXPECT_EQ(listener_.last_state().line, model::LineState::kEnded);
}

TEST_F(LogCsv, BadCellsAreDroppedAndCountedAndTheRestOfTheRowPlays) {
  open("t,h\nNaN,40\nwarm,41\n20.5,400\n20.6\n,42\n-300,43\n1e999,44\n");
  listener_.time.run_for(10s);
  EXPECT_THAT(values(), ElementsAre("40", "41", "20.5", "20.6", "42", "43", "44"));
  EXPECT_EQ(listener_.counter("damaged"), 6u);
  EXPECT_EQ(listener_.counter("records"), 7u);
  EXPECT_EQ(listener_.counter("lines"), 8u);
  ASSERT_EQ(listener_.lines.size(), 1u) << "once a minute";
  EXPECT_THAT(listener_.lines[0], HasSubstr("room.csv: byte 4: line 2, column `t`: `NaN`, expected a number"));
}

TEST_F(LogCsv, AHugeLineIsSkippedAndCounted) {
  open("t,h\n1,1\n" + std::string(200'000, '7') + "\n2,2\n");
  listener_.time.run_for(10s);
  EXPECT_THAT(values(), ElementsAre("1", "1", "2", "2"));
  EXPECT_EQ(listener_.counter("damaged"), 1u);
  EXPECT_EQ(listener_.counter("skipped-bytes"), 200'001u);
}

TEST_F(LogCsv, AMissingColumnIsReportedAndTheOthersPlay) {
  open("t,x\n20.5,40\n");
  listener_.time.run_for(10s);
  EXPECT_THAT(values(), ElementsAre("20.5"));
  ASSERT_FALSE(listener_.lines.empty());
  EXPECT_THAT(listener_.lines[0], HasSubstr("no column `h`"));
}

TEST_F(LogCsv, ColumnsWithoutNamesAreCounted) {
  listener_.files.files["room.csv"] = "7,20.5\n8,20.6\n";
  open_options(map({{"format", scalar("csv")},
                    {"file", scalar("room.csv")},
                    {"header", scalar("no")},
                    {"time", map({{"column", scalar("1")}, {"unit", scalar("s")}})},
                    {"map", map({{"room", map({{"columns", map({{"2", sensor("temperature-1")}})}})}})}}));
  listener_.time.run_for(10s);
  EXPECT_THAT(values(), ElementsAre("20.5", "20.6"));
  EXPECT_EQ(listener_.of<model::Updates>()[1].first, 1s);
}

TEST_F(LogCsv, TheLastOfSeveralHeaderLinesHoldsTheNames) {
  open("some title\nh;t\n40;20\n", {{"header", scalar("2")}});
  listener_.time.run_for(10s);
  EXPECT_THAT(values(), ElementsAre("20", "40"));
}

TEST_F(LogCsv, AGapInTheTimeColumnIsAPause) {
  open("time,t\n0,1\n250,2\n750,3\n", {{"time", map({{"column", scalar("time")}, {"unit", scalar("ms")}})}});
  listener_.time.run_for(10s);
  const auto updates = listener_.of<model::Updates>();
  ASSERT_EQ(updates.size(), 3u);
  EXPECT_EQ(updates[1].first, 250ms);
  EXPECT_EQ(updates[2].first, 750ms);
}

TEST_F(LogCsv, ADecimalCommaIsReadWhereTheOptionNamesIt) {
  open("\xef\xbb\xbfZeit;t;h\n0,5;21,5;45\n1,25;21,25;46.5\n",
       {{"decimal", scalar(",")}, {"time", map({{"column", scalar("Zeit")}, {"unit", scalar("s")}})}});
  listener_.time.run_for(10s);
  EXPECT_THAT(values(), ElementsAre("21.5", "45", "21.25"));
  EXPECT_EQ(listener_.of<model::Updates>()[1].first, 750ms);
  EXPECT_THAT(listener_.lines[0], HasSubstr("`46.5`, expected a number with the decimal comma that `decimal` names"));
}

TEST_F(LogCsv, AFileWithAMarkSemicolonsAndDecimalCommasIsReadWhole) {
  const std::vector<std::pair<std::string, ConfigNode>> columns{{"Temperatur", sensor("temperature-1")},
                                                                {"Feuchte", sensor("humidity-1")}};
  open_case("decimal_comma.csv", columns, {{"decimal", scalar(",")}});
  listener_.time.run_for(10s);
  EXPECT_THAT(values(), ElementsAre("21.5", "45", "21.25", "46"));
}

TEST_F(LogCsv, PropertiesHaveTheDecimalCommaOfTheirTable) {
  listener_.files.files["room.csv"] = "t\n21,5\n";
  open_options(
      map({{"format", scalar("csv")},
           {"file", scalar("room.csv")},
           {"period", scalar("1s")},
           {"decimal", scalar(",")},
           {"map", map({{"room", map({{"columns", map({{"t", sensor("temperature-1")}})},
                                      {"properties", map({{"light", map({{"value", scalar("7,5")}})}})}})}})}}));
  listener_.time.run_for(500ms);
  EXPECT_THAT(values(), ElementsAre("7.5", "21.5"));
}

TEST_F(LogCsv, ADecimalCommaWithoutTheOptionIsExplained) {
  open_case("decimal_comma.csv", {{"Temperatur", sensor("temperature-1")}}, {{"separators", scalar(";")}});
  listener_.time.run_for(10s);
  EXPECT_THAT(listener_.lines[0], HasSubstr("`21,5`, expected a number; numbers with a comma need `decimal: \",\"`"));
}

TEST_F(LogCsv, LocalTimesAreOfTheZoneAndTheRepeatedHourComesTwice) {
  open_case("local_times.csv", {{"T", sensor("temperature-1")}}, {{"zone", scalar("Europe/Berlin")}});
  listener_.time.run_for(10s);
  std::vector<std::int64_t> minutes;
  const auto readings = listener_.readings();
  for (const auto& reading : readings)
    minutes.push_back((reading.user_time - readings.front().user_time) / std::chrono::minutes(1));
  EXPECT_THAT(minutes, ElementsAre(0, 45, 75, 105, 135, 165));
  EXPECT_EQ(readings.front().user_time,
            WallTime(std::chrono::sys_days(std::chrono::year(2025) / 10 / 25) + 23h + 30min));
}

TEST_F(LogCsv, TimesMayHaveAFormatOfTheirOwn) {
  open("Zeit;t\n20.09.2018 12:13:34;1\n",
       {{"time", map({{"column", scalar("Zeit")}, {"format", scalar("%d.%m.%Y %H:%M:%S")}})}});
  listener_.time.run_for(1s);
  EXPECT_EQ(listener_.readings().at(0).user_time,
            WallTime(std::chrono::sys_days(std::chrono::year(2018) / 9 / 20) + 12h + 13min + 34s));
}

TEST_F(LogCsv, MistakesInTheseOptionsAreNamed) {
  const auto why = [&](std::vector<std::pair<std::string, ConfigNode>> options) {
    options.emplace_back("format", scalar("csv"));
    options.emplace_back("file", scalar("room.csv"));
    if (std::none_of(options.begin(), options.end(), [](const auto& one) { return one.first == "time"; }))
      options.emplace_back("period", scalar("1s"));
    options.emplace_back("map", map({{"room", map({{"columns", map({{"t", sensor("temperature-1")}})}})}}));
    const auto made = make_log(listener_, map(std::move(options)), types_, directory_);
    return made.errors.empty() ? std::string() : made.errors.front();
  };
  EXPECT_THAT(why({{"zone", scalar("Europe/Nowhere")}}), HasSubstr("no time zone `Europe/Nowhere`"));
  EXPECT_THAT(why({{"decimal", scalar(",")}, {"separators", scalar(",")}}), HasSubstr("the decimal sign too"));
  EXPECT_THAT(why({{"time", map({{"column", scalar("z")}, {"unit", scalar("s")}, {"format", scalar("%H")}})}}),
              HasSubstr("expected `format` or `unit`, not both"));
  EXPECT_EQ(why({{"zone", scalar("Europe/Berlin")}, {"decimal", scalar(",")}}), "");
}

TEST_F(LogCsv, ARowWithoutReadableTimeIsDropped) {
  open("time,t\n0,1\nnoon,2\n,3\n2,4\n", {{"time", map({{"column", scalar("time")}, {"unit", scalar("s")}})}});
  listener_.time.run_for(10s);
  EXPECT_THAT(values(), ElementsAre("1", "4"));
  EXPECT_GE(listener_.counter("damaged"), 2u);
}

TEST_F(LogCsv, RecordedTimesBecomeUserTimes) {
  open("time,t\n2026-03-14T07:00:00Z,1\n2026-03-14T07:00:01Z,2\n",
       {{"time", map({{"column", scalar("time")}, {"unit", scalar("iso")}})}});
  listener_.time.run_for(10s);
  const WallTime seven = std::chrono::sys_days(std::chrono::year(2026) / 3 / 14) + 7h;
  EXPECT_EQ(listener_.readings().at(1).user_time, seven + 1s);
}

TEST_F(LogCsv, AStartTimeMakesRelativeTimesAbsolute) {
  open("t\n1\n2\n", {{"start-time", scalar("2026-03-14T07:00:00Z")}});
  listener_.time.run_for(10s);
  const WallTime seven = std::chrono::sys_days(std::chrono::year(2026) / 3 / 14) + 7h;
  EXPECT_EQ(listener_.readings().at(1).user_time, seven + 1s);
}

TEST_F(LogCsv, AStartTimeWithoutAnOffsetIsOfTheZone) {
  open("t\n1\n", {{"start-time", scalar("2026-03-14T08:00:00")}, {"zone", scalar("Europe/Berlin")}});
  listener_.time.run_for(10s);
  const WallTime seven = std::chrono::sys_days(std::chrono::year(2026) / 3 / 14) + 7h;
  EXPECT_EQ(listener_.readings().at(0).user_time, seven);
}

TEST_F(LogCsv, ScaleOffsetAndWordsTurnCellsIntoValuesOfTheType) {
  listener_.files.files["room.csv"] = "f,door,n\n50,OPEN,6.6\n212,SHUT,7\n";
  open_options(
      map({{"format", scalar("csv")},
           {"file", scalar("room.csv")},
           {"period", scalar("1s")},
           {"map", map({{"room", map({{"columns", map({{"f", map({{"sensor", scalar("temperature-1")},
                                                                  {"scale", scalar("0.5")},
                                                                  {"offset", scalar("-10")}})},
                                                       {"door", map({{"sensor", scalar("contact-1")},
                                                                     {"words", map({{"OPEN", scalar("open")},
                                                                                    {"SHUT", scalar("closed")}})}})},
                                                       {"n", sensor("lightRaw-1")}})}})}})}}));
  listener_.time.run_for(10s);
  EXPECT_THAT(listener_.readings()[1].value, model::Value(true));
  EXPECT_THAT(values(), ElementsAre("15", "on", "7", "96", "off", "7"));
}

TEST_F(LogCsv, TheStartOffsetKeepsJoinAndProperties) {
  listener_.files.files["room.csv"] = "# Task: resting\nt\n1\n2\n3\n";
  open_options(
      map({{"format", scalar("csv")},
           {"file", scalar("room.csv")},
           {"comment", scalar("#")},
           {"period", scalar("1s")},
           {"start", scalar("2s")},
           {"map", map({{"room", map({{"columns", map({{"t", sensor("temperature-1")}})},
                                      {"properties", map({{"activityLabel", map({{"from-comment", scalar("Task")}})},
                                                          {"room", map({{"value", scalar("kitchen")}})}})}})}})}}));
  listener_.time.run_for(0s);
  EXPECT_EQ(listener_.of<model::Join>().size(), 1u);
  EXPECT_THAT(values(), ElementsAre("resting", "kitchen", "3"));
  EXPECT_EQ(listener_.readings()[0].point.kind, Kind::kProperty);
}

TEST_F(LogCsv, ALargeTablePlaysInConstantMemory) {
  std::string content = "t\n";
  for (int i = 0; i < 300'000; ++i) content += "20.5\n";
  open(content, {{"speed", scalar("max")}});
  listener_.time.run_for(1s);
  EXPECT_EQ(listener_.counter("readings"), 300'000u);
  EXPECT_LE(listener_.files.largest_read, 64u * 1024);
}

TEST_F(LogCsv, AsFastAsPossibleLeavesTurnsToOthers) {
  std::string content = "t\n";
  for (int i = 0; i < 10'000; ++i) content += "20.5\n";
  open(content, {{"speed", scalar("max")}});
  std::size_t before = 0;
  std::size_t largest = 0;
  std::function<void()> watch = [&] {
    largest = std::max(largest, listener_.heard.size() - before);
    before = listener_.heard.size();
    if (listener_.last_state().line != model::LineState::kEnded) listener_.time.post(watch);
  };
  listener_.time.post(watch);
  listener_.time.run_for(1ms);
  EXPECT_EQ(listener_.readings().size(), 10'000u);
  EXPECT_LE(largest, 2010u);
}

/// Files in the form of the public data set AReM (log.md 2.1), with the mapping of examples/recordings.yaml.
class AremForm : public LogCsv {
 protected:
  void open_arem(const std::string& file) {
    const auto column = [](const char* name) { return sensor(name); };
    open_options(map(
        {{"format", scalar("csv")},
         {"file", scalar(file)},
         {"comment", scalar("#")},
         {"names-from-comment", scalar("Columns")},
         {"header", scalar("no")},
         {"separators", scalar(", ")},
         {"time", map({{"column", scalar("time")}, {"unit", scalar("ms")}})},
         {"map", map({{"person",
                       map({{"columns", map({{"avg_rss12", column("rssiRaw-12")},
                                             {"var_rss12", column("rssiRawDeviation-12")},
                                             {"avg_rss13", column("rssiRaw-13")},
                                             {"var_rss13", column("rssiRawDeviation-13")},
                                             {"avg_rss23", column("rssiRaw-23")},
                                             {"var_rss23", column("rssiRawDeviation-23")}})},
                            {"properties", map({{"activityLabel", map({{"from-comment", scalar("Task")}})}})}})}})}}));
  }
};

/// 480 invented rows.
TEST_F(AremForm, AFileHas480RowsOfSixSensorsIn120Seconds) {
  auto& text = listener_.files.files["arem.csv"];
  text =
      "# Task: cycling\n# Frequency (Hz): 20\n# Clock (millisecond): 250\n# Duration (seconds): 120\n"
      "# Columns: time,avg_rss12,var_rss12,avg_rss13,var_rss13,avg_rss23,var_rss23\n";
  for (int row = 0; row < 480; ++row)
    text += fmt::format("{},{}.50,4.85,17.50,3.35,22.50,3.20\n", row * 250, 20 + row % 30);
  open_arem("arem.csv");
  const Duration begin = listener_.time.now() - SteadyTime(1h);
  listener_.time.run_for(2min);
  EXPECT_EQ(listener_.counter("records"), 480u);
  EXPECT_EQ(listener_.counter("damaged"), 0u);
  EXPECT_EQ(listener_.readings().size(), 480u * 6 + 1);
  EXPECT_EQ(listener_.of<model::Updates>().back().first - begin, 119'750ms);
  const auto all = values();
  EXPECT_THAT(std::vector<std::string>(all.begin(), all.begin() + 7),
              ElementsAre("cycling", "20.5", "4.85", "17.5", "3.35", "22.5", "3.2"));
  EXPECT_EQ(all[all.size() - 6], fmt::format("{}.5", 20 + 479 % 30));
}

/// The public data sets themselves (log.md 2.1 to 2.3).
class LogDataSets : public AremForm {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(shared_data("datasets/arem")))
      GTEST_SKIP() << "no ../shared/data/datasets beside the source tree";
  }

  void open_movement(const std::string& files) {
    const std::string folder = shared_data("datasets/movementaal/");
    open_options(map(
        {{"format", scalar("csv")},
         {"files", scalar(folder + files)},
         {"period", scalar("125ms")},
         {"map",
          map({{"walker",
                map({{"columns", map({{"RSS_anchor1", sensor("rssiScaled-anchor1")},
                                      {"RSS_anchor2", sensor("rssiScaled-anchor2")},
                                      {"RSS_anchor3", sensor("rssiScaled-anchor3")},
                                      {"RSS_anchor4", sensor("rssiScaled-anchor4")}})},
                     {"properties",
                      map({{"label", map({{"from-table", scalar(folder + "MovementAAL_target.csv")},
                                          {"words", map({{"1", scalar("changes room")}, {"-1", scalar("stays")}})}})},
                           {"group",
                            map({{"from-table", scalar(folder + "MovementAAL_DatasetGroup.csv")}})}})}})}})}}));
  }
};

TEST_F(LogDataSets, AremFilesHave480RowsOfSixSensorsIn120Seconds) {
  for (const std::string activity : {"cycling", "lying", "sitting", "standing", "walking"}) {
    for (const char* number : {"1", "2", "3"}) {
      listener_.heard.clear();
      open_arem(shared_data("datasets/arem/" + activity + "/dataset" + number + ".csv"));
      const Duration begin = listener_.time.now() - SteadyTime(1h);
      listener_.time.run_for(2min);
      EXPECT_EQ(listener_.counter("records"), 480u) << activity << number;
      EXPECT_EQ(listener_.counter("damaged"), 0u) << activity << number;
      EXPECT_EQ(listener_.readings().size(), 480u * 6 + 1) << activity << number;
      EXPECT_EQ(listener_.of<model::Updates>().back().first - begin, 119'750ms) << activity << number;
      EXPECT_EQ(values()[0], activity);
    }
  }
}

TEST_F(LogDataSets, TheFirstRowOfCycling1IsAsWritten) {
  open_arem(shared_data("datasets/arem/cycling/dataset1.csv"));
  listener_.time.run_for(0s);
  EXPECT_THAT(values(), ElementsAre("cycling", "32", "4.85", "17.5", "3.35", "22.5", "3.2"));
}

TEST_F(LogDataSets, MovementFile1Has27RowsIn3250Milliseconds) {
  open_movement("MovementAAL_RSS_1.csv");
  listener_.time.run_for(5s);
  EXPECT_EQ(listener_.counter("records"), 27u);
  EXPECT_EQ(listener_.counter("damaged"), 0u);
  EXPECT_EQ(listener_.of<model::Updates>().back().first, 3250ms);
  const auto all = values();
  EXPECT_THAT(std::vector<std::string>(all.begin(), all.begin() + 6),
              ElementsAre("changes room", "1", "-0.90476", "-0.48", "0.28571", "0.3"));
}

TEST_F(LogDataSets, MovementFilesPlayInNaturalOrderWithTheirLabels) {
  open_movement("MovementAAL_RSS_*.csv");
  listener_.time.run_for(10min);
  EXPECT_EQ(listener_.last_state().line, model::LineState::kEnded);
  std::vector<std::string> labels;
  for (const model::Reading& reading : listener_.readings()) {
    if (reading.point.type == types_.find("label")->id) labels.push_back(model::to_text(reading.value));
  }
  ASSERT_EQ(labels.size(), 40u);
  EXPECT_EQ(std::count(labels.begin(), labels.begin() + 26, "changes room"), 26);
  EXPECT_EQ(std::count(labels.begin() + 26, labels.end(), "stays"), 14);
  EXPECT_EQ(listener_.of<model::Join>().size(), 1u);
}

ConfigNode sensor_in(const char* id, const char* unit) {
  return map({{"sensor", scalar(id)}, {"unit", scalar(unit)}});
}

TEST_F(LogCsv, AnotherUnitBecomesThatOfTheType) {
  listener_.files.files["room.csv"] = "t,p,x\n71.6,1013.25,7\n";
  open_options(map({{"format", scalar("csv")},
                    {"file", scalar("room.csv")},
                    {"period", scalar("1s")},
                    {"map", map({{"room", map({{"columns", map({{"t", sensor_in("temperature-1", "[degF]")},
                                                                {"p", sensor_in("airPressure-1", "hPa")},
                                                                {"x", sensor_in("analogueInput-1", "L/h")}})}})}})}}));
  listener_.time.run_for(500ms);
  EXPECT_THAT(values(), ElementsAre("22", "101325", "7"));
  const auto joins = listener_.of<model::Join>();
  ASSERT_EQ(joins.size(), 1u);
  std::vector<std::string> units;
  for (const auto& one : std::get<model::Join>(joins[0].second.body).capabilities) units.push_back(one.unit);
  EXPECT_THAT(units, ElementsAre("", "", "L/h")) << "a type without a unit takes that of the table";
}

TEST_F(LogCsv, AUnitThatDoesNotConvertIsRefusedWithThoseThatDo) {
  const auto made =
      make_log(listener_,
               map({{"format", scalar("csv")},
                    {"file", scalar("room.csv")},
                    {"period", scalar("1s")},
                    {"map", map({{"room", map({{"columns", map({{"l", sensor_in("light-1", "[degF]")}})}})}})}}),
               types_);
  ASSERT_EQ(made.errors.size(), 1u);
  EXPECT_THAT(
      made.errors[0],
      HasSubstr("map.room.columns.l.unit: `[degF]` does not convert to the unit of light, expected lx or one of "
                "klx, lm/m2"));
}

}  // namespace
}  // namespace rubicon::networks::log
