#pragma once

#include <optional>

#include "networks/knx/dpt/dpt.h"

namespace rubicon::networks::knx::groups {

/// The most likely kind of a group address of this type. Switches, dimming, blinds, scenes, setpoints,
/// modes and colours are commanded; measured values, counters, texts, dates and sets of status bits are read. Without
/// a type: a sensor, which cannot be commanded by mistake. docs/knx-import.md has the table.
Kind kind_of_type(std::optional<dpt::DptId> type);

}  // namespace rubicon::networks::knx::groups
