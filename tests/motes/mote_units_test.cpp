#include "motes/mote_units.h"

#include <gtest/gtest.h>

namespace rubicon::motes {
namespace {

model::Value converted(Transducer transducer, std::uint16_t count, const Calibration& calibration = {},
                       std::optional<double> celsius = std::nullopt) {
  const auto sensors = sensors_of(static_cast<std::uint16_t>(transducer), calibration);
  return convert(sensors.front(), count, calibration, celsius).value_or(model::Value{});
}

TEST(MoteUnits, TemperatureOfTheSht11) {
  EXPECT_EQ(converted(Transducer::kTemperature, 6500), model::Value(25.4));
  Calibration at_five_volts;
  at_five_volts.temperature_at_zero = -40.0;
  EXPECT_EQ(converted(Transducer::kTemperature, 6500, at_five_volts), model::Value(25.0));
}

TEST(MoteUnits, HumidityIsCorrectedByTheTemperature) {
  EXPECT_EQ(converted(Transducer::kHumidity, 1200, {}, 25.0), model::Value(40.57));
  EXPECT_EQ(converted(Transducer::kHumidity, 1200), model::Value(40.57));
  EXPECT_EQ(converted(Transducer::kHumidity, 1200, {}, 30.0), model::Value(41.1));
}

TEST(MoteUnits, HumidityStaysBetweenNothingAndAHundred) {
  EXPECT_EQ(converted(Transducer::kHumidity, 0), model::Value(0.0));
  EXPECT_EQ(converted(Transducer::kHumidity, 4095, {}, 60.0), model::Value(100.0));
}

TEST(MoteUnits, LightOfThePhotodiode) {
  EXPECT_EQ(converted(Transducer::kLight, 300), model::Value(686.6));
}

TEST(MoteUnits, ThermistorOfTheMts300) {
  const Calibration micaz{Board::kMicaz, Units::kPhysical};
  EXPECT_EQ(converted(Transducer::kTemperature, 500, micaz), model::Value(24.03));
  EXPECT_EQ(converted(Transducer::kTemperature, 0, micaz), model::Value{});
  EXPECT_EQ(converted(Transducer::kTemperature, 1023, micaz), model::Value{});
}

TEST(MoteUnits, RawCountsStayCounts) {
  EXPECT_EQ(converted(Transducer::kTemperature, 6500, {Board::kStandard, Units::kRaw}),
            model::Value(std::int64_t{6500}));
  EXPECT_EQ(converted(Transducer::kLight, 300, {Board::kIris, Units::kPhysical}), model::Value(std::int64_t{300}));
}

TEST(MoteUnits, BoardNamesReadBack) {
  for (const Board board : {Board::kStandard, Board::kEm1000, Board::kSe1000, Board::kIris, Board::kMicaz})
    EXPECT_EQ(parse_board(to_string(board)), board);
  EXPECT_EQ(parse_board("em1000"), std::nullopt);
}

}  // namespace
}  // namespace rubicon::motes
