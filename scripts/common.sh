# Sourced by ./run and ./test: says what is done, installs missing packages, configures and builds a preset.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# A clone elsewhere finds what this one compiled.
export CCACHE_BASEDIR=$root CCACHE_NOHASHDIR=1

say() { printf '[%s] %s\n' "$(basename "$0")" "$*" >&2; }

as_root() {
  if [ "$(id -u)" -eq 0 ]; then "$@"
  elif command -v sudo >/dev/null; then sudo "$@"
  else
    say "missing packages and neither root nor sudo; install them by hand: ${missing[*]}"
    exit 1
  fi
}

install_missing() {
  local wanted present
  mapfile -t wanted < <(grep -vE '^(#|$)' "$root/scripts/packages.txt")
  # dpkg-query fails where it does not know one of them: that is what we are here for.
  present=$({ dpkg-query -W -f='${Package} ${Status}\n' "${wanted[@]}" 2>/dev/null || true; } | awk '/install ok installed/ {print $1}')
  mapfile -t missing < <(comm -23 <(printf '%s\n' "${wanted[@]}" | sort) <(printf '%s\n' "$present" | sort))
  [ "${#missing[@]}" -eq 0 ] && return
  say "installing ${#missing[@]} missing packages: ${missing[*]}"
  as_root apt-get update -qq
  install_without_starting
}

# Tests start knxd themselves, where it meets nobody: neither its installation nor the machine's next start shall.
install_without_starting() (
  policy=/usr/sbin/policy-rc.d
  if [ ! -e "$policy" ]; then
    trap 'as_root rm -f "$policy"' EXIT
    printf '#!/bin/sh\nexit 101\n' | as_root tee "$policy" >/dev/null
    as_root chmod 755 "$policy"
  fi
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >&2
  if [[ " ${missing[*]} " == *" knxd "* ]] && command -v systemctl >/dev/null; then
    as_root systemctl --quiet disable knxd.socket knxd.service || true
  fi
)

# show_progress FILE PATTERN PID: while the process runs, how far it is by the last line of the file that begins so; on a
# terminal one line that changes, else a line each half a minute.
show_progress() {
  local file=$1 pattern=$2 pid=$3 now= shown= turns=0
  while kill -0 "$pid" 2>/dev/null; do
    sleep 0.2
    turns=$((turns + 1))
    now=$(tail -c 4000 "$file" 2>/dev/null | grep -E "$pattern" | tail -n 1 | grep -oE '[0-9]+/[0-9]+' | head -n 1) || true
    [ -n "$now" ] && [ "$now" != "$shown" ] || continue
    if [ -t 2 ]; then
      printf '\r[%s] %s of %s ' "$(basename "$0")" "${now%/*}" "${now#*/}" >&2
      shown=$now
    elif [ $((turns % 150)) -eq 0 ]; then
      say "${now%/*} of ${now#*/}"
      shown=$now
    fi
  done
  [ ! -t 2 ] || [ -z "$shown" ] || printf '\r\033[K' >&2
}

# build PRESET [TARGET...]
build() {
  local preset=$1 directory=$root/build/$1
  shift
  if [ ! -f "$directory/build.ninja" ]; then
    say "configuring build/$preset"
    (cd "$root" && cmake --preset "$preset" >"$root/build-$preset.log" 2>&1) || { cat "$root/build-$preset.log" >&2; exit 1; }
    mv "$root/build-$preset.log" "$directory/configure.log"
  fi
  say "building build/$preset"
  cmake --build "$directory" --target "${@:-all}" >"$directory/build.log" 2>&1 &
  show_progress "$directory/build.log" '^\[[0-9]+/[0-9]+\]' $!
  wait $! || { tail -n 60 "$directory/build.log" >&2; say "building build/$preset failed: build/$preset/build.log"; exit 1; }
}
