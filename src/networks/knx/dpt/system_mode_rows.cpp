#include "networks/knx/dpt/catalogue.h"
#include "networks/knx/dpt/system_words.h"
#include "networks/knx/dpt/table.h"

namespace rubicon::networks::knx::dpt {

namespace {

using namespace catalogue;

// main, sub, name, meaning, unit, bits, minimum, maximum, step, sensor, actuator, form, words, record
constexpr Dpt kSystemModeRows[] = {
    row(20, 1, "DPT_SCLOMode", "system clock mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kSCLOModeWords),
    row(20, 2, "DPT_BuildingMode", "building mode", "", 8, 0, 255, 1, kBuildingMode, kBuildingMode, Form::kEnumeration,
        kBuildingModeWords),
    row(20, 3, "DPT_OccMode", "occupancy mode", "", 8, 0, 255, 1, kOccupancyMode, kOccupancyMode, Form::kEnumeration,
        kOccModeWords),
    row(20, 4, "DPT_Priority", "priority", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput, Form::kEnumeration,
        kPriorityWords),
    row(20, 5, "DPT_LightApplicationMode", "light application mode", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kLightApplicationModeWords),
    row(20, 6, "DPT_ApplicationArea", "application area", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kApplicationAreaWords),
    row(20, 7, "DPT_AlarmClassType", "alarm class", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kAlarmClassTypeWords),
    row(20, 8, "DPT_PSUMode", "PSU mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput, Form::kEnumeration,
        kPSUModeWords),
    row(20, 11, "DPT_ErrorClass_System", "system error class", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kErrorClassSystemWords),
    row(20, 12, "DPT_ErrorClass_HVAC", "HVAC error class", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kErrorClassHVACWords),
    row(20, 13, "DPT_Time_Delay", "time delay", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kTimeDelayWords),
    row(20, 14, "DPT_Beaufort_Wind_Force_Scale", "wind force scale (0..12)", "", 8, 0, 255, 1, kWindForce, kWindForce,
        Form::kEnumeration, kBeaufortWindForceScaleWords),
    row(20, 17, "DPT_SensorSelect", "sensor selection", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kSensorSelectWords),
    row(20, 20, "DPT_ActuatorConnectType", "actuator connect type", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kActuatorConnectTypeWords),
    row(20, 21, "DPT_Cloud_Cover", "cloud cover", "", 8, 0, 255, 1, kCloudCover, kCloudCover, Form::kEnumeration,
        kCloudCoverWords),
    row(20, 22, "DPT_PowerReturnMode", "power return mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kPowerReturnModeWords),
    row(20, 100, "DPT_FuelType", "fuel type", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kFuelTypeWords),
    row(20, 101, "DPT_BurnerType", "burner type", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kBurnerTypeWords),
    row(20, 102, "DPT_HVACMode", "HVAC mode", "", 8, 0, 255, 1, kHvacMode, kHvacMode, Form::kEnumeration,
        kHVACModeWords),
    row(20, 103, "DPT_DHWMode", "DHW mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput, Form::kEnumeration,
        kDHWModeWords),
    row(20, 104, "DPT_LoadPriority", "load priority", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kLoadPriorityWords),
    row(20, 105, "DPT_HVACContrMode", "HVAC control mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kHVACContrModeWords),
    row(20, 106, "DPT_HVACEmergMode", "HVAC emergency mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kHVACEmergModeWords),
    row(20, 107, "DPT_ChangeoverMode", "changeover mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kChangeoverModeWords),
    row(20, 108, "DPT_ValveMode", "valve mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kValveModeWords),
    row(20, 109, "DPT_DamperMode", "damper mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kDamperModeWords),
    row(20, 110, "DPT_HeaterMode", "heater mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kHeaterModeWords),
    row(20, 111, "DPT_FanMode", "fan mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput, Form::kEnumeration,
        kFanModeWords),
    row(20, 112, "DPT_MasterSlaveMode", "master/slave mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kMasterSlaveModeWords),
    row(20, 113, "DPT_StatusRoomSetp", "status room setpoint", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kStatusRoomSetpWords),
    row(20, 114, "DPT_Metering_DeviceType", "metering device type", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kMeteringDeviceTypeWords),
    row(20, 115, "DPT_HumDehumMode", "humidify/dehumidify mode", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kHumDehumModeWords),
    row(20, 116, "DPT_EnableHCStage", "enable heat/cool stages", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kEnableHCStageWords),
    row(20, 120, "DPT_ADAType", "air damper actuator type", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kADATypeWords),
    row(20, 121, "DPT_BackupMode", "backup mode", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration, kBackupModeWords),
    row(20, 122, "DPT_StartSynchronization", "start synchronization", "", 8, 0, 255, 1, kEnumerationInput,
        kEnumerationOutput, Form::kEnumeration, kStartSynchronizationWords),
};

}  // namespace

std::span<const Dpt> system_mode_rows() {
  return kSystemModeRows;
}

}  // namespace rubicon::networks::knx::dpt
