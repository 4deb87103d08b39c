#include "networks/knx/dpt/catalogue.h"
#include "networks/knx/dpt/records.h"
#include "networks/knx/dpt/set_words.h"
#include "networks/knx/dpt/table.h"

namespace rubicon::networks::knx::dpt {

namespace {

using namespace catalogue;

// main, sub, name, meaning, unit, bits, minimum, maximum, step, sensor, actuator, form, words, record
constexpr Dpt kSetRows[] = {
    row(21, 1, "DPT_StatusGen", "general status", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput, Form::kBits,
        kStatusGenWords),
    row(21, 2, "DPT_Device_Control", "device control", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput, Form::kBits,
        kDeviceControlWords),
    row(21, 100, "DPT_ForceSign", "forcing signal", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput, Form::kBits,
        kForceSignWords),
    row(21, 101, "DPT_ForceSignCool", "forcing signal cool", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput, Form::kBits,
        kForceSignCoolWords),
    row(21, 102, "DPT_StatusRHC", "room heating controller status", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput,
        Form::kBits, kStatusRHCWords),
    row(21, 103, "DPT_StatusSDHWC", "solar DHW controller status", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput,
        Form::kBits, kStatusSDHWCWords),
    row(21, 104, "DPT_FuelTypeSet", "fuel type set", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput, Form::kBits,
        kFuelTypeSetWords),
    row(21, 105, "DPT_StatusRCC", "room cooling controller status", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput,
        Form::kBits, kStatusRCCWords),
    row(21, 106, "DPT_StatusAHU", "ventilation controller status", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput,
        Form::kBits, kStatusAHUWords),
    row(21, 107, "DPT_CombinedStatus_RTSM", "combined status room temperature", "", 8, 0, 0, 0, kBitsetInput,
        kBitsetOutput, Form::kBits, kCombinedStatusRTSMWords),
    row(21, 601, "DPT_LightActuatorErrorInfo", "lighting actuator error information", "", 8, 0, 0, 0, kBitsetInput,
        kBitsetOutput, Form::kBits, kLightActuatorErrorInfoWords),
    row(21, 1000, "DPT_RF_ModeInfo", "RF communication mode info", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput,
        Form::kBits, kRFModeInfoWords),
    row(21, 1001, "DPT_RF_FilterInfo", "supported RF filter modes", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput,
        Form::kBits, kRFFilterInfoWords),
    row(21, 1002, "DPT_Security_Report", "security report", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput, Form::kBits,
        kSecurityReportWords),
    row(21, 1010, "DPT_Channel_Activation_8", "channel activation for 8 channels", "", 8, 0, 0, 0, kBitsetInput,
        kBitsetOutput, Form::kBits, kChannelActivation8Words),
    row(21, 1200, "DPT_VirtualDryContact", "virtual dry contacts", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput,
        Form::kBits, kVirtualDryContactWords),
    row(21, 1201, "DPT_Phases_Status", "mains phases present", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput, Form::kBits,
        kPhasesStatusWords),
    row(22, 100, "DPT_StatusDHWC", "DHW controller status", "", 16, 0, 0, 0, kBitsetInput, kBitsetOutput, Form::kBits,
        kStatusDHWCWords),
    row(22, 101, "DPT_StatusRHCC", "RHCC status", "", 16, 0, 0, 0, kBitsetInput, kBitsetOutput, Form::kBits,
        kStatusRHCCWords),
    row(22, 102, "DPT_CombinedStatus_HVA", "combined status heating valve actuator", "", 16, 0, 0, 0, kBitsetInput,
        kBitsetOutput, Form::kBits, kCombinedStatusHVAWords),
    row(22, 103, "DPT_CombinedStatus_RTC", "combined status room temperature controller", "", 16, 0, 0, 0, kBitsetInput,
        kBitsetOutput, Form::kBits, kCombinedStatusRTCWords),
    row(22, 1000, "DPT_Media", "media", "", 16, 0, 0, 0, kBitsetInput, kBitsetOutput, Form::kBits, kMediaWords),
    row(22, 1010, "DPT_Channel_Activation_16", "channel activation for 16 channels", "", 16, 0, 0, 0, kBitsetInput,
        kBitsetOutput, Form::kBits, kChannelActivation16Words),
    row(23, 1, "DPT_OnOffAction", "on/off action", "", 2, 0, 3, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kOnOffActionWords),
    row(23, 2, "DPT_Alarm_Reaction", "alarm reaction", "", 2, 0, 3, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kAlarmReactionWords),
    row(23, 3, "DPT_UpDown_Action", "up/down action", "", 2, 0, 3, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kUpDownActionWords),
    row(23, 102, "DPT_HVAC_PB_Action", "HVAC push button action", "", 2, 0, 3, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kHVACPBActionWords),
    row(24, 1, "DPT_VarString_8859_1", "text, variable length", "", 0, 0, 255, 0, kText, kText, Form::kLongText),
    row(25, 1000, "DPT_DoubleNibble", "busy/nak repetitions", "", 8, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kRepetitionsRecord),
    row(26, 1, "DPT_SceneInfo", "scene information", "", 8, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kSceneStateRecord),
    row(27, 1, "DPT_CombinedInfoOnOff", "16 outputs on/off with validity", "", 32, 0, 0, 0, kRecord, kRecord,
        Form::kRecord, {}, &kCombinedOnOffRecord),
    row(28, 1, "DPT_UTF-8", "text, variable length", "", 0, 0, 0x10ffff, 0, kText, kText, Form::kLongText),
    row(29, 10, "DPT_ActiveEnergy_V64", "active energy (Wh)", "Wh", 64, -9223372036854775808.0, 9223372036854775808.0,
        1, kEnergy, kEnergy, Form::kSigned),
    row(29, 11, "DPT_ApparentEnergy_V64", "apparent energy (VAh)", "VAh", 64, -9223372036854775808.0,
        9223372036854775808.0, 1, kApparentEnergy, kApparentEnergy, Form::kSigned),
    row(29, 12, "DPT_ReactiveEnergy_V64", "reactive energy (VARh)", "VARh", 64, -9223372036854775808.0,
        9223372036854775808.0, 1, kReactiveEnergy, kReactiveEnergy, Form::kSigned),
    row(30, 1010, "DPT_Channel_Activation_24", "24 channel activation states", "", 24, 0, 0, 0, kBitsetInput,
        kBitsetOutput, Form::kBits, kChannelActivation24Words),
};

}  // namespace

std::span<const Dpt> set_rows() {
  return kSetRows;
}

}  // namespace rubicon::networks::knx::dpt
