#pragma once

#include "apps/rubicon/cli.h"

namespace rubicon::cli::knx {

// Each adds one command of `rubicon knx`, or a few that belong together.
void add_convert(Cli& cli, CLI::App* parent);
void add_import(Cli& cli, CLI::App* parent);
void add_keyring(Cli& cli, CLI::App* parent);
void add_discover(Cli& cli, CLI::App* parent);
void add_bus(Cli& cli, CLI::App* parent);

}  // namespace rubicon::cli::knx
