#pragma once

#include "networks/knx/dpt/form.h"

/// The layouts of types of several fields (knx.md 9.3 and 9.8 after KNX 3/7/2).
namespace rubicon::networks::knx::dpt {

extern const Record kBlindStepRecord;
extern const Record kStatusModeRecord;
extern const Record kAccessRecord;
extern const Record kSceneControlRecord;
extern const Record kRepetitionsRecord;
extern const Record kSceneStateRecord;
extern const Record kCombinedOnOffRecord;
extern const Record kControlRecord;
extern const Record kHvacModeNextRecord;
extern const Record kHotWaterModeNextRecord;
extern const Record kOccupancyModeNextRecord;
extern const Record kBuildingModeNextRecord;
extern const Record kLightingActuatorRecord;
extern const Record kSetpointsRecord;
extern const Record kHotWaterSetpointsRecord;
extern const Record kVersionRecord;
extern const Record kAlarmRecord;
extern const Record kThreeFloatSetpointsRecord;
extern const Record kScalingSpeedRecord;
extern const Record kScalingStepRecord;
extern const Record kNextTariffRecord;
extern const Record kMeterAddressRecord;
extern const Record kTariffEnergyRecord;
extern const Record kPrioritisedModeRecord;
extern const Record kControlGearRecord;
extern const Record kSceneConfigurationRecord;
extern const Record kDaliDiagnosticsRecord;
extern const Record kFlaggedPercentRecord;
extern const Record kCombinedPositionRecord;
extern const Record kBlindStatusRecord;
extern const Record kColourXyRecord;
extern const Record kColourXyTransitionRecord;
extern const Record kConverterStatusRecord;
extern const Record kConverterTestRecord;
extern const Record kBatteryRecord;
extern const Record kTemperatureTransitionRecord;
extern const Record kTemperatureControlRecord;
extern const Record kColourRgbwRecord;
extern const Record kRgbwControlRecord;
extern const Record kXyControlRecord;
extern const Record kRgbControlRecord;
extern const Record kGeographicalRecord;
extern const Record kFourFloatSetpointsRecord;

}  // namespace rubicon::networks::knx::dpt
