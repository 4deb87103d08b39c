#include "networks/knx/dpt/catalogue.h"
#include "networks/knx/dpt/device_words.h"
#include "networks/knx/dpt/set_words.h"
#include "networks/knx/dpt/table.h"

namespace rubicon::networks::knx::dpt {

namespace {

using namespace catalogue;

// main, sub, name, meaning, unit, bits, minimum, maximum, step, sensor, actuator, form, words, record
constexpr Dpt kDeviceModeRows[] = {
    row(20, 600, "DPT_Behaviour_Lock_Unlock", "behavior lock/unlock", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kBehaviourLockUnlockWords),
    row(20, 601, "DPT_Behaviour_Bus_Power_Up_Down", "behavior bus power up/down", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kBehaviourBusPowerUpDownWords),
    row(20, 602, "DPT_DALI_Fade_Time", "dali fade time", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kDALIFadeTimeWords),
    row(20, 603, "DPT_BlinkingMode", "blink mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kBlinkingModeWords),
    row(20, 604, "DPT_LightControlMode", "light control mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kLightControlModeWords),
    row(20, 605, "DPT_SwitchPBModel", "switch push-button mode", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kSwitchPBModelWords),
    row(20, 606, "DPT_PBAction", "push-button action", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kPBActionWords),
    row(20, 607, "DPT_DimmPBModel", "dimmer push-button mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kDimmPBModelWords),
    row(20, 608, "DPT_SwitchOnMode", "switch on mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kSwitchOnModeWords),
    row(20, 609, "DPT_LoadTypeSet", "load type", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kLoadTypeSetWords),
    row(20, 610, "DPT_LoadTypeDetected", "load type detection", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kLoadTypeDetectedWords),
    row(20, 611, "DPT_Converter_Test_Control", "converter test control", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kConverterTestControlWords),
    row(20, 612, "DPT_Converter_Control", "converter control", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kConverterControlWords),
    row(20, 613, "DPT_Converter_Data_Request", "converter data request", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kConverterDataRequestWords),
    row(20, 801, "DPT_SABExceptBehaviour", "SAB except behavior", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kSABExceptBehaviourWords),
    row(20, 802, "DPT_SABBehaviour_Lock_Unlock", "SAB behavior on lock/unlock", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kSABBehaviourLockUnlockWords),
    row(20, 803, "DPT_SSSBMode", "SSSB mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kSSSBModeWords),
    row(20, 804, "DPT_BlindsControlMode", "blinds control mode", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kBlindsControlModeWords),
    row(20, 1000, "DPT_CommMode", "communication mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kCommModeWords),
    row(20, 1001, "DPT_AddInfoTypes", "additional information type", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kAddInfoTypesWords),
    row(20, 1002, "DPT_RF_ModeSelect", "RF mode selection", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kRFModeSelectWords),
    row(20, 1003, "DPT_RF_FilterSelect", "RF filter mode selection", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kRFFilterSelectWords),
    row(20, 1004, "DPT_Medium", "KNX medium", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kMediumWords),
    row(20, 1005, "DPT_PB_Function", "push-button function", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kPBFunctionWords),
    row(20, 1200, "DPT_MBus_BreakerValve_State", "M-Bus breaker/valve state", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kMBusBreakerValveStateWords),
    row(20, 1202, "DPT_Gas_Measurement_Condition", "gas measurement condition", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kGasMeasurementConditionWords),
    row(20, 1203, "DPT_Breaker_Status", "breaker status", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kBreakerStatusWords),
    row(20, 1204, "DPT_Euridis_Interface_Status", "Euridis interface status", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kEuridisInterfaceStatusWords),
    row(20, 1205, "DPT_PLC_Status", "PLC status", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kPLCStatusWords),
    row(20, 1206, "DPT_Peak_Event_Notice", "peak event notice", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kPeakEventNoticeWords),
    row(20, 1207, "DPT_Peak_Event", "peak event", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kPeakEventWords),
    row(20, 1208, "DPT_TIC_Type", "TIC type", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kTICTypeWords),
    row(20, 1209, "DPT_TIC_Channel_Type", "TIC channel type", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kTICChannelTypeWords),
    row(20, 1219, "DPT_EVSEMode_1", "EV charger: control pilot state", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kEVSEMode1Words),
    row(20, 1220, "DPT_EVSEMode_2", "EV charger: OCPP state", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kEVSEMode2Words),
    row(20, 1221, "DPT_EVSEMode_3", "EV charger: error code", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kEVSEMode3Words),
    row(20, 60102, "(private) HVAC status", "RHCC-like status, eight bits", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput,
        Form::kBits, kPrivatehvacStatusWords),
    row(20, 60104, "(private) HVAC command", "HVAC command", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kPrivatehvacCommandWords),
    row(20, 60105, "(private) heat/cool stage", "enable heat/cool stage (same as 20.116)", "", 8, 0, 255, 1,
        kEnumerationInput, kEnumerationOutput, Form::kEnumeration, kPrivateheatCoolStageWords),
};

}  // namespace

std::span<const Dpt> device_mode_rows() {
  return kDeviceModeRows;
}

}  // namespace rubicon::networks::knx::dpt
