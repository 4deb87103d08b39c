#pragma once

#include "networks/knx/dpt/form.h"

// The two states of one bit, main types 1 and 2 (knx.md 9.4; KNX 3/7/2).

namespace rubicon::networks::knx::dpt {

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

}  // namespace rubicon::networks::knx::dpt
