#include "networks/zigbee/exposes/sirens.h"

#include "networks/zigbee/exposes/exposes_support.h"

namespace rubicon::networks::zigbee::exposes {
namespace {

/// The commonest of the 31 definitions with `warning`.
constexpr const char* kWarning =
    R"({"type":"composite","name":"warning","property":"warning","access":2,"features":[
      {"type":"enum","name":"mode","property":"mode","access":2,"values":["stop","burglar","fire","emergency"]},
      {"type":"enum","name":"level","property":"level","access":2,"values":["low","medium","high","very_high"]},
      {"type":"binary","name":"strobe","property":"strobe","access":2,"value_on":true,"value_off":false},
      {"type":"numeric","name":"duration","property":"duration","access":2,"unit":"s"}]})";

const MappedPoint* find(const MappedDefinition& definition, const std::string& type) {
  for (const auto& point : definition.points)
    if (point.capability.type_name == type) return &point;
  return nullptr;
}

TEST(Sirens, AWarningHasAPlainSirenWithItsDurationAndVolume) {
  const auto definition = map_definition(std::string("[") + kWarning + "]");
  EXPECT_EQ(definition.points.size(), 6U) << "with the link quality";
  ASSERT_NE(find(definition, "warning"), nullptr) << "all of it can still be commanded";
  const auto* siren = find(definition, "siren");
  ASSERT_NE(siren, nullptr);
  EXPECT_EQ(siren->capability.point.kind, Kind::kActuator);
  EXPECT_EQ(siren->property, "warning");
  EXPECT_EQ(encode(*siren, Value(true)).value(),
            R"({"duration":1800,"level":"very_high","mode":"emergency","strobe":true})");
  EXPECT_EQ(encode(*siren, Value(false)).value(), R"({"duration":0,"level":"low","mode":"stop","strobe":false})");
  const auto* duration = find(definition, "siren_duration");
  ASSERT_NE(duration, nullptr);
  EXPECT_EQ(duration->capability.point.kind, Kind::kProperty);
  EXPECT_EQ(duration->capability.unit, "s");
  EXPECT_EQ(duration->capability.maximum, 65535);
  EXPECT_EQ(duration->coding.part, "duration");
  EXPECT_FALSE(encode(*duration, Value(70'000.0)));
  const auto* volume = find(definition, "alarmVolume");
  ASSERT_NE(volume, nullptr);
  EXPECT_EQ(volume->coding.part, "level");
  EXPECT_EQ(encode(*volume, Value("medium")).value(), R"("medium")");
  const auto* melody = find(definition, "melody");
  ASSERT_NE(melody, nullptr);
  EXPECT_EQ(melody->coding.part, "mode");
  EXPECT_EQ(encode(*melody, Value("fire")).value(), R"("fire")");
  EXPECT_FALSE(encode(*melody, Value("stop"))) << "that is the siren off";
  expect_sound(definition, "siren");
}

TEST(Sirens, OnlyWhatTheCompositeHas) {
  const auto definition = map_definition(
      R"([{"type":"composite","name":"warning","property":"warning","access":2,"features":[
        {"type":"enum","name":"mode","property":"mode","access":2,"values":["burglar","stop"]},
        {"type":"numeric","name":"duration","property":"duration","access":2,"value_min":1,"value_max":240}]}])");
  EXPECT_EQ(find(definition, "alarmVolume"), nullptr);
  EXPECT_EQ(encode(*find(definition, "siren"), Value(true)).value(), R"({"duration":240,"mode":"burglar"})");
  EXPECT_EQ(encode(*find(definition, "siren"), Value(false)).value(), R"({"duration":1,"mode":"stop"})");
}

TEST(Sirens, ALoudnessInNumbersIsAShareOfTheLoudest) {
  const auto in_levels = map_definition(
      R"([{"type":"numeric","name":"volume","property":"volume","access":7,"value_min":0,"value_max":50}])");
  const auto* volume = find(in_levels, "volume");
  ASSERT_NE(volume, nullptr);
  EXPECT_EQ(encode(*volume, Value(60.0)).value(), "30");
  const auto in_percent =
      map_definition(R"([{"type":"numeric","name":"alarm_volume","property":"alarm_volume","access":7,"unit":"%"}])");
  ASSERT_NE(find(in_percent, "volume"), nullptr);
  EXPECT_EQ(encode(*find(in_percent, "volume"), Value(60.0)).value(), "60");
}

TEST(Sirens, OtherCompositesAreNone) {
  for (const auto* other : {R"([{"type":"composite","name":"a","property":"a","access":2,"features":[]}])",
                            R"([{"type":"composite","name":"a","property":"a","access":1,"features":[
          {"type":"enum","name":"mode","property":"mode","access":2,"values":["stop","fire"]}]}])",
                            R"([{"type":"composite","name":"a","property":"a","access":3,"features":[
          {"type":"enum","name":"mode","property":"mode","access":2,"values":["stop"]}]}])",
                            R"([{"type":"composite","name":"a","property":"a","access":3,"features":[
          {"type":"enum","name":"mode","property":"mode","access":2,"values":["day","night"]}]}])"})
    EXPECT_EQ(map_definition(other).points.size(), 2U) << other;
}

TEST(Sirens, PartsReplaceThoseOfACommand) {
  EXPECT_EQ(with_parts(R"({"mode":"fire","duration":1800})", {{"duration", "5"}, {"level", R"("low")"}}),
            R"({"duration":5,"level":"low","mode":"fire"})");
}

}  // namespace
}  // namespace rubicon::networks::zigbee::exposes
