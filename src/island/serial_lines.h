#pragma once

#include "island/island_config.h"

namespace rubicon::island {

/// One process reads a serial line: two networks on the same device are an error, at the later one.
void check_serial_lines(const IslandConfig& config, base::ConfigErrors& errors);

}  // namespace rubicon::island
