#include "networks/knx/dpt/bit_words.h"
#include "networks/knx/dpt/mode_words.h"
#include "networks/knx/dpt/table.h"

namespace rubicon::networks::knx::dpt {

namespace {

using namespace catalogue;

// main, sub, name, meaning, unit, bits, minimum, maximum, step, sensor, actuator, form, words, record
constexpr Dpt kSystemModeRows[] = {
    enumeration(20, 1, "DPT_SCLOMode", "system clock mode", kSCLOModeWords),
    enumeration(20, 2, "DPT_BuildingMode", "building mode", kBuildingModeWords, kBuildingMode),
    enumeration(20, 3, "DPT_OccMode", "occupancy mode", kOccModeWords, kOccupancyMode),
    enumeration(20, 4, "DPT_Priority", "priority", kPriorityWords),
    enumeration(20, 5, "DPT_LightApplicationMode", "light application mode", kLightApplicationModeWords),
    enumeration(20, 6, "DPT_ApplicationArea", "application area", kApplicationAreaWords),
    enumeration(20, 7, "DPT_AlarmClassType", "alarm class", kAlarmClassTypeWords),
    enumeration(20, 8, "DPT_PSUMode", "PSU mode", kPSUModeWords),
    enumeration(20, 11, "DPT_ErrorClass_System", "system error class", kErrorClassSystemWords),
    enumeration(20, 12, "DPT_ErrorClass_HVAC", "HVAC error class", kErrorClassHVACWords),
    enumeration(20, 13, "DPT_Time_Delay", "time delay", kTimeDelayWords),
    enumeration(20, 14, "DPT_Beaufort_Wind_Force_Scale", "wind force scale (0..12)", kBeaufortWindForceScaleWords,
                kWindForce),
    enumeration(20, 17, "DPT_SensorSelect", "sensor selection", kSensorSelectWords),
    enumeration(20, 20, "DPT_ActuatorConnectType", "actuator connect type", kActuatorConnectTypeWords),
    enumeration(20, 21, "DPT_Cloud_Cover", "cloud cover", kCloudCoverWords, kCloudCover),
    enumeration(20, 22, "DPT_PowerReturnMode", "power return mode", kPowerReturnModeWords),
    enumeration(20, 100, "DPT_FuelType", "fuel type", kFuelTypeWords),
    enumeration(20, 101, "DPT_BurnerType", "burner type", kBurnerTypeWords),
    enumeration(20, 102, "DPT_HVACMode", "HVAC mode", kHVACModeWords, kHvacMode),
    enumeration(20, 103, "DPT_DHWMode", "DHW mode", kDHWModeWords),
    enumeration(20, 104, "DPT_LoadPriority", "load priority", kLoadPriorityWords),
    enumeration(20, 105, "DPT_HVACContrMode", "HVAC control mode", kHVACContrModeWords),
    enumeration(20, 106, "DPT_HVACEmergMode", "HVAC emergency mode", kHVACEmergModeWords),
    enumeration(20, 107, "DPT_ChangeoverMode", "changeover mode", kChangeoverModeWords),
    enumeration(20, 108, "DPT_ValveMode", "valve mode", kValveModeWords),
    enumeration(20, 109, "DPT_DamperMode", "damper mode", kDamperModeWords),
    enumeration(20, 110, "DPT_HeaterMode", "heater mode", kHeaterModeWords),
    enumeration(20, 111, "DPT_FanMode", "fan mode", kFanModeWords),
    enumeration(20, 112, "DPT_MasterSlaveMode", "master/slave mode", kMasterSlaveModeWords),
    enumeration(20, 113, "DPT_StatusRoomSetp", "status room setpoint", kStatusRoomSetpWords),
    enumeration(20, 114, "DPT_Metering_DeviceType", "metering device type", kMeteringDeviceTypeWords),
    enumeration(20, 115, "DPT_HumDehumMode", "humidify/dehumidify mode", kHumDehumModeWords),
    enumeration(20, 116, "DPT_EnableHCStage", "enable heat/cool stages", kEnableHCStageWords),
    enumeration(20, 120, "DPT_ADAType", "air damper actuator type", kADATypeWords),
    enumeration(20, 121, "DPT_BackupMode", "backup mode", kBackupModeWords),
    enumeration(20, 122, "DPT_StartSynchronization", "start synchronization", kStartSynchronizationWords),
};

}  // namespace

std::span<const Dpt> system_mode_rows() {
  return kSystemModeRows;
}

namespace {

// main, sub, name, meaning, unit, bits, minimum, maximum, step, sensor, actuator, form, words, record
constexpr Dpt kDeviceModeRows[] = {
    enumeration(20, 600, "DPT_Behaviour_Lock_Unlock", "behavior lock/unlock", kBehaviourLockUnlockWords),
    enumeration(20, 601, "DPT_Behaviour_Bus_Power_Up_Down", "behavior bus power up/down",
                kBehaviourBusPowerUpDownWords),
    enumeration(20, 602, "DPT_DALI_Fade_Time", "dali fade time", kDALIFadeTimeWords),
    enumeration(20, 603, "DPT_BlinkingMode", "blink mode", kBlinkingModeWords),
    enumeration(20, 604, "DPT_LightControlMode", "light control mode", kLightControlModeWords),
    enumeration(20, 605, "DPT_SwitchPBModel", "switch push-button mode", kSwitchPBModelWords),
    enumeration(20, 606, "DPT_PBAction", "push-button action", kPBActionWords),
    enumeration(20, 607, "DPT_DimmPBModel", "dimmer push-button mode", kDimmPBModelWords),
    enumeration(20, 608, "DPT_SwitchOnMode", "switch on mode", kSwitchOnModeWords),
    enumeration(20, 609, "DPT_LoadTypeSet", "load type", kLoadTypeSetWords),
    enumeration(20, 610, "DPT_LoadTypeDetected", "load type detection", kLoadTypeDetectedWords),
    enumeration(20, 611, "DPT_Converter_Test_Control", "converter test control", kConverterTestControlWords),
    enumeration(20, 612, "DPT_Converter_Control", "converter control", kConverterControlWords),
    enumeration(20, 613, "DPT_Converter_Data_Request", "converter data request", kConverterDataRequestWords),
    enumeration(20, 801, "DPT_SABExceptBehaviour", "SAB except behavior", kSABExceptBehaviourWords),
    enumeration(20, 802, "DPT_SABBehaviour_Lock_Unlock", "SAB behavior on lock/unlock", kSABBehaviourLockUnlockWords),
    enumeration(20, 803, "DPT_SSSBMode", "SSSB mode", kSSSBModeWords),
    enumeration(20, 804, "DPT_BlindsControlMode", "blinds control mode", kBlindsControlModeWords),
    enumeration(20, 1000, "DPT_CommMode", "communication mode", kCommModeWords),
    enumeration(20, 1001, "DPT_AddInfoTypes", "additional information type", kAddInfoTypesWords),
    enumeration(20, 1002, "DPT_RF_ModeSelect", "RF mode selection", kRFModeSelectWords),
    enumeration(20, 1003, "DPT_RF_FilterSelect", "RF filter mode selection", kRFFilterSelectWords),
    enumeration(20, 1004, "DPT_Medium", "KNX medium", kMediumWords),
    enumeration(20, 1005, "DPT_PB_Function", "push-button function", kPBFunctionWords),
    enumeration(20, 1200, "DPT_MBus_BreakerValve_State", "M-Bus breaker/valve state", kMBusBreakerValveStateWords),
    enumeration(20, 1202, "DPT_Gas_Measurement_Condition", "gas measurement condition", kGasMeasurementConditionWords),
    enumeration(20, 1203, "DPT_Breaker_Status", "breaker status", kBreakerStatusWords),
    enumeration(20, 1204, "DPT_Euridis_Interface_Status", "Euridis interface status", kEuridisInterfaceStatusWords),
    enumeration(20, 1205, "DPT_PLC_Status", "PLC status", kPLCStatusWords),
    enumeration(20, 1206, "DPT_Peak_Event_Notice", "peak event notice", kPeakEventNoticeWords),
    enumeration(20, 1207, "DPT_Peak_Event", "peak event", kPeakEventWords),
    enumeration(20, 1208, "DPT_TIC_Type", "TIC type", kTICTypeWords),
    enumeration(20, 1209, "DPT_TIC_Channel_Type", "TIC channel type", kTICChannelTypeWords),
    enumeration(20, 1219, "DPT_EVSEMode_1", "EV charger: control pilot state", kEVSEMode1Words),
    enumeration(20, 1220, "DPT_EVSEMode_2", "EV charger: OCPP state", kEVSEMode2Words),
    enumeration(20, 1221, "DPT_EVSEMode_3", "EV charger: error code", kEVSEMode3Words),
    row(20, 60102, "(private) HVAC status", "RHCC-like status, eight bits", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput,
        Form::kBits, kPrivatehvacStatusWords),
    enumeration(20, 60104, "(private) HVAC command", "HVAC command", kPrivatehvacCommandWords),
    enumeration(20, 60105, "(private) heat/cool stage", "enable heat/cool stage (same as 20.116)",
                kPrivateheatCoolStageWords),
};

}  // namespace

std::span<const Dpt> device_mode_rows() {
  return kDeviceModeRows;
}

}  // namespace rubicon::networks::knx::dpt
