#pragma once

#include <string>

#include "support/process.h"

namespace rubicon::examples {

/// Runs until somebody ends it.
bool is_endless(const std::string& line);

/// Shows something of the demo sooner or later.
bool shows_what_is_there(const std::string& line);

/// What is wrong with how an example ended; empty = nothing. `line`: as it was run.
std::string fault_of(const std::string& line, const support::Outcome& outcome);

}  // namespace rubicon::examples
