#pragma once

#include <string_view>
#include <vector>

#include "apps/rubicon/doctor/island_findings.h"

namespace rubicon::cli {

// KNX Secure (docs/knx-secure.md). Pure functions of what was observed.

/// `secure`: what the lines and secured groups of networks dropped, and interfaces that are not verified. A problem if
/// the counter grew between the observations, else a note.
Findings check_secure(const IslandSeen& seen);

/// This counter counts what KNX Secure dropped: check_secure() explains it.
bool is_secure_counter(std::string_view name);

}  // namespace rubicon::cli
