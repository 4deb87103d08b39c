#pragma once

#include <string_view>
#include <vector>

#include "apps/rubicon/island_findings.h"

namespace rubicon::cli {

// KNX Secure (docs/knx-secure.md). Pure functions of what was observed.

/// What to do about the reason of a line, if KNX Secure is concerned; empty: something else is the reason.
std::string_view secure_remedy(std::string_view reason);
/// The parts of reasons that secure_remedy() knows.
std::vector<std::string_view> secure_reasons();

/// `secure`: what the lines and secured groups of networks dropped, and interfaces that are not verified. A problem if
/// the counter grew between the observations, else a note.
Findings check_secure(const IslandSeen& seen);

/// This counter counts what KNX Secure dropped: check_secure() explains it.
bool is_secure_counter(std::string_view name);

}  // namespace rubicon::cli
