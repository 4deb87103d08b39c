#include "proxy/device.h"

#include "island.h"

namespace rubicon::proxy {
namespace {

const std::string kRoom = "proxy.hall.7.sensor.glow-1";

Valid between(std::optional<double> minimum, std::optional<double> maximum) {
  Valid rules;
  rules.minimum = minimum;
  rules.maximum = maximum;
  return rules;
}

Valid at_most(double maximum) {
  return between(std::nullopt, maximum);
}

Valid in_steps(double step) {
  Valid rules;
  rules.step = step;
  return rules;
}

Valid rising() {
  Valid rules;
  rules.rises = true;
  return rules;
}

Valid never(std::vector<double> codes) {
  Valid rules;
  rules.never = std::move(codes);
  return rules;
}

class PlausibleValues : public Island {
 protected:
  void begin(Valid valid) {
    rules().devices["7"].valid["glow-1"] = std::move(valid);
    start();
    join("7", lamp());
  }
  void glow(double value) { report("7", sensor(kGlow), value); }
  std::string reason() const { return json(kRoom + ".status")["reason"]; }
  std::string refused() {
    time.run_for(1s);
    return text("proxy.hall.property.implausible-values.value");
  }
};

TEST_F(PlausibleValues, AValueBeyondItsLimitsIsBadAndTheLastGoodOneStays) {
  begin(between(5, 100));
  glow(20);
  glow(4.9);
  EXPECT_EQ(quality(kRoom), "bad");
  EXPECT_EQ(reason(), "4.9 is below the smallest plausible value 5");
  EXPECT_EQ(text(kRoom + ".value"), "20");
  glow(100.5);
  EXPECT_EQ(reason(), "100.5 is above the largest plausible value 100");
  EXPECT_EQ(refused(), "2");
  EXPECT_TRUE(log.contain("glow-1: 4.9 is below"));
  for (const double limit : {5.0, 100.0}) {
    glow(limit);
    EXPECT_EQ(quality(kRoom), "good") << limit;
  }
  EXPECT_EQ(text("proxy.hall.property.bad-values.value"), "0");
}

TEST_F(PlausibleValues, ACodeForNoValueIsBad) {
  begin(never({655.35, 0}));
  for (const double code : {655.35, 0.0}) {
    glow(code);
    EXPECT_EQ(quality(kRoom), "bad") << code;
  }
  glow(655.34);
  EXPECT_EQ(quality(kRoom), "good");
}

TEST_F(PlausibleValues, AJumpIsBelievedAtTheThirdReadingThatAgrees) {
  begin(in_steps(5));
  glow(20);
  glow(60);
  EXPECT_EQ(quality(kRoom), "bad");
  EXPECT_EQ(reason(), "60 differs by more than 5 from 20 before (believed when 3 readings agree, this is number 1)");
  glow(22);
  EXPECT_EQ(quality(kRoom), "good") << "it was a spike";
  glow(27);
  EXPECT_EQ(quality(kRoom), "good") << "exactly a step";
  glow(22);
  for (const double value : {60.0, 90.0, 62.0, 61.0}) {
    glow(value);
    EXPECT_EQ(text(kRoom + ".value"), "22") << value;
  }
  glow(63);
  EXPECT_EQ(text(kRoom + ".value"), "63");
  EXPECT_EQ(quality(kRoom), "good");
  glow(66);
  EXPECT_EQ(text(kRoom + ".value"), "66");
}

TEST_F(PlausibleValues, ACounterThatFallsForAMomentIsNotBelievedAndAReplacedMeterIs) {
  begin(rising());
  glow(500);
  glow(500);
  EXPECT_EQ(quality(kRoom), "good") << "a counter may stand still";
  glow(0);
  EXPECT_EQ(text(kRoom + ".value"), "500");
  glow(501);
  EXPECT_EQ(quality(kRoom), "good");
  for (const double value : {0.0, 0.5}) glow(value);
  EXPECT_EQ(text(kRoom + ".value"), "501");
  glow(1);
  EXPECT_EQ(text(kRoom + ".value"), "1");
}

TEST_F(PlausibleValues, TheFirstValueAndOneAfterALongSilenceHaveNoStep) {
  begin(in_steps(5));
  glow(80);
  EXPECT_EQ(quality(kRoom), "good");
  time.run_for(10min);
  glow(20);
  EXPECT_EQ(quality(kRoom), "good");
  EXPECT_EQ(text(kRoom + ".value"), "20");
}

TEST_F(PlausibleValues, RulesOfATypeHoldForAllDevicesButThoseWithTheirOwn) {
  rules().valid["glow"] = at_most(50);
  rules().devices["7"].valid["glow-2"] = at_most(500);
  start();
  join("7", lamp());
  glow(60);
  report("7", sensor(kGlow, "2"), 60.0);
  EXPECT_EQ(quality(kRoom), "bad");
  EXPECT_EQ(quality("proxy.hall.7.sensor.glow-2"), "good");
}

TEST_F(PlausibleValues, NewRulesApplyAtTheNextReading) {
  begin(at_most(50));
  glow(60);
  EXPECT_EQ(quality(kRoom), "bad");
  auto next = config;
  next.networks["hall"].devices["7"].valid["glow-1"].maximum = 70;
  proxy->reconfigure(next);
  glow(60);
  EXPECT_EQ(quality(kRoom), "good");
  next.networks["hall"].devices.clear();
  proxy->reconfigure(next);
  glow(900);
  EXPECT_EQ(quality(kRoom), "good");
}

TEST_F(PlausibleValues, ARememberedValueOfTheNetworkMustBePlausibleToo) {
  begin(at_most(50));
  say("7", model::Updates{{{sensor(kGlow), 60.0, {}, {}}}, false});
  EXPECT_EQ(text(kRoom + ".value"), "");
}

TEST_F(PlausibleValues, ARuleForAPointThatTheDeviceDoesNotHaveIsNamed) {
  rules().devices["7"].valid["glow-9"] = at_most(50);
  start();
  join("7", lamp());
  EXPECT_TRUE(log.contain("networks.hall.devices.7.valid.glow-9"));
}

/// Of a type of the catalogue.
PointCapability sensor_of(const TypeCatalogue& types, std::string_view type) {
  Capability capability;
  capability.point = {Kind::kSensor, types.find(type)->id, "1"};
  return {capability, types};
}

TEST(Plausibility, KnowsTheCodesOfATypeUnlessTheConfigurationNamesOthers) {
  const TypeCatalogue types;
  const auto power = sensor_of(types, "power");
  NetworkRules network;
  const auto known = rules_of(network, "7", power);
  ASSERT_TRUE(known);
  Plausibility point(std::make_shared<Valid>(*known));
  EXPECT_EQ(point.objection(-8388608.0, {}), "-8388608 is a code for 'no value'");
  EXPECT_EQ(point.objection(-8388607.0, {}), "");
  EXPECT_EQ(point.objection(std::string("off"), {}), "") << "only numbers have limits";
  network.devices["7"].valid["power-1"].never.emplace();
  EXPECT_FALSE(rules_of(network, "7", power));
  EXPECT_TRUE(rules_of(network, "8", power));
  EXPECT_FALSE(rules_of({}, "7", sensor_of(types, "temperature")));
}

TEST(Plausibility, KnowsTheCodesOfATypeBesideTheLimitsOfAPoint) {
  const TypeCatalogue types;
  NetworkRules network;
  network.devices["7"].valid["power-1"] = at_most(4000);
  const auto known = rules_of(network, "7", sensor_of(types, "power"));
  ASSERT_TRUE(known);
  Plausibility point(std::make_shared<Valid>(*known));
  EXPECT_EQ(point.objection(-32768.0, {}), "-32768 is a code for 'no value'");
  EXPECT_EQ(point.objection(4001.0, {}), "4001 is above the largest plausible value 4000");
}

TEST(Plausibility, PointsShareEqualRules) {
  SharedRules rules;
  const auto one = rules.of(at_most(5));
  EXPECT_EQ(rules.of(at_most(5)), one);
  EXPECT_NE(rules.of(at_most(6)), one);
  std::vector<std::shared_ptr<const Valid>> many;
  for (int i = 0; i < 200; ++i) many.push_back(rules.of(at_most(i)));
  for (int i = 0; i < 200; ++i) EXPECT_EQ(many[static_cast<std::size_t>(i)]->maximum, i) << "beyond the bound too";
}

TEST(Plausibility, ACodeMayComeAsANumberOf32Bits) {
  Plausibility point(std::make_shared<Valid>(never({-3276.8})));
  EXPECT_NE(point.objection(static_cast<double>(-3276.8F), {}), "");
  EXPECT_EQ(point.objection(-3276.7, {}), "");
}

}  // namespace
}  // namespace rubicon::proxy
