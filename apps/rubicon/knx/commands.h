#pragma once

#include "apps/rubicon/cli.h"

namespace rubicon::cli::knx {

// Each adds one command of `rubicon knx`, or a few that belong together.
void add_convert(Cli& cli, CLI::App* under);
void add_import(Cli& cli, CLI::App* under);
void add_discover(Cli& cli, CLI::App* under);
void add_bus(Cli& cli, CLI::App* under);

}  // namespace rubicon::cli::knx
