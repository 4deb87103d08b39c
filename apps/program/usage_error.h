#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace rubicon::program {

/// What is wrong with a command line that CLI11 refused, in one or two sentences: an unknown command or option is named
/// with the nearest ones there are, and a word too many; all else is CLI11's own text. Only for errors, not for --help
/// and --version.
std::string explain(const CLI::App& app, const CLI::ParseError& error);

}  // namespace rubicon::program
