#pragma once

#include "networks/knx/dpt/dpt.h"

/// The layouts of types of several fields (knx.md 9.3 and 9.8 after KNX 3/7/2).
namespace rubicon::networks::knx::dpt {

extern const StructLayout kBlindStepRecord;
extern const StructLayout kStatusModeRecord;
extern const StructLayout kAccessRecord;
extern const StructLayout kSceneControlRecord;
extern const StructLayout kRepetitionsRecord;
extern const StructLayout kSceneStateRecord;
extern const StructLayout kCombinedOnOffRecord;
extern const StructLayout kControlRecord;
extern const StructLayout kHvacModeNextRecord;
extern const StructLayout kHotWaterModeNextRecord;
extern const StructLayout kOccupancyModeNextRecord;
extern const StructLayout kBuildingModeNextRecord;
extern const StructLayout kLightingActuatorRecord;
extern const StructLayout kSetpointsRecord;
extern const StructLayout kHotWaterSetpointsRecord;
extern const StructLayout kVersionRecord;
extern const StructLayout kAlarmRecord;
extern const StructLayout kThreeFloatSetpointsRecord;
extern const StructLayout kScalingSpeedRecord;
extern const StructLayout kScalingStepRecord;
extern const StructLayout kNextTariffRecord;
extern const StructLayout kMeterAddressRecord;
extern const StructLayout kTariffEnergyRecord;
extern const StructLayout kPrioritisedModeRecord;
extern const StructLayout kControlGearRecord;
extern const StructLayout kSceneConfigurationRecord;
extern const StructLayout kDaliDiagnosticsRecord;
extern const StructLayout kFlaggedPercentRecord;
extern const StructLayout kCombinedPositionRecord;
extern const StructLayout kBlindStatusRecord;
extern const StructLayout kColourXyRecord;
extern const StructLayout kColourXyTransitionRecord;
extern const StructLayout kConverterStatusRecord;
extern const StructLayout kConverterTestRecord;
extern const StructLayout kBatteryRecord;
extern const StructLayout kTemperatureTransitionRecord;
extern const StructLayout kTemperatureControlRecord;
extern const StructLayout kColourRgbwRecord;
extern const StructLayout kRgbwControlRecord;
extern const StructLayout kXyControlRecord;
extern const StructLayout kRgbControlRecord;
extern const StructLayout kGeographicalRecord;
extern const StructLayout kFourFloatSetpointsRecord;

}  // namespace rubicon::networks::knx::dpt
