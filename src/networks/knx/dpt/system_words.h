#pragma once

#include "networks/knx/dpt/form.h"

// Enumerations of main type 20, sub types below 600 (knx.md 9.6; KNX 3/7/2).

namespace rubicon::networks::knx::dpt {

inline constexpr Word kSCLOModeWords[] = {{0, "autonomous"}, {1, "slave"}, {2, "master"}};
inline constexpr Word kBuildingModeWords[] = {{0, "in use"}, {1, "not used"}, {2, "protection"}};
inline constexpr Word kOccModeWords[] = {{0, "occupied"}, {1, "standby"}, {2, "not occupied"}};
inline constexpr Word kPriorityWords[] = {{0, "high"}, {1, "medium"}, {2, "low"}, {3, "void"}};
inline constexpr Word kLightApplicationModeWords[] = {{0, "normal"}, {1, "presence simulation"}, {2, "night round"}};
inline constexpr Word kApplicationAreaWords[] = {{0, "none"},
                                                 {1, "common"},
                                                 {10, "HVAC general"},
                                                 {11, "HVAC hot water heating"},
                                                 {12, "HVAC electric heating"},
                                                 {13, "HVAC terminal units"},
                                                 {14, "HVAC ventilation/AC"},
                                                 {20, "lighting"},
                                                 {30, "security"},
                                                 {40, "load management"},
                                                 {50, "shutters/blinds"}};
inline constexpr Word kAlarmClassTypeWords[] = {{1, "simple"}, {2, "basic"}, {3, "extended"}};
inline constexpr Word kPSUModeWords[] = {{0, "off"}, {1, "on"}, {2, "auto"}};
inline constexpr Word kErrorClassSystemWords[] = {{0, "none"},
                                                  {1, "device"},
                                                  {2, "communication"},
                                                  {3, "configuration"},
                                                  {4, "hardware"},
                                                  {5, "software"},
                                                  {6, "non-volatile memory full"},
                                                  {7, "memory full"},
                                                  {8, "zero-size allocation"},
                                                  {9, "CRC"},
                                                  {10, "watchdog reset"},
                                                  {11, "invalid opcode"},
                                                  {12, "protection fault"},
                                                  {13, "table too long"},
                                                  {14, "undefined load command"},
                                                  {15, "group table unsorted"},
                                                  {16, "invalid connection number"},
                                                  {17, "invalid group object"},
                                                  {18, "group object type too long"}};
inline constexpr Word kErrorClassHVACWords[] = {
    {0, "none"}, {1, "sensor"}, {2, "process/controller"}, {3, "actuator"}, {4, "other"}};
inline constexpr Word kTimeDelayWords[] = {
    {0, "not active"}, {1, "1 s"},    {2, "2 s"},    {3, "3 s"},     {4, "5 s"},       {5, "10 s"},     {6, "15 s"},
    {7, "20 s"},       {8, "30 s"},   {9, "45 s"},   {10, "1 min"},  {11, "1.25 min"}, {12, "1.5 min"}, {13, "2 min"},
    {14, "2.5 min"},   {15, "3 min"}, {16, "5 min"}, {17, "15 min"}, {18, "20 min"},   {19, "30 min"},  {20, "1 h"},
    {21, "2 h"},       {22, "3 h"},   {23, "5 h"},   {24, "12 h"},   {25, "24 h"}};
inline constexpr Word kBeaufortWindForceScaleWords[] = {
    {0, "calm"},         {1, "light air"},      {2, "light breeze"}, {3, "gentle breeze"}, {4, "moderate breeze"},
    {5, "fresh breeze"}, {6, "strong breeze"},  {7, "near gale"},    {8, "gale"},          {9, "strong gale"},
    {10, "storm"},       {11, "violent storm"}, {12, "hurricane"}};
inline constexpr Word kSensorSelectWords[] = {
    {0, "inactive"}, {1, "digital"}, {2, "digital inverted"}, {3, "analog 0..100 %"}, {4, "temperature"}};
inline constexpr Word kActuatorConnectTypeWords[] = {{1, "sensor connection"}, {2, "controller connection"}};
inline constexpr Word kCloudCoverWords[] = {
    {0, "cloudless"}, {1, "sunny"},   {2, "sunshiny"}, {3, "lightly cloudy"}, {4, "scattered clouds"},
    {5, "cloudy"},    {6, "6 oktas"}, {7, "7 oktas"},  {8, "overcast"},       {9, "sky obstructed"}};
inline constexpr Word kPowerReturnModeWords[] = {{0, "do not send"}, {1, "send always"}, {2, "send if changed"}};
inline constexpr Word kFuelTypeWords[] = {{0, "auto"}, {1, "oil"}, {2, "gas"}, {3, "solid state fuel"}};
inline constexpr Word kBurnerTypeWords[] = {{1, "one stage"}, {2, "two stages"}, {3, "modulating"}};
inline constexpr Word kHVACModeWords[] = {
    {0, "auto"}, {1, "comfort"}, {2, "standby"}, {3, "economy"}, {4, "building protection"}};
inline constexpr Word kDHWModeWords[] = {
    {0, "auto"}, {1, "legio protect"}, {2, "normal"}, {3, "reduced"}, {4, "off/frost protect"}};
inline constexpr Word kLoadPriorityWords[] = {{0, "none"}, {1, "shift"}, {2, "absolute"}};
inline constexpr Word kHVACContrModeWords[] = {{0, "auto"},
                                               {1, "heat"},
                                               {2, "morning warmup"},
                                               {3, "cool"},
                                               {4, "night purge"},
                                               {5, "precool"},
                                               {6, "off"},
                                               {7, "test"},
                                               {8, "emergency heat"},
                                               {9, "fan only"},
                                               {10, "free cool"},
                                               {11, "ice"},
                                               {12, "maximum heating"},
                                               {13, "economic heat/cool"},
                                               {14, "dehumidification"},
                                               {15, "calibration"},
                                               {16, "emergency cool"},
                                               {17, "emergency steam"},
                                               {20, "no demand"}};
inline constexpr Word kHVACEmergModeWords[] = {{0, "normal"}, {1, "pressure"}, {2, "depressure"},
                                               {3, "purge"},  {4, "shutdown"}, {5, "fire"}};
inline constexpr Word kChangeoverModeWords[] = {{0, "auto"}, {1, "cooling only"}, {2, "heating only"}};
inline constexpr Word kValveModeWords[] = {
    {1, "heat stage A"}, {2, "heat stage B"}, {3, "cool stage A"}, {4, "cool stage B"}, {5, "heat/cool"}};
inline constexpr Word kDamperModeWords[] = {
    {1, "fresh air"}, {2, "supply air"}, {3, "extract air"}, {4, "extract air (2)"}};
inline constexpr Word kHeaterModeWords[] = {
    {1, "stage A on/off"}, {2, "stage A proportional"}, {3, "stage B proportional"}};
inline constexpr Word kFanModeWords[] = {{0, "off"}, {1, "permanent"}, {2, "intervals"}};
inline constexpr Word kMasterSlaveModeWords[] = {{0, "autonomous"}, {1, "master"}, {2, "slave"}};
inline constexpr Word kStatusRoomSetpWords[] = {{0, "normal"}, {1, "alternative"}, {2, "building protection"}};
inline constexpr Word kMeteringDeviceTypeWords[] = {{0, "other"},
                                                    {1, "oil"},
                                                    {2, "electricity"},
                                                    {3, "gas"},
                                                    {4, "heat"},
                                                    {5, "steam"},
                                                    {6, "warm water"},
                                                    {7, "water"},
                                                    {8, "heat cost allocator"},
                                                    {10, "cooling (outlet)"},
                                                    {11, "cooling (inlet)"},
                                                    {12, "heat (inlet)"},
                                                    {13, "heat and cool"},
                                                    {32, "breaker"},
                                                    {33, "valve"},
                                                    {40, "waste water"},
                                                    {41, "garbage"},
                                                    {255, "void"}};
inline constexpr Word kHumDehumModeWords[] = {{0, "inactive"}, {1, "humidify"}, {2, "dehumidify"}};
inline constexpr Word kEnableHCStageWords[] = {{0, "disabled"}, {1, "stage A"}, {2, "stage B"}, {3, "both"}};
inline constexpr Word kADATypeWords[] = {{1, "air damper"}, {2, "VAV"}};
inline constexpr Word kBackupModeWords[] = {{0, "backup value"}, {1, "keep last state"}};
inline constexpr Word kStartSynchronizationWords[] = {{0, "unchanged"}, {1, "single close"}, {2, "single open"}};

}  // namespace rubicon::networks::knx::dpt
