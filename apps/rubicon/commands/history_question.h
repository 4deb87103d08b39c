#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "apps/rubicon/session.h"
#include "history/series.h"

namespace rubicon::cli {

/// Asks the island that keeps a history for the past of the tuples that the texts name, keys or names of people. The
/// owner of a tuple is asked first; where it keeps none, another island that does. kGood and the answer, or the exit
/// code after the error was printed.
int ask_history(Session& session, const std::vector<std::string>& texts, WallTime from, WallTime to,
                std::size_t buckets, history::Answer& answer);

}  // namespace rubicon::cli
