#pragma once

#include "networks/knx/dpt/dpt.h"

namespace rubicon::networks::knx::dpt {

// Enumerations of main type 20, sub types below 600 (knx.md 9.6; KNX 3/7/2).

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

// Enumerations of main type 20, sub types from 600 on (knx.md 9.6; KNX 3/7/2).

inline constexpr Word kBehaviourLockUnlockWords[] = {{0, "off"},
                                                     {1, "on"},
                                                     {2, "no change"},
                                                     {3, "by parameter"},
                                                     {4, "memory"},
                                                     {5, "updated value"},
                                                     {6, "value before lock"}};
inline constexpr Word kBehaviourBusPowerUpDownWords[] = {
    {0, "off"}, {1, "on"}, {2, "no change"}, {3, "by parameter"}, {4, "last value"}};
inline constexpr Word kDALIFadeTimeWords[] = {{0, "0 s (no fade)"}, {1, "0.7 s"},   {2, "1.0 s"},   {3, "1.4 s"},
                                              {4, "2.0 s"},         {5, "2.8 s"},   {6, "4.0 s"},   {7, "5.7 s"},
                                              {8, "8.0 s"},         {9, "11.3 s"},  {10, "16.0 s"}, {11, "22.6 s"},
                                              {12, "32.0 s"},       {13, "45.3 s"}, {14, "64.0 s"}, {15, "90.5 s"}};
inline constexpr Word kBlinkingModeWords[] = {{0, "disabled"}, {1, "without acknowledge"}, {2, "with acknowledge"}};
inline constexpr Word kLightControlModeWords[] = {{0, "automatic"}, {1, "manual"}};
inline constexpr Word kSwitchPBModelWords[] = {{1, "one button"}, {2, "two buttons"}};
inline constexpr Word kPBActionWords[] = {
    {0, "inactive"}, {1, "off sent"}, {2, "on sent"}, {3, "inverse of info sent"}};
inline constexpr Word kDimmPBModelWords[] = {
    {1, "one button, toggles"}, {2, "one button, on/up"}, {3, "one button, off/down"}, {4, "two buttons"}};
inline constexpr Word kSwitchOnModeWords[] = {{0, "last value"}, {1, "by parameter"}, {2, "last received setvalue"}};
inline constexpr Word kLoadTypeSetWords[] = {{0, "automatic"},    {1, "leading edge"},   {2, "trailing edge"},
                                             {3, "switch only"},  {4, "automatic once"}, {5, "CFL leading"},
                                             {6, "CFL trailing"}, {7, "LED leading"},    {8, "LED trailing"}};
inline constexpr Word kLoadTypeDetectedWords[] = {{0, "undefined"},           {1, "leading edge"},
                                                  {2, "trailing edge"},       {3, "not possible or error"},
                                                  {4, "calibration pending"}, {5, "CFL leading"},
                                                  {6, "CFL trailing"},        {7, "LED leading"},
                                                  {8, "LED trailing"},        {255, "not possible or error"}};
inline constexpr Word kConverterTestControlWords[] = {{1, "start FT"},  {2, "start DT"},      {3, "start PDT"},
                                                      {4, "stop test"}, {5, "reset FT flag"}, {6, "reset DT flag"}};
inline constexpr Word kConverterControlWords[] = {
    {0, "factory reset"}, {1, "rest"}, {2, "inhibit"}, {3, "re-light/reset inhibit"}, {4, "reset lamp time"}};
inline constexpr Word kConverterDataRequestWords[] = {{1, "status"},  {2, "test result"}, {3, "battery info"},
                                                      {4, "FT info"}, {5, "DT info"},     {6, "PDT info"},
                                                      {7, "info"},    {8, "fixed info"}};
inline constexpr Word kSABExceptBehaviourWords[] = {
    {0, "up"}, {1, "down"}, {2, "no change"}, {3, "by parameter"}, {4, "stop"}};
inline constexpr Word kSABBehaviourLockUnlockWords[] = {
    {0, "up"},   {1, "down"},          {2, "no change"},        {3, "by parameter"},
    {4, "stop"}, {5, "updated value"}, {6, "value before lock"}};
inline constexpr Word kSSSBModeWords[] = {
    {1, "one button, toggles"}, {2, "one button, up"}, {3, "one button, down"}, {4, "two buttons"}};
inline constexpr Word kBlindsControlModeWords[] = {{0, "automatic"}, {1, "manual"}};
inline constexpr Word kCommModeWords[] = {
    {0, "data link layer"}, {1, "busmonitor"}, {2, "raw frames"}, {6, "cEMI transport layer"}, {255, "none"}};
inline constexpr Word kAddInfoTypesWords[] = {{1, "PL domain address"},
                                              {2, "RF control + serial/domain"},
                                              {3, "busmonitor error flags"},
                                              {4, "relative timestamp"},
                                              {5, "time delay"},
                                              {6, "extended relative timestamp"},
                                              {7, "BiBat"}};
inline constexpr Word kRFModeSelectWords[] = {{0, "asynchronous"}, {1, "+ BiBat master"}, {2, "+ BiBat slave"}};
inline constexpr Word kRFFilterSelectWords[] = {{0, "none"}, {1, "domain address"}, {2, "serial number"}, {3, "both"}};
inline constexpr Word kMediumWords[] = {{0, "TP1"}, {1, "PL110"}, {2, "RF"}, {5, "IP"}};
inline constexpr Word kPBFunctionWords[] = {{1, "default action"},
                                            {2, "on"},
                                            {3, "off"},
                                            {4, "toggle"},
                                            {5, "dimming up down"},
                                            {6, "dimming up"},
                                            {7, "dimming down"},
                                            {8, "on off"},
                                            {9, "timed on off"},
                                            {10, "forced on"},
                                            {11, "forced off"},
                                            {12, "shutter up"},
                                            {13, "shutter down"},
                                            {14, "shutter up down"},
                                            {16, "forced up"},
                                            {17, "forced down"},
                                            {18, "wind alarm"},
                                            {19, "rain alarm"},
                                            {20, "hvac mode comfort economy"},
                                            {21, "hvac mode comfort"},
                                            {22, "hvac mode economy"},
                                            {23, "hvac mode building protection auto"},
                                            {24, "shutter stop"},
                                            {25, "timed comfort standby"},
                                            {26, "forced comfort"},
                                            {27, "forced building protection"},
                                            {28, "scene1"},
                                            {29, "scene2"},
                                            {30, "scene3"},
                                            {31, "scene4"},
                                            {32, "scene5"},
                                            {33, "scene6"},
                                            {34, "scene7"},
                                            {35, "scene8"},
                                            {36, "absolute dimming25"},
                                            {37, "absolute dimming50"},
                                            {38, "absolute dimming75"},
                                            {39, "absolute dimming100"},
                                            {40, "shutter up switch"},
                                            {41, "shutter down switch"},
                                            {42, "shutter up down switch"},
                                            {43, "shutter down up switch"},
                                            {44, "light sensor"},
                                            {45, "system clock"},
                                            {46, "battery status"},
                                            {47, "hvac mode standby"},
                                            {48, "hvac mode auto"},
                                            {49, "hvac mode comfort standby"},
                                            {50, "hvac mode building protection"},
                                            {51, "timed toggle"},
                                            {52, "dimming absolute switch"},
                                            {53, "scene switch"},
                                            {54, "smoke alarm"},
                                            {55, "sub detector"}};
inline constexpr Word kMBusBreakerValveStateWords[] = {{0, "closed"}, {1, "open"}, {2, "released"}, {255, "invalid"}};
inline constexpr Word kGasMeasurementConditionWords[] = {
    {0, "unknown"}, {1, "temperature converted"}, {2, "base condition"}, {3, "measurement condition"}};
inline constexpr Word kBreakerStatusWords[] = {{0, "closed"},
                                               {1, "open: overload"},
                                               {2, "open: overvoltage"},
                                               {3, "open: load shedding"},
                                               {4, "open: PLC/Euridis command"},
                                               {5, "open: overheat, over max current"},
                                               {6, "open: overheat, under max current"}};
inline constexpr Word kEuridisInterfaceStatusWords[] = {
    {0, "deactivated"}, {1, "active, no security"}, {2, "active, secured"}};
inline constexpr Word kPLCStatusWords[] = {
    {0, "new/unlock (G3: not associated)"}, {1, "new/lock (G3: associated)"}, {2, "registered"}};
inline constexpr Word kPeakEventNoticeWords[] = {
    {0, "none"}, {1, "PE1 announced"}, {2, "PE2 announced"}, {3, "PE3 announced"}};
inline constexpr Word kPeakEventWords[] = {{0, "none"}, {1, "PE1"}, {2, "PE2"}, {3, "PE3"}};
inline constexpr Word kTICTypeWords[] = {{0, "historical"}, {1, "standard"}};
inline constexpr Word kTICChannelTypeWords[] = {{0, "none"},
                                                {1, "historical 1-phase"},
                                                {2, "historical 3-phase"},
                                                {3, "standard 1-phase"},
                                                {4, "standard 3-phase"}};
inline constexpr Word kEVSEMode1Words[] = {
    {0, "standby"},  {1, "vehicle detected"}, {2, "ready"}, {3, "charging with ventilation"}, {4, "finished"},
    {5, "reserved"}, {6, "unavailable"},      {7, "error"}, {8, "suspended by EVSE"},         {9, "suspended by EV"}};
inline constexpr Word kEVSEMode2Words[] = {
    {0, "charging"},  {1, "EV connected"}, {2, "suspended by EV"}, {3, "suspended by EVSE"}, {4, "idle"},
    {5, "available"}, {6, "occupied"},     {7, "reserved"},        {8, "unavailable"},       {9, "faulted"}};
inline constexpr Word kEVSEMode3Words[] = {{0, "connector lock"},   {1, "EV communication"}, {2, "ground failure"},
                                           {3, "high temperature"}, {4, "internal"},         {5, "local list conflict"},
                                           {6, "no error"}};
inline constexpr Word kPrivatehvacCommandWords[] = {
    {0, "normal write"},         {1, "override"},          {2, "release"},       {3, "set out of service"},
    {4, "reset out of service"}, {5, "alarm acknowledge"}, {6, "set to default"}};
inline constexpr Word kPrivateheatCoolStageWords[] = {{0, "disabled"}, {1, "stage A"}, {2, "stage B"}, {3, "both"}};

}  // namespace rubicon::networks::knx::dpt
