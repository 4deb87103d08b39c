#pragma once

#include <span>

#include "model/type_catalogue.h"
#include "networks/knx/dpt/dpt.h"

namespace rubicon::networks::knx::dpt::catalogue {

// The types of the catalogue that data point types become (docs/types.md; tests/cases/types/knx_dpt.tsv).

inline constexpr TypeId kLight{0x0001};
inline constexpr TypeId kTemperature{0x0002};
inline constexpr TypeId kHumidity{0x0003};
inline constexpr TypeId kUnsigned4BitInput{0x0104};
inline constexpr TypeId kUnsigned8BitInput{0x0105};
inline constexpr TypeId kUnsigned16BitInput{0x0106};
inline constexpr TypeId kUnsigned32BitInput{0x0108};
inline constexpr TypeId kSigned8BitInput{0x010a};
inline constexpr TypeId kSigned16BitInput{0x010b};
inline constexpr TypeId kSigned32BitInput{0x010c};
inline constexpr TypeId kSigned64BitInput{0x010d};
inline constexpr TypeId kFloat16BitInput{0x010e};
inline constexpr TypeId kFloat32BitInput{0x010f};
inline constexpr TypeId kEnumerationInput{0x0113};
inline constexpr TypeId kBitsetInput{0x0114};
inline constexpr TypeId kUnsigned4BitOutput{0x0144};
inline constexpr TypeId kUnsigned8BitOutput{0x0145};
inline constexpr TypeId kUnsigned16BitOutput{0x0146};
inline constexpr TypeId kUnsigned32BitOutput{0x0148};
inline constexpr TypeId kSigned8BitOutput{0x014a};
inline constexpr TypeId kSigned16BitOutput{0x014b};
inline constexpr TypeId kSigned32BitOutput{0x014c};
inline constexpr TypeId kSigned64BitOutput{0x014d};
inline constexpr TypeId kFloat16BitOutput{0x014e};
inline constexpr TypeId kFloat32BitOutput{0x014f};
inline constexpr TypeId kEnumerationOutput{0x0153};
inline constexpr TypeId kBitsetOutput{0x0154};
inline constexpr TypeId kSwitch{0x0200};
inline constexpr TypeId kContact{0x0201};
inline constexpr TypeId kOccupancy{0x0203};
inline constexpr TypeId kAlarm{0x020a};
inline constexpr TypeId kColourTemperature{0x021c};
inline constexpr TypeId kColourRgb{0x021e};
inline constexpr TypeId kDimStep{0x0223};
inline constexpr TypeId kHvacMode{0x0234};
inline constexpr TypeId kFanStage{0x0238};
inline constexpr TypeId kScene{0x023c};
inline constexpr TypeId kTrigger{0x0241};
inline constexpr TypeId kDayNight{0x024a};
inline constexpr TypeId kHeatCool{0x024b};
inline constexpr TypeId kEnable{0x024c};
inline constexpr TypeId kUpDown{0x024d};
inline constexpr TypeId kOpenClose{0x024e};
inline constexpr TypeId kStartStop{0x024f};
inline constexpr TypeId kInversion{0x0250};
inline constexpr TypeId kBuildingMode{0x0251};
inline constexpr TypeId kOccupancyMode{0x0252};
inline constexpr TypeId kTariff{0x0258};
inline constexpr TypeId kLuminance{0x0401};
inline constexpr TypeId kLuminousFlux{0x0402};
inline constexpr TypeId kLuminousIntensity{0x0403};
inline constexpr TypeId kLightQuantity{0x0404};
inline constexpr TypeId kTemperatureDifference{0x0408};
inline constexpr TypeId kTemperatureGradient{0x0409};
inline constexpr TypeId kAbsoluteTemperature{0x040a};
inline constexpr TypeId kAbsoluteHumidity{0x040b};
inline constexpr TypeId kConcentration{0x0416};
inline constexpr TypeId kMassConcentration{0x0417};
inline constexpr TypeId kActivity{0x041b};
inline constexpr TypeId kPressure{0x0420};
inline constexpr TypeId kWindSpeed{0x0422};
inline constexpr TypeId kWindForce{0x0424};
inline constexpr TypeId kRainAmount{0x0426};
inline constexpr TypeId kCloudCover{0x0427};
inline constexpr TypeId kSpeed{0x0428};
inline constexpr TypeId kAcceleration{0x0429};
inline constexpr TypeId kAngularAcceleration{0x042a};
inline constexpr TypeId kAngularVelocity{0x042b};
inline constexpr TypeId kAngularMomentum{0x042c};
inline constexpr TypeId kAngle{0x042d};
inline constexpr TypeId kAngleRadians{0x042e};
inline constexpr TypeId kSolidAngle{0x042f};
inline constexpr TypeId kLength{0x0430};
inline constexpr TypeId kArea{0x0432};
inline constexpr TypeId kVolumeContent{0x0433};
inline constexpr TypeId kMass{0x0436};
inline constexpr TypeId kMassFlow{0x0437};
inline constexpr TypeId kVolumeFlow{0x0438};
inline constexpr TypeId kDensity{0x043c};
inline constexpr TypeId kForce{0x043d};
inline constexpr TypeId kTorque{0x043e};
inline constexpr TypeId kMomentum{0x043f};
inline constexpr TypeId kStress{0x0440};
inline constexpr TypeId kSurfaceTension{0x0441};
inline constexpr TypeId kCompressibility{0x0442};
inline constexpr TypeId kPower{0x0443};
inline constexpr TypeId kApparentPower{0x0444};
inline constexpr TypeId kPowerFactor{0x0446};
inline constexpr TypeId kPowerDensity{0x0447};
inline constexpr TypeId kEnergy{0x0448};
inline constexpr TypeId kApparentEnergy{0x0449};
inline constexpr TypeId kReactiveEnergy{0x044a};
inline constexpr TypeId kEnergyJoule{0x044b};
inline constexpr TypeId kVoltage{0x044c};
inline constexpr TypeId kCurrent{0x044d};
inline constexpr TypeId kCurrentDensity{0x044e};
inline constexpr TypeId kFrequency{0x044f};
inline constexpr TypeId kAngularFrequency{0x0450};
inline constexpr TypeId kResistance{0x0451};
inline constexpr TypeId kImpedance{0x0452};
inline constexpr TypeId kResistivity{0x0453};
inline constexpr TypeId kConductance{0x0454};
inline constexpr TypeId kElectricConductivity{0x0455};
inline constexpr TypeId kCapacitance{0x0456};
inline constexpr TypeId kInductance{0x0457};
inline constexpr TypeId kCharge{0x0458};
inline constexpr TypeId kSurfaceCharge{0x0459};
inline constexpr TypeId kSpaceCharge{0x045a};
inline constexpr TypeId kDipoleMoment{0x045b};
inline constexpr TypeId kElectricField{0x045c};
inline constexpr TypeId kMagneticField{0x045d};
inline constexpr TypeId kMagneticFlux{0x045e};
inline constexpr TypeId kMagneticFluxDensity{0x045f};
inline constexpr TypeId kMagneticMoment{0x0460};
inline constexpr TypeId kMagnetomotiveForce{0x0461};
inline constexpr TypeId kHeatCapacity{0x0462};
inline constexpr TypeId kHeatFlow{0x0463};
inline constexpr TypeId kThermalConductivity{0x0464};
inline constexpr TypeId kThermoelectricPower{0x0465};
inline constexpr TypeId kAmountOfSubstance{0x0466};
inline constexpr TypeId kActivationEnergy{0x0467};
inline constexpr TypeId kAmplitude{0x0468};
inline constexpr TypeId kSoundIntensity{0x046a};
inline constexpr TypeId kDuration{0x046d};
inline constexpr TypeId kOperatingHours{0x046f};
inline constexpr TypeId kTimeOfDay{0x0471};
inline constexpr TypeId kDate{0x0472};
inline constexpr TypeId kDateTime{0x0473};
inline constexpr TypeId kCounter{0x0476};
inline constexpr TypeId kPulseCount{0x0477};
inline constexpr TypeId kPercentage{0x047a};
inline constexpr TypeId kFactor{0x047b};
inline constexpr TypeId kText{0x047d};
inline constexpr TypeId kRecord{0x047e};
inline constexpr TypeId kPosition{0x047f};
inline constexpr TypeId kBinaryState{0x0488};
inline constexpr TypeId kSerialNumber{0x060d};

}  // namespace rubicon::networks::knx::dpt::catalogue

namespace rubicon::networks::knx::dpt {

/// One row; the order is that of Dpt.
constexpr Dpt row(std::uint16_t main, std::uint16_t sub, std::string_view name, std::string_view meaning,
                  std::string_view unit, std::uint16_t bits, double minimum, double maximum, double step, TypeId sensor,
                  TypeId actuator, Form form, std::span<const Word> words = {}, const StructLayout* record = nullptr) {
  return {{main, sub}, name, meaning, unit, bits, minimum, maximum, step, sensor, actuator, form, words, record};
}

/// 7FFE; 7FFF means "invalid" (KNX 3/7/2, DPT 9).
inline constexpr double kFloat16Maximum = 670433.28;
inline constexpr double kFloat16Minimum = -671088.64;
/// As the table has it: a little above the largest single, which it rounds to.
inline constexpr double kFloat32Maximum = 3.4028235e38;

/// Rows of one shape: a switch, a number of 32 bits, a single, and a list of words in one byte.
constexpr Dpt bit(std::uint16_t main, std::uint16_t sub, std::string_view name, std::string_view meaning, TypeId type,
                  std::span<const Word> words) {
  return row(main, sub, name, meaning, "", 1, 0, 1, 1, type, type, Form::kBit, words);
}

constexpr Dpt unsigned32(std::uint16_t main, std::uint16_t sub, std::string_view name, std::string_view meaning,
                         std::string_view unit, TypeId type) {
  return row(main, sub, name, meaning, unit, 32, 0, 4294967295, 1, type, type, Form::kUnsigned);
}

constexpr Dpt signed32(std::uint16_t main, std::uint16_t sub, std::string_view name, std::string_view meaning,
                       std::string_view unit, TypeId type) {
  return row(main, sub, name, meaning, unit, 32, -2147483648, 2147483647, 1, type, type, Form::kSigned);
}

constexpr Dpt real32(std::uint16_t main, std::uint16_t sub, std::string_view name, std::string_view meaning,
                     std::string_view unit, TypeId type) {
  return row(main, sub, name, meaning, unit, 32, -kFloat32Maximum, kFloat32Maximum, 0, type, type, Form::kFloat32);
}

constexpr Dpt enumeration(std::uint16_t main, std::uint16_t sub, std::string_view name, std::string_view meaning,
                          std::span<const Word> words, TypeId sensor, TypeId actuator) {
  return row(main, sub, name, meaning, "", 8, 0, 255, 1, sensor, actuator, Form::kEnumeration, words);
}

constexpr Dpt enumeration(std::uint16_t main, std::uint16_t sub, std::string_view name, std::string_view meaning,
                          std::span<const Word> words, TypeId type) {
  return enumeration(main, sub, name, meaning, words, type, type);
}

constexpr Dpt enumeration(std::uint16_t main, std::uint16_t sub, std::string_view name, std::string_view meaning,
                          std::span<const Word> words) {
  return enumeration(main, sub, name, meaning, words, catalogue::kEnumerationInput, catalogue::kEnumerationOutput);
}

/// The rows of the table, by main type; each sorted by id.
std::span<const Dpt> control_rows();      ///< 1 to 8
std::span<const Dpt> float_rows();        ///< 9 to 14
std::span<const Dpt> text_rows();         ///< 15 to 19
std::span<const Dpt> system_mode_rows();  ///< 20 below 600
std::span<const Dpt> device_mode_rows();  ///< 20 from 600 on
std::span<const Dpt> set_rows();          ///< 21 to 30
std::span<const Dpt> record_rows();       ///< 206 and up
/// The fallbacks for sub types that are not in the table, one for each main type.
std::span<const Dpt> main_rows();

}  // namespace rubicon::networks::knx::dpt
