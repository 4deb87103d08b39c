#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "rubicon/key.hpp"

namespace rubicon::cli {

/// What to ask the islands for; kMember is in the folder of the realm. Where nothing is offered, shells offer names of
/// files, but not for members and kNoFile.
enum class Wanted { kNothing, kTuple, kValue, kDevice, kComponent, kWaiting, kMember, kNoFile };
struct Question {
  Wanted wanted = Wanted::kNothing;
  std::string tuple;  ///< the tuple whose values are offered
};
/// What the next word after these may be.
Question wanted_at(const CLI::App& app, const std::vector<std::string>& before);

/// The words that a value may be, by the JSON that describes its point; none for numbers.
std::vector<std::string> value_words(const std::string& description);

/// Subcommands, options and words of options, as far as the command line itself says.
std::vector<std::string> fixed_offers(const CLI::App& app, const std::vector<std::string>& before,
                                      const std::string& typed);

/// Which tuples tell how a key that was typed so far may go on, without asking for everything.
std::vector<Pattern> questions_for(const std::string& typed, const std::string& prefix);
/// `proxy.wsn-1.7.status` -> `proxy.wsn-1.` for `proxy.w`; empty if it does not go on so.
std::string next_step(const std::string& name, const std::string& typed);

}  // namespace rubicon::cli
