#include "networks/zigbee/exposes/units.h"

#include <map>

#include "base/text.h"
#include "networks/zigbee/exposes/exposes_support.h"

namespace rubicon::networks::zigbee::exposes {
namespace {

/// How the list of spellings writes the codes that are no UCUM.
std::string ucum(const std::string& canonical) {
  static const std::map<std::string, std::string> kCodes{{"kWh", "kW.h"},   {"VA", "V.A"},      {"kvarh", "kvar.h"},
                                                         {"ppm", "[ppm]"},  {"1/cm3", "/cm3"},  {"1/min", "/min"},
                                                         {"dBm", "dB[mW]"}, {"%LEL", "%{LEL}"}, {"pH", "[pH]"},
                                                         {"month", "mo"},   {"year", "a"}};
  const auto known = kCodes.find(canonical);
  return known == kCodes.end() ? canonical : known->second;
}

struct KnownUnit {
  std::string spelling, code, factor;
};

/// Columns 0, 2 and 4 of ../shared/data/zigbee/units.csv; quantities may be quoted with a comma inside.
std::vector<KnownUnit> spellings_of_the_library() {
  std::ifstream file(RUBICON_SOURCE_DIR "/../shared/data/zigbee/units.csv");
  std::vector<KnownUnit> units;
  std::string line;
  std::getline(file, line);  // the names of the columns
  while (std::getline(file, line)) {
    std::vector<std::string> columns(1);
    bool quoted = false;
    for (const char c : line) {
      if (c == '"')
        quoted = !quoted;
      else if (c == ',' && !quoted)
        columns.emplace_back();
      else if (c != '\r')
        columns.back() += c;
    }
    if (columns.size() >= 5) units.push_back({columns[0], ucum(columns[2]), columns[4]});
  }
  return units;
}

TEST(Units, AllSpellingsOfTheLibraryAreRead) {
  const auto units = spellings_of_the_library();
  if (units.empty()) GTEST_SKIP() << "no ../shared/data/zigbee/units.csv beside the source tree";
  EXPECT_EQ(units.size(), 122U);
  std::size_t unknown = 0;
  for (const auto& [spelling, code, factor] : units) {
    const auto unit = unit_of(spelling, "any");
    if (code == "?") {
      ++unknown;
      EXPECT_FALSE(unit.known) << spelling;
      EXPECT_EQ(unit.code, spelling);
      continue;
    }
    EXPECT_TRUE(unit.known) << spelling;
    EXPECT_EQ(unit.code, code) << spelling;
    const bool fahrenheit = factor.find("32") != factor.npos;
    EXPECT_EQ(unit.shift, fahrenheit ? -32 : 0) << spelling;
    const auto times = base::parse_number<double>(fahrenheit ? "0.5555555555555556" : std::string_view(factor));
    ASSERT_TRUE(times) << factor;
    EXPECT_NEAR(unit.multiply / unit.divide, *times, *times * 1e-9) << spelling;
  }
  EXPECT_EQ(unknown, 4U);
}

TEST(Units, BlanksAroundASpellingDoNotCount) {
  EXPECT_EQ(unit_of("  C", "temperature").code, "Cel");
  EXPECT_EQ(unit_of(" lux ", "illuminance").code, "lx");
  EXPECT_EQ(unit_of("\t", "x").code, "");
  EXPECT_FALSE(unit_of(" LUX", "x").known) << "case counts";
}

TEST(Units, VoltageGoesByUnitNotByName) {
  EXPECT_EQ(unit_of("V", "voltage").divide, 1);
  EXPECT_EQ(unit_of("mV", "voltage").divide, 1000);
}

TEST(Units, AnMIsMinutesWhereTheNameSaysSo) {
  for (const auto* name : {"boost_timeset_countdown", "cooling_delay", "open_window_detection_periode", "alarm_time"}) {
    EXPECT_EQ(unit_of("m", name).code, "s") << name;
    EXPECT_EQ(unit_of("m", name).multiply, 60) << name;
  }
  for (const auto* name : {"target_distance", "installation_height", "detection_range", "liquid_depth_max"})
    EXPECT_EQ(unit_of("m", name).code, "m") << name;
}

TEST(Units, ATemperatureDifferenceHasNoShift) {
  const auto difference = unit_of("°F", "local_temperature_calibration");
  EXPECT_EQ(difference.code, "K");
  EXPECT_EQ(difference.shift, 0);
  EXPECT_EQ(difference.multiply, 5);
  EXPECT_EQ(unit_of("°C", "temperature_hysterersis").code, "K");
  EXPECT_EQ(unit_of("°C", "local_temperature").code, "Cel");
}

TEST(Units, FieldsOfAClockAreNotScaled) {
  EXPECT_EQ(unit_of("Hr", "night_on_backlight", 23).code, "h");
  EXPECT_EQ(unit_of("Hr", "night_on_backlight", 23).multiply, 1);
  EXPECT_EQ(unit_of("hour", "away_preset_hour").code, "h");
  EXPECT_EQ(unit_of("m", "weekdays_p1_minute", 59).code, "min");
  EXPECT_EQ(unit_of("day", "away_preset_day").code, "d");
  EXPECT_EQ(unit_of("month", "month").code, "mo");
  EXPECT_EQ(unit_of("h", "operating_time").multiply, 3600);
  EXPECT_EQ(unit_of("min", "detect_window_time_minute", 1000).multiply, 60) << "a duration, whatever its name";
  EXPECT_EQ(unit_of("Day", "interval_day", 30).multiply, 86400);
}

TEST(Units, UnknownSpellingsAreCounted) {
  const auto definition = map_definition(R"([{"type":"numeric","name":"a","property":"a","access":1,"unit":"gg"},)"
                                         R"({"type":"numeric","name":"b","property":"b","access":1,"unit":"gg"},)"
                                         R"({"type":"numeric","name":"c","property":"c","access":1,"unit":"W"}])");
  EXPECT_EQ(unknown_units(definition.leaves), (std::vector<std::string>{"gg", "gg"}));
  EXPECT_EQ(definition.points[0].capability.unit, "gg");
}

}  // namespace
}  // namespace rubicon::networks::zigbee::exposes
