#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "rubicon/key.hpp"

namespace rubicon::cli {

/// What only the islands know.
enum class Wanted { kNothing, kTuple, kDevice, kComponent, kWaiting };
/// What stands behind these words.
Wanted wanted_at(const std::vector<std::string>& before);

/// Subcommands, options and words of options, as far as the command line itself says.
std::vector<std::string> fixed_offers(const CLI::App& app, const std::vector<std::string>& before,
                                      const std::string& typed);

/// Which tuples tell how a key that was typed so far may go on, without asking for everything.
std::vector<Pattern> questions_for(const std::string& typed, const std::string& prefix);
/// `proxy.wsn-1.7.status` -> `proxy.wsn-1.` for `proxy.w`; empty if it does not go on so.
std::string next_step(const std::string& name, const std::string& typed);

}  // namespace rubicon::cli
