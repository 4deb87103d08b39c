#pragma once

#include <optional>
#include <string_view>

#include "rubicon/time.hpp"

namespace rubicon::networks::log {

/// `2026-01-31T12:00:00.25Z`; a blank instead of the T, no seconds, `+01:00` instead of Z; without either it is UTC.
std::optional<WallTime> parse_iso_time(std::string_view text);

}  // namespace rubicon::networks::log
