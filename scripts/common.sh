# Sourced by ./run and ./test: reports progress, installs missing packages, configures and builds a preset.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# A clone in another folder finds what this one compiled.
export CCACHE_BASEDIR=$root CCACHE_NOHASHDIR=1

say() { printf '[%s] %s\n' "$(basename "$0")" "$*" >&2; }

# apart PROGRAM ARGUMENTS... &: in a session of its own, which signals from the terminal do not reach. $! is its process.
apart() { exec setsid "$@"; }

# Who may install packages, as a command to put in front: nothing for root, sudo, or `false` for anybody else.
root_command() {
  if [ "$(id -u)" -eq 0 ]; then echo
  elif command -v sudo >/dev/null; then echo sudo
  else echo false
  fi
}

# installed PACKAGE...: those that dpkg has, one on each line.
installed() {
  { dpkg-query -W -f='${Package} ${Status}\n' "$@" 2>/dev/null || true; } | awk '/install ok installed/ {print $1}'
}

# install_missing LIST...: installs what is missing of scripts/packages-LIST.txt.
install_missing() {
  local wanted missing as_root
  mapfile -t wanted < <(cd "$root/scripts" && lists=("${@/#/packages-}") && cat "${lists[@]/%/.txt}" | grep -vE '^(#|$)' | sort -u)
  mapfile -t missing < <(comm -23 <(printf '%s\n' "${wanted[@]}") <(installed "${wanted[@]}" | sort))
  [ "${#missing[@]}" -eq 0 ] && return
  as_root=$(root_command)
  if ! $as_root apt-get --version >/dev/null; then  # `false` fails, and sudo for those who may not use it
    say "${#missing[@]} packages are missing, and only root can install them. As root, run:"
    install_command "${missing[@]}" >&2
    say "Then run $0 again."
    exit 1
  fi
  say "installing ${#missing[@]} missing packages: ${missing[*]}"
  $as_root apt-get update -qq || apt_failed update "${missing[@]}"
  install_without_starting "$as_root" "${missing[@]}" || apt_failed install "${missing[@]}"
}

install_command() { printf '%s\n' "apt-get install --no-install-recommends $*"; }

# apt_failed update|install PACKAGE...: ends the program.
apt_failed() {
  local command=$1
  shift
  say "apt-get $command failed; it says above why. It needs the network and the package sources in /etc/apt. Correct what it reports and"
  say "run $0 again, or install the $# missing packages by other means:"
  install_command "$@" >&2
  exit 1
}

# Services that packages bring (knxd, mosquitto) must not start: the tests start their own, in networks of their own.
install_without_starting() (
  as_root=$1
  shift
  policy=/usr/sbin/policy-rc.d
  if [ ! -e "$policy" ]; then
    trap '$as_root rm -f "$policy"' EXIT
    $as_root tee "$policy" >/dev/null <<<$'#!/bin/sh\nexit 101' || exit 1
    $as_root chmod 755 "$policy" || exit 1
  fi
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >&2 || exit 1
  command -v systemctl >/dev/null || return 0
  if [[ " $* " == *" knxd "* ]]; then
    $as_root systemctl --quiet disable knxd.socket knxd.service || true
  fi
  if [[ " $* " == *" mosquitto "* ]]; then
    $as_root systemctl --quiet disable mosquitto.service || true
  fi
)

# How many compilers run at a time: one for each processor, and each may take 2.5 GB of memory.
jobs() {
  local megabytes jobs
  megabytes=$(awk '/^MemTotal:/ {print int($2 / 1024)}' /proc/meminfo)
  jobs=$(nproc)
  [ $((jobs * 2500)) -le "$megabytes" ] || jobs=$((megabytes / 2500))
  echo $((jobs > 0 ? jobs : 1))
}

# yardstick: processor time in milliseconds that one fixed file takes to compile here and now; nothing where it does not compile.
yardstick() {
  local TIMEFORMAT='%U %S'
  mkdir -p "$root/build"
  { time g++ -std=c++20 -Og -c "$root/bench/build/yardstick.cpp" -o "$root/build/yardstick.o" 2>/dev/null; } 2>&1 |
    awk '{print int(($1 + $2) * 1000)}'
}

# expect_minutes: says how long the first build of the demo takes here, and sets $expected to the time in seconds since 1970 when it
# ends: the compilation of one file tells how fast this machine is now. Does nothing where there is a build already.
demo_yardsticks=140
expect_minutes() {
  [ ! -f "$root/build/release/build.ninja" ] || return 0
  local seconds
  seconds=$(($(yardstick) * demo_yardsticks / 1000 / $(jobs)))
  expected=$(($(date +%s) + seconds))
  say "the first build takes about $(((seconds + 59) / 60)) min on this machine; later ones take seconds"
}

# time_left: `, about 3 min left`, or nothing where no time is expected.
time_left() {
  local left=$((${expected:-0} - $(date +%s)))
  [ -n "${expected:-}" ] || return 0
  if [ "$left" -gt 90 ]; then printf ', about %d min left' $(((left + 59) / 60))
  elif [ "$left" -gt 0 ]; then printf ', about %d s left' "$left"
  fi
}

# show_progress FILE PATTERN PID: while the process runs, shows `n of m` from the last line of the file that matches the
# pattern, and the time left: on a terminal in one line that changes, otherwise as a line every 30 seconds.
show_progress() {
  local file=$1 pattern=$2 pid=$3 now= shown= turns=0
  while kill -0 "$pid" 2>/dev/null; do
    sleep 0.2
    turns=$((turns + 1))
    now=$(tail -c 4000 "$file" 2>/dev/null | grep -E "$pattern" | tail -n 1 | grep -oE '[0-9]+/[0-9]+' | head -n 1) || true
    [ -n "$now" ] || continue
    if [ -t 2 ]; then
      [ "$now$(time_left)" != "$shown" ] || continue
      shown=$now$(time_left)
      printf '\r\033[K[%s] %s of %s%s ' "$(basename "$0")" "${now%/*}" "${now#*/}" "$(time_left)" >&2
    elif [ $((turns % 150)) -eq 0 ] && [ "$now" != "$shown" ]; then
      say "${now%/*} of ${now#*/}$(time_left)"
      shown=$now
    fi
  done
  [ ! -t 2 ] || [ -z "$shown" ] || printf '\r\033[K' >&2
}

# build PRESET [TARGET...]: what the preset demo builds lies in build/release.
build() {
  local preset=$1 directory=$root/build/${1/#demo/release}
  shift
  if [ ! -f "$directory/build.ninja" ]; then
    say "configuring ${directory#"$root"/}"
    (cd "$root" && cmake --preset "$preset" >"$root/build-$preset.log" 2>&1) || { cat "$root/build-$preset.log" >&2; exit 1; }
    mv "$root/build-$preset.log" "$directory/configure.log"
  fi
  say "building ${directory#"$root"/}"
  cmake --build "$directory" --parallel "$(jobs)" --target "${@:-all}" >"$directory/build.log" 2>&1 &
  show_progress "$directory/build.log" '^\[[0-9]+/[0-9]+\]' $!
  wait $! || { tail -n 60 "$directory/build.log" >&2; say "building failed: ${directory#"$root"/}/build.log"; exit 1; }
}
