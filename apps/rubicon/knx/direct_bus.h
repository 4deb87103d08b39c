#pragma once

#include "apps/rubicon/knx/bus.h"

namespace rubicon::cli::knx {

/// A tunnel of our own to BusOptions::direct; waits until it is there. nullptr: why not was said.
std::unique_ptr<ToolLine> open_direct(const Settings& settings, const BusOptions& options, int& code);

}  // namespace rubicon::cli::knx
