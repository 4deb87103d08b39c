#include "rubicon/unit.hpp"

#include <gtest/gtest.h>

#include "model/type_catalogue.h"

namespace rubicon::model {
namespace {

TEST(UnitText, IsWhatPeopleWrite) {
  EXPECT_EQ(unit_text("Cel"), "°C");
  EXPECT_EQ(unit_text("[degF]"), "°F");
  EXPECT_EQ(unit_text("lx"), "lx");
  EXPECT_EQ(unit_text("[ppm]"), "ppm");
  EXPECT_EQ(unit_text("%"), "%");
  EXPECT_EQ(unit_text("ug/m3"), "µg/m³");
  EXPECT_EQ(unit_text("W/(m.K)"), "W/(m·K)");
  EXPECT_EQ(unit_text("m/s2"), "m/s²");
  EXPECT_EQ(unit_text("kW.h"), "kWh");
  EXPECT_EQ(unit_text("/min"), "1/min");
  EXPECT_EQ(unit_text("dB[mW]"), "dBm");
}

TEST(UnitText, OneAndNothingAreNoUnit) {
  EXPECT_EQ(unit_text("1"), "");
  EXPECT_EQ(unit_text(""), "");
}

TEST(UnitText, WhatIsNotKnownStaysAsItIs) {
  EXPECT_EQ(unit_text("furlong"), "furlong");
}

TEST(UnitText, NoUnitOfTheCatalogueShowsBracketsOrSpellsOutDegrees) {
  const TypeCatalogue catalogue;
  for (const auto* type : catalogue.all()) {
    const auto text = unit_text(type->unit);
    EXPECT_EQ(text.find_first_of("[]"), text.npos) << type->name << ": " << text;
    EXPECT_EQ(text.find("Cel"), text.npos) << type->name;
  }
}

}  // namespace
}  // namespace rubicon::model
