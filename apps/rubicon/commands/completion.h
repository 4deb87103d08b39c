#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/key.hpp"

namespace rubicon::cli {

// The program itself knows what may follow: `rubicon complete`. A word that ends with a dot goes on. Without an offer
// shells offer names of files, but not if the program says kNoFiles.

inline constexpr const char* kNoFiles = "!";

inline constexpr const char* kBashCompletion = R"script(# bash completion of rubicon
_rubicon() {
  local line=${COMP_LINE:0:COMP_POINT} colon=
  local -a offers
  # The program splits the line, because COMP_WORDS is cut at colons, which are parts of names here.
  [[ $COMP_WORDBREAKS == *:* ]] && colon=--cut
  mapfile -t offers < <(command "${line%%[[:space:]]*}" complete --line "$line" $colon 2>/dev/null)
  [[ ${#offers[@]} -eq 1 && ${offers[0]} == '!' ]] && { compopt +o bashdefault +o default; COMPREPLY=(); return 0; }
  COMPREPLY=("${offers[@]}")
  [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *. ]] && compopt -o nospace
  [[ ${#COMPREPLY[@]} -eq 1 && -z ${COMPREPLY[0]} ]] && COMPREPLY=()
  return 0
}
complete -o bashdefault -o default -F _rubicon rubicon
)script";

inline constexpr const char* kZshCompletion = R"script(#compdef rubicon
_rubicon() {
  local -a offers whole parts
  offers=("${(@f)$(command ${words[1]} complete -- "${(@Q)words[2,CURRENT-1]}" "${(Q)PREFIX}" 2>/dev/null)}")
  offers=(${offers:#})
  (( $#offers )) || { _files; return; }
  [[ "$offers" == '!' ]] && return
  whole=(${offers:#*.})
  parts=(${(M)offers:#*.})
  (( $#whole )) && compadd -- $whole
  (( $#parts )) && compadd -S '' -- $parts
}
if [ "$funcstack[1]" = "_rubicon" ]; then _rubicon "$@"; else compdef _rubicon rubicon; fi
)script";

/// A command line up to the cursor, as a shell splits it.
struct ShellLine {
  std::vector<std::string> words;  ///< without quotes and backslashes; the last one is not finished, and may be empty
  bool is_quoted = false;          ///< a quote is open
};
ShellLine split_line(std::string_view line);
/// An offer in the form that bash puts into its line in place of `typed`. `cut`: bash replaces only what stands behind
/// the last colon, unless a quote is open.
std::string for_bash(std::string_view offer, std::string_view typed, bool is_quoted, bool cut);

/// What to ask the islands for; kMember is in the folder of the realm. If there is no suggestion, shells offer names of
/// files, except for members and kNoFile.
enum class Wanted {
  kNothing,
  kTuple,
  kSettable,
  kValue,
  kDevice,
  kType,
  kIsland,
  kComponent,
  kWaiting,
  kMember,
  kNoFile
};
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

/// `NAME.` as long as the name is being typed, then `NAME.POINT`; empty if it does not go on so.
std::string next_name(const std::string& name, const std::string& point, const std::string& typed);

/// Which tuples tell how a key that was typed so far may go on, without asking for everything.
std::vector<Pattern> questions_for(const std::string& typed, const std::string& prefix);
/// `proxy.wsn-1.7.status` -> `proxy.wsn-1.` for `proxy.w`; empty if it does not go on so.
std::string next_step(const std::string& name, const std::string& typed);

}  // namespace rubicon::cli
