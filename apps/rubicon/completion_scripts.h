#pragma once

namespace rubicon::cli {

// The program itself knows what may follow: `rubicon complete`. A word that ends with a dot goes on. Without an offer
// shells offer names of files, but not if the program says kNoFiles.

inline constexpr const char* kNoFiles = "!";

inline constexpr const char* kBashCompletion = R"script(# bash completion of rubicon
_rubicon() {
  local line=${COMP_LINE:0:COMP_POINT} typed offers
  local -a words
  # Colons are parts of names here, whatever COMP_WORDBREAKS says.
  read -ra words <<<"$line"
  [[ $line == *[[:space:]] ]] && words+=("")
  typed=${words[-1]}
  mapfile -t offers < <(command "${words[0]}" complete -- "${words[@]:1}" 2>/dev/null)
  [[ ${#offers[@]} -eq 1 && ${offers[0]} == '!' ]] && { compopt +o bashdefault +o default; COMPREPLY=(); return 0; }
  local cut=
  [[ $COMP_WORDBREAKS == *:* && $typed == *:* ]] && cut=${typed%"${typed##*:}"}
  COMPREPLY=("${offers[@]#"$cut"}")
  [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *. ]] && compopt -o nospace
  [[ ${#COMPREPLY[@]} -eq 1 && -z ${COMPREPLY[0]} ]] && COMPREPLY=()
  return 0
}
complete -o bashdefault -o default -F _rubicon rubicon
)script";

inline constexpr const char* kZshCompletion = R"script(#compdef rubicon
_rubicon() {
  local -a offers whole parts
  offers=("${(@f)$(command ${words[1]} complete -- "${(@)words[2,CURRENT]}" 2>/dev/null)}")
  offers=(${offers:#})
  (( $#offers )) || { _files; return; }
  [[ "$offers" == '!' ]] && return
  whole=(${offers:#*.})
  parts=(${(M)offers:#*.})
  (( $#whole )) && compadd -Q -- $whole
  (( $#parts )) && compadd -Q -S '' -- $parts
}
if [ "$funcstack[1]" = "_rubicon" ]; then _rubicon "$@"; else compdef _rubicon rubicon; fi
)script";

}  // namespace rubicon::cli
