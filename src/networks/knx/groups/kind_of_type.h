#pragma once

#include <optional>

#include "networks/knx/dpt/dpt.h"

namespace rubicon::networks::knx::groups {

/// What a group address of this type most likely is when nobody says. Switches, dimming, blinds, scenes, setpoints,
/// modes and colours are commanded; measured values, counters, texts, dates and sets of status bits are read. No type:
/// a sensor, which nobody can command by mistake. The table stands in docs/knx-import.md.
Kind kind_of_type(std::optional<dpt::DptId> type);

}  // namespace rubicon::networks::knx::groups
