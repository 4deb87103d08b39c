#pragma once

#include <optional>
#include <string_view>

#include "rubicon/time.hpp"

namespace rubicon::networks::log {

/// `2026-01-31T12:00:00.25Z`. A blank may replace the T, `+01:00` the Z; seconds and time may be missing. UTC without a
/// zone.
std::optional<WallTime> parse_iso_time(std::string_view text);

}  // namespace rubicon::networks::log
