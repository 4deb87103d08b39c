#include "networks/knx/dpt/bit_words.h"
#include "networks/knx/dpt/records.h"
#include "networks/knx/dpt/table.h"

namespace rubicon::networks::knx::dpt {

namespace {

using namespace catalogue;

// main, sub, name, meaning, unit, bits, minimum, maximum, step, sensor, actuator, form, words, record
constexpr Dpt kRecordRows[] = {
    row(206, 100, "DPT_HVACModeNext", "delay + HVAC mode", "", 24, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kHvacModeNextRecord),
    row(206, 102, "DPT_DHWModeNext", "delay + DHW mode", "", 24, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kHotWaterModeNextRecord),
    row(206, 104, "DPT_OccModeNext", "delay + occupancy mode", "", 24, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kOccupancyModeNextRecord),
    row(206, 105, "DPT_BuildingModeNext", "delay + building mode", "", 24, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kBuildingModeNextRecord),
    row(207, 600, "DPT_StatusLightingActuator", "lighting actuator status", "", 16, 0, 0, 0, kRecord, kRecord,
        Form::kRecord, {}, &kLightingActuatorRecord),
    row(213, 100, "DPT_TempRoomSetpSet[4]", "room setpoints comfort/standby/economy/protection", "", 64, 0, 0, 0,
        kRecord, kRecord, Form::kRecord, {}, &kSetpointsRecord),
    row(213, 101, "DPT_TempDHWSetpSet[4]", "DHW setpoints legio/normal/reduced/frost", "", 64, 0, 0, 0, kRecord,
        kRecord, Form::kRecord, {}, &kHotWaterSetpointsRecord),
    row(213, 102, "DPT_TempRoomSetpSetShift[4]", "room setpoint shifts", "", 64, 0, 0, 0, kRecord, kRecord,
        Form::kRecord, {}, &kSetpointsRecord),
    row(217, 1, "DPT_Version", "DPT version", "", 16, 0, 0, 0, kRecord, kRecord, Form::kRecord, {}, &kVersionRecord),
    row(219, 1, "DPT_AlarmInfo", "alarm info", "", 48, 0, 0, 0, kRecord, kRecord, Form::kRecord, {}, &kAlarmRecord),
    row(221, 1, "DPT_SerNum", "serial number", "", 48, 0, 0, 0, kSerialNumber, kSerialNumber, Form::kSerial),
    row(222, 100, "DPT_TempRoomSetpSetF16[3]", "three room setpoints", "", 48, 0, 0, 0, kRecord, kRecord, Form::kRecord,
        {}, &kThreeFloatSetpointsRecord),
    row(222, 101, "DPT_TempRoomSetpSetShiftF16[3]", "three room setpoint shifts", "", 48, 0, 0, 0, kRecord, kRecord,
        Form::kRecord, {}, &kThreeFloatSetpointsRecord),
    row(225, 1, "DPT_ScalingSpeed", "scaling speed", "", 24, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kScalingSpeedRecord),
    row(225, 2, "DPT_Scaling_Step_Time", "scaling step time", "", 24, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kScalingStepRecord),
    row(225, 3, "DPT_NextTariff", "next tariff after delay", "", 24, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kNextTariffRecord),
    row(229, 1, "DPT_MeteringValue", "metering value with M-Bus unit code", "", 48, 0, 0, 0, kRecord, kRecord,
        Form::kMetering, kStatusGenWords),
    row(230, 1000, "DPT_MBus_Address", "M-Bus address", "", 64, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kMeterAddressRecord),
    row(231, 1, "DPT_Locale_ASCII", "language + region code", "", 32, 0, 0, 0, kText, kText, Form::kLetters),
    row(232, 600, "DPT_Colour_RGB", "colour RGB", "", 24, 0, 0, 0, kColourRgb, kColourRgb, Form::kColour),
    row(234, 1, "DPT_LanguageCodeAlpha2_ASCII", "language code ISO 639-1", "", 16, 0, 0, 0, kText, kText,
        Form::kLetters),
    row(234, 2, "DPT_RegionCodeAlpha2_ASCII", "region code ISO 3166-1", "", 16, 0, 0, 0, kText, kText, Form::kLetters),
    row(235, 1, "DPT_Tariff_ActiveEnergy", "electrical energy with tariff", "", 48, 0, 0, 0, kRecord, kRecord,
        Form::kRecord, {}, &kTariffEnergyRecord),
    row(236, 1, "DPT_Prioritised_Mode_Control", "prioritised mode control", "", 8, 0, 0, 0, kRecord, kRecord,
        Form::kRecord, {}, &kPrioritisedModeRecord),
    row(237, 600, "DPT_DALI_Control_Gear_Diagnostic", "DALI control gear diagnostic", "", 16, 0, 0, 0, kRecord, kRecord,
        Form::kRecord, {}, &kControlGearRecord),
    row(238, 1, "DPT_SceneConfig", "scene configuration", "", 8, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kSceneConfigurationRecord),
    row(238, 600, "DPT_DALI_Diagnostics", "DALI diagnostic", "", 8, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kDaliDiagnosticsRecord),
    row(239, 1, "DPT_FlaggedScaling", "percentage with on flag", "", 16, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kFlaggedPercentRecord),
    row(240, 800, "DPT_CombinedPosition", "blind height + slat position", "", 24, 0, 0, 0, kRecord, kRecord,
        Form::kRecord, {}, &kCombinedPositionRecord),
    row(241, 800, "DPT_StatusSAB", "sunblind and shutter actuator status", "", 32, 0, 0, 0, kRecord, kRecord,
        Form::kRecord, {}, &kBlindStatusRecord),
    row(242, 600, "DPT_Colour_xyY", "colour xyY", "", 48, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kColourXyRecord),
    row(243, 600, "DPT_Colour_Transition_xyY", "colour xyY with fading time", "", 64, 0, 0, 0, kRecord, kRecord,
        Form::kRecord, {}, &kColourXyTransitionRecord),
    row(244, 600, "DPT_Converter_Status", "DALI converter status", "", 16, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kConverterStatusRecord),
    row(245, 600, "DPT_Converter_Test_Result", "DALI converter test result", "", 48, 0, 0, 0, kRecord, kRecord,
        Form::kRecord, {}, &kConverterTestRecord),
    row(246, 600, "DPT_Battery_Info", "battery information", "", 16, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kBatteryRecord),
    row(249, 600, "DPT_Brightness_Colour_Temperature_Transition", "brightness + colour temperature with fading time",
        "", 48, 0, 0, 0, kRecord, kRecord, Form::kRecord, {}, &kTemperatureTransitionRecord),
    row(250, 600, "DPT_Brightness_Colour_Temperature_Control", "relative brightness + colour temperature", "", 24, 0, 0,
        0, kRecord, kRecord, Form::kRecord, {}, &kTemperatureControlRecord),
    row(251, 600, "DPT_Colour_RGBW", "colour RGBW", "", 48, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kColourRgbwRecord),
    row(252, 600, "DPT_Relative_Control_RGBW", "relative control RGBW", "", 40, 0, 0, 0, kRecord, kRecord,
        Form::kRecord, {}, &kRgbwControlRecord),
    row(253, 600, "DPT_Relative_Control_xyY", "relative control of colour and brightness", "", 32, 0, 0, 0, kRecord,
        kRecord, Form::kRecord, {}, &kXyControlRecord),
    row(254, 600, "DPT_Relative_Control_RGB", "relative control RGB", "", 24, 0, 0, 0, kRecord, kRecord, Form::kRecord,
        {}, &kRgbControlRecord),
    row(255, 1, "DPT_GeographicalLocation", "longitude + latitude, degrees", "", 64, 0, 0, 0, kPosition, kPosition,
        Form::kRecord, {}, &kGeographicalRecord),
    row(275, 100, "DPT_TempRoomSetpSetF16[4]", "four HVAC setpoints", "", 64, 0, 0, 0, kRecord, kRecord, Form::kRecord,
        {}, &kFourFloatSetpointsRecord),
    row(275, 101, "DPT_TempRoomSetpSetShiftF16[4]", "four HVAC setpoint shifts", "", 64, 0, 0, 0, kRecord, kRecord,
        Form::kRecord, {}, &kFourFloatSetpointsRecord),
    row(285, 1, "DPT_ipv6", "IPv6 address", "", 128, 0, 0, 0, kText, kText, Form::kIpv6),
};

}  // namespace

std::span<const Dpt> record_rows() {
  return kRecordRows;
}

}  // namespace rubicon::networks::knx::dpt
