#pragma once

#include "networks/knx/dpt/dpt.h"

namespace rubicon::networks::knx::dpt {

// The two states of one bit, main types 1 and 2 (knx.md 9.4; KNX 3/7/2).

inline constexpr Word kSwitchWords[] = {{0, "off"}, {1, "on"}};
inline constexpr Word kBoolWords[] = {{0, "false"}, {1, "true"}};
inline constexpr Word kEnableWords[] = {{0, "disable"}, {1, "enable"}};
inline constexpr Word kRampWords[] = {{0, "no ramp"}, {1, "ramp"}};
inline constexpr Word kAlarmWords[] = {{0, "no alarm"}, {1, "alarm"}};
inline constexpr Word kBinaryValueWords[] = {{0, "low"}, {1, "high"}};
inline constexpr Word kStepWords[] = {{0, "decrease"}, {1, "increase"}};
inline constexpr Word kUpDownWords[] = {{0, "up"}, {1, "down"}};
inline constexpr Word kOpenCloseWords[] = {{0, "open"}, {1, "close"}};
inline constexpr Word kStartWords[] = {{0, "stop"}, {1, "start"}};
inline constexpr Word kStateWords[] = {{0, "inactive"}, {1, "active"}};
inline constexpr Word kInvertWords[] = {{0, "not inverted"}, {1, "inverted"}};
inline constexpr Word kDimSendStyleWords[] = {{0, "start/stop"}, {1, "cyclic"}};
inline constexpr Word kInputSourceWords[] = {{0, "fixed"}, {1, "calculated"}};
inline constexpr Word kResetWords[] = {{0, "no action"}, {1, "reset"}};
inline constexpr Word kAckWords[] = {{0, "no action"}, {1, "acknowledge"}};
inline constexpr Word kTriggerWords[] = {{0, "trigger"}, {1, "trigger"}};
inline constexpr Word kOccupancyWords[] = {{0, "not occupied"}, {1, "occupied"}};
inline constexpr Word kWindowDoorWords[] = {{0, "closed"}, {1, "open"}};
inline constexpr Word kLogicalFunctionWords[] = {{0, "OR"}, {1, "AND"}};
inline constexpr Word kSceneABWords[] = {{0, "scene A"}, {1, "scene B"}};
inline constexpr Word kShutterBlindsModeWords[] = {{0, "up/down only (shutter)"}, {1, "up/down + step/stop (blind)"}};
inline constexpr Word kDayNightWords[] = {{0, "day"}, {1, "night"}};
inline constexpr Word kHeatCoolWords[] = {{0, "cooling"}, {1, "heating"}};
inline constexpr Word kConsumerProducerWords[] = {{0, "consumer"}, {1, "producer"}};
inline constexpr Word kEnergyDirectionWords[] = {{0, "positive"}, {1, "negative"}};

// Names of bits (main types 21, 22, 30; bit 0 is the lowest) and the enumerations of main type 23 (knx.md 9.6, 9.7; KNX
// 3/7/2).

inline constexpr Word kPrivatehvacStatusWords[] = {{0, "comfort"},   {1, "standby"}, {2, "economy"},  {3, "protection"},
                                                   {4, "dew point"}, {5, "heat"},    {6, "inactive"}, {7, "frost"}};
inline constexpr Word kStatusGenWords[] = {
    {0, "out of service"}, {1, "fault"}, {2, "overridden"}, {3, "in alarm"}, {4, "alarm not acknowledged"}};
inline constexpr Word kDeviceControlWords[] = {
    {0, "user application stopped"}, {1, "own address seen as source"}, {2, "verify mode"}};
inline constexpr Word kForceSignWords[] = {{0, "force request"}, {1, "protection"},  {2, "oversupply"},
                                           {3, "overrun"},       {4, "DHW normal"},  {5, "DHW legio"},
                                           {6, "room comfort"},  {7, "room maximum"}};
inline constexpr Word kForceSignCoolWords[] = {{0, "force request"}};
inline constexpr Word kStatusRHCWords[] = {{0, "fault"},
                                           {1, "eco"},
                                           {2, "flow limit"},
                                           {3, "return limit"},
                                           {4, "morning boost"},
                                           {5, "start optimisation"},
                                           {6, "stop optimisation"},
                                           {7, "summer mode"}};
inline constexpr Word kStatusSDHWCWords[] = {{0, "fault"}, {1, "load active"}, {2, "load sufficient"}};
inline constexpr Word kFuelTypeSetWords[] = {{0, "oil"}, {1, "gas"}, {2, "solid"}};
inline constexpr Word kStatusRCCWords[] = {{0, "fault"}};
inline constexpr Word kStatusAHUWords[] = {{0, "fault"}, {1, "fan active"}, {2, "heat"}, {3, "cool"}};
inline constexpr Word kCombinedStatusRTSMWords[] = {
    {0, "window"}, {1, "presence"}, {2, "comfort button"}, {3, "comfort prolongation"}, {4, "HVAC mode by user"}};
inline constexpr Word kLightActuatorErrorInfoWords[] = {
    {0, "load detection"}, {1, "undervoltage"}, {2, "overcurrent"}, {3, "underload"},
    {4, "defective load"}, {5, "lamp failure"}, {6, "overheat"}};
inline constexpr Word kRFModeInfoWords[] = {{0, "asynchronous"}, {1, "BiBat master"}, {2, "BiBat slave"}};
inline constexpr Word kRFFilterInfoWords[] = {{0, "domain address"}, {1, "serial number"}, {2, "both"}};
inline constexpr Word kSecurityReportWords[] = {{0, "security failure"}};
inline constexpr Word kChannelActivation8Words[] = {{0, "channel 1"}, {1, "channel 2"}, {2, "channel 3"},
                                                    {3, "channel 4"}, {4, "channel 5"}, {5, "channel 6"},
                                                    {6, "channel 7"}, {7, "channel 8"}};
inline constexpr Word kVirtualDryContactWords[] = {
    {0, "contact 0 closed"}, {1, "contact 1 closed"}, {2, "contact 2 closed"}, {3, "contact 3 closed"},
    {4, "contact 4 closed"}, {5, "contact 5 closed"}, {6, "contact 6 closed"}, {7, "contact 7 closed"}};
inline constexpr Word kPhasesStatusWords[] = {{0, "phase 1"}, {1, "phase 2"}, {2, "phase 3"}};
inline constexpr Word kStatusDHWCWords[] = {{0, "fault"},         {1, "load"},         {2, "legio protection"},
                                            {3, "push"},          {4, "other source"}, {5, "solar only"},
                                            {6, "solar support"}, {7, "optimum shift"}};
inline constexpr Word kStatusRHCCWords[] = {{0, "fault"},
                                            {1, "heating eco"},
                                            {2, "flow limit"},
                                            {3, "return limit"},
                                            {4, "morning boost"},
                                            {5, "start optimisation"},
                                            {6, "stop optimisation"},
                                            {7, "heating disabled"},
                                            {8, "heating mode (0 cooling)"},
                                            {9, "cooling eco"},
                                            {10, "pre-cool"},
                                            {11, "cooling disabled"},
                                            {12, "dew point alarm"},
                                            {13, "frost alarm"},
                                            {14, "overheat alarm"}};
inline constexpr Word kCombinedStatusHVAWords[] = {{0, "current valve position"},
                                                   {1, "short circuit"},
                                                   {2, "overload"},
                                                   {3, "valve kick"},
                                                   {4, "service mode"},
                                                   {5, "manual"},
                                                   {6, "forced"},
                                                   {7, "locked"},
                                                   {8, "calibration"}};
inline constexpr Word kCombinedStatusRTCWords[] = {
    {0, "general failure"}, {1, "active mode"},  {2, "dew point"},       {3, "frost alarm"},    {4, "overheat alarm"},
    {5, "inactive"},        {6, "second stage"}, {7, "heating enabled"}, {8, "cooling enabled"}};
inline constexpr Word kMediaWords[] = {{1, "TP1"}, {2, "PL110"}, {4, "RF"}, {5, "IP"}};
inline constexpr Word kChannelActivation16Words[] = {
    {0, "channel 1"},   {1, "channel 2"},   {2, "channel 3"},   {3, "channel 4"},
    {4, "channel 5"},   {5, "channel 6"},   {6, "channel 7"},   {7, "channel 8"},
    {8, "channel 9"},   {9, "channel 10"},  {10, "channel 11"}, {11, "channel 12"},
    {12, "channel 13"}, {13, "channel 14"}, {14, "channel 15"}, {15, "channel 16"}};
inline constexpr Word kChannelActivation24Words[] = {
    {0, "channel 1"},   {1, "channel 2"},   {2, "channel 3"},   {3, "channel 4"},   {4, "channel 5"},
    {5, "channel 6"},   {6, "channel 7"},   {7, "channel 8"},   {8, "channel 9"},   {9, "channel 10"},
    {10, "channel 11"}, {11, "channel 12"}, {12, "channel 13"}, {13, "channel 14"}, {14, "channel 15"},
    {15, "channel 16"}, {16, "channel 17"}, {17, "channel 18"}, {18, "channel 19"}, {19, "channel 20"},
    {20, "channel 21"}, {21, "channel 22"}, {22, "channel 23"}, {23, "channel 24"}};
inline constexpr Word kOnOffActionWords[] = {{0, "off"}, {1, "on"}, {2, "off/on"}, {3, "on/off"}};
inline constexpr Word kAlarmReactionWords[] = {{0, "no alarm"}, {1, "alarm position up"}, {2, "alarm position down"}};
inline constexpr Word kUpDownActionWords[] = {{0, "up"}, {1, "down"}, {2, "up/down"}, {3, "down/up"}};
inline constexpr Word kHVACPBActionWords[] = {
    {0, "comfort/economy"}, {1, "comfort/nothing"}, {2, "economy/nothing"}, {3, "protection/auto"}};

}  // namespace rubicon::networks::knx::dpt
