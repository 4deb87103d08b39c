# bash completion for rubicon-proxy                                                              -*- shell-script -*-

_rubicon_proxy() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[1]} choices=""
  if [ "$COMP_CWORD" -eq 1 ]; then
    choices="run check state networks recording --help --version"
  elif [ "$before" = --log-level ]; then
    choices="debug info warning error off"
  elif [ "$command" = state ] && [ "$COMP_CWORD" -eq 3 ]; then
    choices="show export import forget"
  elif [ "$command" = recording ] && [ "$COMP_CWORD" -eq 3 ]; then
    choices="info export"
  elif [[ $word == -* ]]; then
    case $command in
      run) choices="--set --watch --tuple --shell --log-level --help" ;;
      check) choices="--set --diff --elsewhere --help" ;;
      state) choices="--out --force --help" ;;
      recording) choices="--csv --jsonl --pattern --out --help" ;;
    esac
  else
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
    return
  fi
  mapfile -t COMPREPLY < <(compgen -W "$choices" -- "$word")
}
complete -F _rubicon_proxy rubicon-proxy
