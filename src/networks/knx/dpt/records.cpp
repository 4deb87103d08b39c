#include "networks/knx/dpt/records.h"

#include <array>

#include "networks/knx/dpt/bit_words.h"
#include "networks/knx/dpt/mode_words.h"

namespace rubicon::networks::knx::dpt {

namespace {

constexpr Field flag(std::string_view name, std::uint8_t offset) {
  return {name, offset};
}
constexpr Field inverse(std::string_view name, std::uint8_t offset) {
  return {name, offset, 1, FieldKind::kInverse};
}
constexpr Field number(std::string_view name, std::uint8_t offset, std::uint8_t bits, std::int8_t validity = -1) {
  return {name, offset, bits, FieldKind::kUnsigned, 1, 1, 0, 0, validity};
}
constexpr Field limited(std::string_view name, std::uint8_t offset, std::uint8_t bits, double maximum) {
  return {name, offset, bits, FieldKind::kUnsigned, 1, 1, 0, maximum};
}
constexpr Field scaled(std::string_view name, std::uint8_t offset, std::uint8_t bits, double multiply, double divide,
                       std::int8_t validity = -1) {
  return {name, offset, bits, FieldKind::kUnsigned, multiply, divide, 0, 0, validity};
}
constexpr Field percent(std::string_view name, std::uint8_t offset, std::int8_t validity = -1) {
  return scaled(name, offset, 8, 100, 255, validity);
}
constexpr Field step(std::string_view name, std::uint8_t offset, std::int8_t validity = -1) {
  return {name, offset, 4, FieldKind::kStep, 1, 1, 0, 0, validity};
}
constexpr Field words(std::string_view name, std::uint8_t offset, std::uint8_t bits, std::span<const Word> all) {
  return {name, offset, bits, FieldKind::kWords, 1, 1, 0, 0, -1, all};
}
constexpr Field real(std::string_view name, std::uint8_t offset, FieldKind kind) {
  return {name, offset, static_cast<std::uint8_t>(kind == FieldKind::kFloat16 ? 16 : 32), kind};
}
/// In steps of 0.02 degrees, from -272 on (213.xxx).
constexpr Field fiftieth(std::string_view name, std::uint8_t offset) {
  return {name, offset, 16, FieldKind::kSigned, 1, 50, -272, 655.34};
}

// Main types 2, 3, 6, 15, 18, 25, 26, 27.
constexpr Field kControl[] = {flag("control", 0), flag("value", 1)};
constexpr Word kUpOrDown[] = {{0, "up"}, {1, "down"}};
constexpr Field kBlindStep[] = {words("direction", 0, 1, kUpOrDown), number("code", 1, 3)};
constexpr Field kStatusMode[] = {number("a", 0, 1), number("b", 1, 1), number("c", 2, 1),
                                 number("d", 3, 1), number("e", 4, 1), number("mode", 5, 3)};
constexpr Field kAccess[] = {{"code", 0, 24, FieldKind::kHex}, flag("readError", 24), flag("permission", 25),
                             flag("rightToLeft", 26),          flag("encrypted", 27), number("index", 28, 4)};
constexpr Field kSceneControl[] = {flag("learn", 0), number("scene", 2, 6)};
constexpr Field kRepetitions[] = {limited("busy", 0, 4, 3), limited("nak", 4, 4, 3)};
constexpr Field kSceneState[] = {inverse("active", 1), number("scene", 2, 6)};

// The high 16 bits of 27.001 mark which of the low ones are valid; output 1 is the lowest bit.
constexpr std::string_view kOutputs[] = {"output1",  "output2",  "output3",  "output4",  "output5",  "output6",
                                         "output7",  "output8",  "output9",  "output10", "output11", "output12",
                                         "output13", "output14", "output15", "output16"};
constexpr std::string_view kOutputsValid[] = {"output1Valid",  "output2Valid",  "output3Valid",  "output4Valid",
                                              "output5Valid",  "output6Valid",  "output7Valid",  "output8Valid",
                                              "output9Valid",  "output10Valid", "output11Valid", "output12Valid",
                                              "output13Valid", "output14Valid", "output15Valid", "output16Valid"};
constexpr auto kCombinedOnOff = [] {
  std::array<Field, 16> fields;
  for (std::uint8_t i = 0; i < 16; ++i) {
    fields[i] = flag(kOutputs[i], static_cast<std::uint8_t>(31 - i));
    fields[i].validity = static_cast<std::int8_t>(i);
  }
  return fields;
}();
constexpr auto kCombinedOnOffValid = [] {
  std::array<Validity, 16> validities;
  for (std::uint8_t i = 0; i < 16; ++i) validities[i] = {kOutputsValid[i], static_cast<std::uint8_t>(15 - i)};
  return validities;
}();

// Delay in minutes, then the next mode (206).
constexpr Word kHvacModes[] = {{0, "undefined"}, {1, "comfort"}, {2, "standby"}, {3, "economy"}, {4, "protection"}};
constexpr Word kHotWaterModes[] = {{0, "undefined"}, {1, "legio"}, {2, "normal"}, {3, "reduced"}, {4, "off"}};
constexpr Field kHvacModeNext[] = {number("delay", 0, 16), words("mode", 16, 8, kHvacModes)};
constexpr Field kHotWaterModeNext[] = {number("delay", 0, 16), words("mode", 16, 8, kHotWaterModes)};
constexpr Field kOccupancyModeNext[] = {number("delay", 0, 16), words("mode", 16, 8, kOccModeWords)};
constexpr Field kBuildingModeNext[] = {number("delay", 0, 16), words("mode", 16, 8, kBuildingModeWords)};

constexpr Field kLightingActuator[] = {percent("value", 0, 0), flag("failure", 8),    flag("localOverride", 9),
                                       flag("dimming", 10),    flag("staircase", 11), flag("nightMode", 12),
                                       flag("forced", 13),     flag("locked", 14)};
constexpr Validity kLightingActuatorValid[] = {{"valueValid", 15}};
constexpr Field kSetpoints[] = {fiftieth("comfort", 0), fiftieth("standby", 16), fiftieth("economy", 32),
                                fiftieth("protection", 48)};
constexpr Field kHotWaterSetpoints[] = {fiftieth("legio", 0), fiftieth("normal", 16), fiftieth("reduced", 32),
                                        fiftieth("frost", 48)};
constexpr Field kFourFloatSetpoints[] = {
    real("comfort", 0, FieldKind::kFloat16), real("standby", 16, FieldKind::kFloat16),
    real("economy", 32, FieldKind::kFloat16), real("protection", 48, FieldKind::kFloat16)};
constexpr Field kVersion[] = {number("magic", 0, 5), number("version", 5, 5), number("revision", 10, 6)};
constexpr Word kAlarmPriorities[] = {{0, "high"}, {1, "medium"}, {2, "low"}, {3, "none"}};
constexpr Field kAlarmFields[] = {number("logNumber", 0, 8),
                                  words("priority", 8, 8, kAlarmPriorities),
                                  words("applicationArea", 16, 8, kApplicationAreaWords),
                                  words("errorClass", 24, 8, kErrorClassSystemWords),
                                  flag("errorCodeSupported", 36),
                                  flag("textSupported", 37),
                                  flag("timeStampSupported", 38),
                                  flag("acknowledgeSupported", 39),
                                  flag("locked", 45),
                                  flag("notAcknowledged", 46),
                                  flag("inAlarm", 47)};
constexpr Field kScalingSpeed[] = {scaled("milliseconds", 0, 16, 100, 1), percent("percent", 16)};
// 1 ms as in the master data of ETS; older notes say 100 ms (knx.md 9.9).
constexpr Field kScalingStep[] = {number("milliseconds", 0, 16), percent("percent", 16)};
constexpr Field kNextTariff[] = {number("delay", 0, 16), limited("tariff", 16, 8, 254)};
constexpr Field kMeterAddress[] = {number("manufacturer", 0, 16), number("ident", 16, 32), number("version", 48, 8),
                                   number("medium", 56, 8)};
constexpr Field kTariffEnergy[] = {{"energy", 0, 32, FieldKind::kSigned, 1, 1, 0, 0, 0}, number("tariff", 32, 8, 1)};
constexpr Validity kTariffEnergyValid[] = {{"energyValid", 46, true}, {"tariffValid", 47, true}};
constexpr Field kPrioritisedMode[] = {flag("deactivate", 0), number("level", 1, 3), number("mode", 4, 4)};

// DALI (237, 238, 244 to 246).
constexpr Field kControlGear[] = {flag("converterError", 5), flag("ballastFailure", 6), flag("lampFailure", 7),
                                  flag("read", 8),           flag("groupAddress", 9),   number("address", 10, 6)};
constexpr Field kSceneConfiguration[] = {flag("flag7", 0), flag("flag6", 1), number("scene", 2, 6)};
constexpr Field kDaliDiagnostics[] = {flag("ballastFailure", 0), flag("lampFailure", 1), number("device", 2, 6)};
constexpr Word kPending[] = {{0, "unknown"}, {1, "none"}, {2, "pending"}};
constexpr Word kFailed[] = {{0, "unknown"}, {1, "no"}, {2, "yes"}};
constexpr Word kResults[] = {{0, "unknown"},        {1, "passed in time"}, {2, "passed late"},
                             {3, "failed in time"}, {4, "failed late"},    {5, "stopped"}};
constexpr Word kStarts[] = {{0, "unknown"}, {1, "automatic"}, {2, "gateway"}};
constexpr Field kConverterStatus[] = {number("mode", 0, 4),
                                      flag("hardwiredSwitch", 6),
                                      flag("hardwiredInhibit", 7),
                                      words("functionTest", 8, 2, kPending),
                                      words("durationTest", 10, 2, kPending),
                                      words("partialTest", 12, 2, kPending),
                                      words("failure", 14, 2, kFailed)};
constexpr Field kConverterTest[] = {words("functionTest", 0, 4, kResults),  words("durationTest", 4, 4, kResults),
                                    words("partialTest", 8, 4, kResults),   words("functionStart", 16, 2, kStarts),
                                    words("durationStart", 18, 2, kStarts), words("partialStart", 20, 2, kStarts),
                                    limited("durationResult", 24, 16, 510), number("partialResult", 40, 8)};
constexpr Field kBattery[] = {flag("fullyCharged", 5), flag("durationFailure", 6), flag("failure", 7),
                              number("charge", 8, 8)};

// Blinds (240, 241) and percentages (239).
constexpr Field kFlaggedPercent[] = {percent("value", 0), flag("on", 15)};
constexpr Field kCombinedPosition[] = {percent("height", 0, 0), percent("slats", 8, 1)};
constexpr Validity kCombinedPositionValid[] = {{"heightValid", 23}, {"slatsValid", 22}};
constexpr Field kBlindStatus[] = {percent("height", 0, 0),   percent("slats", 8, 1),    flag("failure", 21),
                                  flag("localOverride", 22), flag("locked", 23),        flag("forced", 24),
                                  flag("weatherAlarm", 25),  flag("slatsLimited", 26),  flag("heightLimited", 27),
                                  flag("targetReached", 28), flag("lowerPosition", 29), flag("lowerEnd", 30),
                                  flag("upperEnd", 31)};
constexpr Validity kBlindStatusValid[] = {{"heightValid", 17}, {"slatsValid", 16}};

// Colours (242 to 254). Transition times are in seconds; 243 has x before y (xknx; Calimero the other way, not in ETS).
constexpr Field kColourXy[] = {scaled("x", 0, 16, 1, 65535, 0), scaled("y", 16, 16, 1, 65535, 0),
                               percent("brightness", 32, 1)};
constexpr Validity kColourXyValid[] = {{"xyValid", 46}, {"brightnessValid", 47}};
constexpr Field kColourXyTransition[] = {scaled("fade", 0, 16, 1, 10), scaled("x", 16, 16, 1, 65535, 0),
                                         scaled("y", 32, 16, 1, 65535, 0), percent("brightness", 48, 1)};
constexpr Validity kColourXyTransitionValid[] = {{"xyValid", 62}, {"brightnessValid", 63}};
constexpr Field kTemperatureTransition[] = {scaled("fade", 0, 16, 1, 10, 0), number("colourTemperature", 16, 16, 1),
                                            percent("brightness", 32, 2)};
constexpr Validity kTemperatureTransitionValid[] = {
    {"fadeValid", 45}, {"colourTemperatureValid", 46}, {"brightnessValid", 47}};
constexpr Field kTemperatureControl[] = {step("colourTemperature", 4, 0), step("brightness", 12, 1)};
constexpr Validity kTemperatureControlValid[] = {{"colourTemperatureValid", 22}, {"brightnessValid", 23}};
constexpr Field kColourRgbw[] = {number("red", 0, 8, 0), number("green", 8, 8, 1), number("blue", 16, 8, 2),
                                 number("white", 24, 8, 3)};
constexpr Validity kColourRgbwValid[] = {{"redValid", 44}, {"greenValid", 45}, {"blueValid", 46}, {"whiteValid", 47}};
constexpr Field kRgbwControl[] = {step("red", 4, 0), step("green", 12, 1), step("blue", 20, 2), step("white", 28, 3)};
constexpr Validity kRgbwControlValid[] = {{"redValid", 36}, {"greenValid", 37}, {"blueValid", 38}, {"whiteValid", 39}};
// xknx: saturation and hue; Calimero: x and y.
constexpr Field kXyControl[] = {step("firstColour", 4, 0), step("secondColour", 12, 1), step("brightness", 20, 2)};
constexpr Validity kXyControlValid[] = {{"firstColourValid", 29}, {"secondColourValid", 30}, {"brightnessValid", 31}};
constexpr Field kRgbControl[] = {step("red", 4), step("green", 12), step("blue", 20)};

constexpr Field kGeographical[] = {real("longitude", 0, FieldKind::kFloat32),
                                   real("latitude", 32, FieldKind::kFloat32)};

}  // namespace

constexpr StructLayout kBlindStepRecord{kBlindStep};
constexpr StructLayout kStatusModeRecord{kStatusMode};
constexpr StructLayout kAccessRecord{kAccess};
constexpr StructLayout kSceneControlRecord{kSceneControl};
constexpr StructLayout kRepetitionsRecord{kRepetitions};
constexpr StructLayout kSceneStateRecord{kSceneState};
constexpr StructLayout kCombinedOnOffRecord{kCombinedOnOff, kCombinedOnOffValid};
constexpr StructLayout kControlRecord{kControl};
constexpr StructLayout kHvacModeNextRecord{kHvacModeNext};
constexpr StructLayout kHotWaterModeNextRecord{kHotWaterModeNext};
constexpr StructLayout kOccupancyModeNextRecord{kOccupancyModeNext};
constexpr StructLayout kBuildingModeNextRecord{kBuildingModeNext};
constexpr StructLayout kLightingActuatorRecord{kLightingActuator, kLightingActuatorValid};
constexpr StructLayout kSetpointsRecord{kSetpoints};
constexpr StructLayout kHotWaterSetpointsRecord{kHotWaterSetpoints};
constexpr StructLayout kVersionRecord{kVersion};
constexpr StructLayout kAlarmRecord{kAlarmFields};
constexpr StructLayout kThreeFloatSetpointsRecord{std::span(kFourFloatSetpoints).first(3)};
constexpr StructLayout kScalingSpeedRecord{kScalingSpeed};
constexpr StructLayout kScalingStepRecord{kScalingStep};
constexpr StructLayout kNextTariffRecord{kNextTariff};
constexpr StructLayout kMeterAddressRecord{kMeterAddress};
constexpr StructLayout kTariffEnergyRecord{kTariffEnergy, kTariffEnergyValid};
constexpr StructLayout kPrioritisedModeRecord{kPrioritisedMode};
constexpr StructLayout kControlGearRecord{kControlGear};
constexpr StructLayout kSceneConfigurationRecord{kSceneConfiguration};
constexpr StructLayout kDaliDiagnosticsRecord{kDaliDiagnostics};
constexpr StructLayout kFlaggedPercentRecord{kFlaggedPercent};
constexpr StructLayout kCombinedPositionRecord{kCombinedPosition, kCombinedPositionValid};
constexpr StructLayout kBlindStatusRecord{kBlindStatus, kBlindStatusValid};
constexpr StructLayout kColourXyRecord{kColourXy, kColourXyValid};
constexpr StructLayout kColourXyTransitionRecord{kColourXyTransition, kColourXyTransitionValid};
constexpr StructLayout kConverterStatusRecord{kConverterStatus};
constexpr StructLayout kConverterTestRecord{kConverterTest};
constexpr StructLayout kBatteryRecord{kBattery};
constexpr StructLayout kTemperatureTransitionRecord{kTemperatureTransition, kTemperatureTransitionValid};
constexpr StructLayout kTemperatureControlRecord{kTemperatureControl, kTemperatureControlValid};
constexpr StructLayout kColourRgbwRecord{kColourRgbw, kColourRgbwValid};
constexpr StructLayout kRgbwControlRecord{kRgbwControl, kRgbwControlValid};
constexpr StructLayout kXyControlRecord{kXyControl, kXyControlValid};
constexpr StructLayout kRgbControlRecord{kRgbControl};
constexpr StructLayout kGeographicalRecord{kGeographical};
constexpr StructLayout kFourFloatSetpointsRecord{kFourFloatSetpoints};

}  // namespace rubicon::networks::knx::dpt
