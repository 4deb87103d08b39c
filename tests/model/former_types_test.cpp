#include "model/type_names.h"

#include <gmock/gmock.h>

#include <map>

#include "model/cbor_messages.h"
#include "model/units.h"

namespace rubicon::model {
namespace {

using testing::UnorderedElementsAre;

TEST(FormerTypes, AFormerNameOrNumberGivesTheTypeOfToday) {
  const TypeCatalogue types;
  EXPECT_EQ(types.find("illuminance"), types.find("light"));
  EXPECT_EQ(types.find(TypeId{0x0400}), types.find(TypeId{0x0001}));
  EXPECT_EQ(types.find("pir"), types.find("motion"));
  EXPECT_EQ(types.find(TypeId{0x0202}), types.find(TypeId{0x000a}));
  EXPECT_EQ(types.find("light")->id, TypeId{0x0001});
  EXPECT_EQ(types.find("motion")->id, TypeId{0x000a});
}

TEST(FormerTypes, AreNeitherListedNorFreeForASite) {
  TypeCatalogue types;
  for (const auto& former : former_types()) {
    ASSERT_NE(types.find(former.now), nullptr) << former.name;
    EXPECT_EQ(types.find(former.now)->name, former.called);
    for (const auto* type : types.all()) {
      EXPECT_NE(type->name, former.name);
      EXPECT_NE(type->id, former.id);
    }
    SiteType site;
    site.id = 0x8000;
    site.name = former.name;
    EXPECT_FALSE(types.declare(site)) << former.name;
  }
}

TEST(FormerTypes, IdsAndKeysGetTheTypeOfToday) {
  EXPECT_EQ(current_id("illuminance-window"), "light-window");
  EXPECT_EQ(current_id("pir-hall-2"), "motion-hall-2");
  EXPECT_EQ(current_id("illuminance"), "light");
  EXPECT_EQ(current_id("temperature-1"), "temperature-1");
  EXPECT_EQ(current_id(""), "");
  EXPECT_EQ(current_key("proxy.knx-hall.1_4_6.sensor.illuminance-1.value"),
            "proxy.knx-hall.1_4_6.sensor.light-1.value");
  EXPECT_EQ(current_key("*.*.*.sensor.pir-1.**"), "*.*.*.sensor.motion-1.**");
  EXPECT_EQ(current_key("living.illuminance-1"), "living.light-1");
  EXPECT_EQ(current_key("proxy.pir-1.illuminance-2.status"), "proxy.pir-1.illuminance-2.status") << "not ids of points";
  EXPECT_EQ(current_key("proxy.illuminance"), "proxy.illuminance");
  EXPECT_EQ(current_key(""), "");
}

TEST(FormerTypes, APropertyBelongsToThePointOfToday) {
  EXPECT_EQ(current_point({Kind::kSensor, TypeId{0x0400}, "pir-1"}), (PointId{Kind::kSensor, TypeId{1}, "pir-1"}));
  EXPECT_EQ(current_point({Kind::kProperty, TypeId{0x0603}, "pir-1"}),
            (PointId{Kind::kProperty, TypeId{0x0603}, "motion-1"}));
}

TEST(FormerTypes, MessagesOfIslandsThatStillUseThemAreRead) {
  Capability capability;
  capability.point = {Kind::kSensor, TypeId{0x0400}, "window"};
  capability.type_name = "illuminance";
  const auto join = from_cbor(to_cbor(message_with(Join{"", "Sill", "", {capability}, true})));
  ASSERT_TRUE(join);
  const auto& said = std::get<Join>(join->body).capabilities.at(0);
  EXPECT_EQ(said.point, (PointId{Kind::kSensor, TypeId{1}, "window"}));
  EXPECT_EQ(said.type_name, "light");
  const auto updates = from_cbor(to_cbor(message_with(Updates{{{{Kind::kSensor, TypeId{0x0202}, "1"}, true, {}}}})));
  ASSERT_TRUE(updates);
  EXPECT_EQ(std::get<Updates>(updates->body).readings.at(0).point, (PointId{Kind::kSensor, TypeId{10}, "1"}));
  const auto command = from_cbor(to_cbor(message_with(Actuate{1, {Kind::kActuator, TypeId{0x0400}, "1"}, 5.0})));
  ASSERT_TRUE(command);
  EXPECT_EQ(std::get<Actuate>(command->body).point.type, TypeId{1});
}

/// Pairs of names in one line, sorted.
std::vector<std::string> types_that_mean_the_same() {
  const TypeCatalogue types;
  std::vector<std::string> pairs;
  const auto all = types.all();
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      const auto &one = *all[i], &other = *all[j];
      const bool same = one.quantity == other.quantity && one.quantity != "input register" &&
                        one.quantity != "output register" && one.data == other.data && one.report == other.report;
      const bool one_unit = conversion(one.unit, other.unit) || conversion(other.unit, one.unit);
      if (same && one_unit) pairs.push_back(std::string(one.name) + " " + std::string(other.name));
    }
  }
  return pairs;
}

/// Those that stay two (docs/types.md, "Similar types that stay separate"); a new pair has to become one or to be
/// argued there.
TEST(FormerTypes, NoOtherTwoTypesMeanOneQuantityInUnitsThatConvert) {
  EXPECT_THAT(types_that_mean_the_same(),
              UnorderedElementsAre("colourXy colourHueSaturation", "conductivity electricConductivity",
                                   "airPressure pressure", "angle angleRadians", "energy energyJoule",
                                   "duration durationMilliseconds", "percentage fraction"));
}

TEST(Units, BecomeTheUnitOfTheCatalogue) {
  const auto in = [](double value, std::string_view from, std::string_view to) {
    const auto unit = conversion(from, to);
    return unit ? (*unit)(value) : -1e99;
  };
  EXPECT_EQ(in(71.6, "[degF]", "Cel"), 22.0);
  EXPECT_EQ(in(-40, "[degF]", "Cel"), -40.0);
  EXPECT_EQ(in(295.15, "K", "Cel"), 22.0);
  EXPECT_EQ(in(1013.25, "hPa", "Pa"), 101325.0);
  EXPECT_EQ(in(36, "km/h", "m/s"), 10.0);
  EXPECT_EQ(in(7200, "kJ", "kW.h"), 2.0);
  EXPECT_EQ(in(0.45, "1", "%"), 45.0);
  EXPECT_EQ(in(1500, "ms", "s"), 1.5);
  EXPECT_EQ(in(1.2, "klx", "lx"), 1200.0);
  EXPECT_EQ(in(3.14159265358979, "rad", "deg"), 180.0);
  EXPECT_EQ(in(0, "mV", "V"), 0.0);
  EXPECT_EQ(in(5, "lx", "lx"), 5.0);
}

TEST(Units, DoNotConvertWhereItWouldBeAGuess) {
  EXPECT_FALSE(conversion("[degF]", "K")) << "of a difference or of a temperature";
  EXPECT_FALSE(conversion("[degF]", "lx"));
  EXPECT_FALSE(conversion("degF", "Cel")) << "codes are case sensitive and complete";
  EXPECT_FALSE(conversion("", "Cel"));
  EXPECT_EQ(units_of("Cel"), "K, [degF]");
  EXPECT_EQ(units_of("[pH]"), "");
}

TEST(Units, OfTheTableAreThoseOfTheCatalogue) {
  const TypeCatalogue types;
  std::map<std::string, int> targets;
  for (const auto* type : types.all()) targets[std::string(type->unit)] = 1;
  for (const auto* to : {"Cel",  "lx", "%", "[ppm]", "Pa",  "m/s",   "m", "m3", "m3/h", "kg",     "W",
                         "kW.h", "V",  "A", "Hz",    "deg", "rad/s", "s", "ms", "h",    "mm[Hg]", "uS/cm"}) {
    EXPECT_TRUE(targets.contains(to)) << to;
    EXPECT_NE(units_of(to), "") << to;
  }
}

}  // namespace
}  // namespace rubicon::model
