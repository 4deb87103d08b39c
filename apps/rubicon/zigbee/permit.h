#pragma once

#include <string>

#include "apps/rubicon/zigbee/tool.h"

namespace rubicon::cli::zigbee {

/// After a permit: prints what joins until joining is closed, by time, by another client or by an interrupt. `id` is
/// that of the permit's reply. kGood, or kNotDone after the reason was printed.
int watch_joins(Tool& tool, const std::string& id);

}  // namespace rubicon::cli::zigbee
