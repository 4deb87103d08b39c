#pragma once

#include <optional>
#include <string_view>

#include "networks/log/time_zone.h"

namespace rubicon::networks::log {

/// `2026-01-31T12:00:00.25Z`. A blank may replace the T, `+01:00` (after a blank or not) the Z; seconds and time may be
/// missing; `24:00` ends a day. Local without a zone.
std::optional<FileTime> parse_iso_time(std::string_view text);

}  // namespace rubicon::networks::log
