#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "rubicon/time.hpp"

namespace rubicon::cli {

/// Adds an option whose value is a time: `now`, a span before it (`2h`), seconds since 1970, or `2026-01-31T12:00:00Z`.
CLI::Option* add_time_option(CLI::App* app, const std::string& name, std::string& text, const std::string& about);
/// The time in the text of such an option; nullopt for a text that it refuses.
std::optional<WallTime> time_in(const std::string& text, WallTime now);

}  // namespace rubicon::cli
