#pragma once

#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "trust/secret_text.h"

namespace rubicon::cli::trust {

using rubicon::trust::SecretText;

/// Where a pass phrase comes from, or goes to, besides the terminal.
struct PhraseOptions {
  std::string file;  ///< empty = the terminal
};

/// The first line of the file; else typed on the terminal, which does not show it; else a line of standard input.
/// kInvalid: it is empty.
Result<SecretText> read_phrase(const PhraseOptions& options, const std::string& question);

/// Whether a new phrase can be shown on standard output: a terminal, with text for people. Asked before there is one.
Result<void> may_show_phrase(bool json);
/// Shows it once, on standard output.
void show_phrase(std::string_view phrase);

/// Asks on the terminal; only `y` or `yes`, in upper or lower case, is yes. kInvalid: standard input is no terminal.
Result<bool> confirmed(const std::string& question);

}  // namespace rubicon::cli::trust
