#!/usr/bin/env bash
# A KNX bus without hardware, for examples/knx.yaml: knxd with its dummy driver on UDP port 13671, a lamp at 1/0/1 that
# reports at 1/0/2, and a thermometer at 1/2/7. Ends with SIGTERM or Ctrl-C, and everything with it.
# knxd listens on all interfaces of this machine; behind it there is nothing but this demo. It joins the multicast group of
# KNX too, which needs a route to it: any default route will do.
set -euo pipefail
folder=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=
users=()

# Its users end before the bus: what they have just begun comes to its end.
stop() {
  trap '' INT TERM
  trap - EXIT
  for job in "${users[@]}" $(jobs -p); do
    kill "$job" 2>/dev/null || true
    wait "$job" 2>/dev/null || true
  done
  [ -z "$work" ] || rm -rf "$work"
}
trap 'code=$?; stop; exit "$code"' EXIT
trap 'exit 0' INT TERM
work=$(mktemp -d "${TMPDIR:-/tmp}/rubicon-knx.XXXXXX")
bus=local:$work/bus.sock

say() { echo "knx-bus.sh: $*" >&2; }

# Why knxd ended; its own words do not say it.
explain() {
  cat "$work/log" >&2
  if command -v ip >/dev/null && ! ip -4 route get 224.0.23.12 >/dev/null 2>&1; then
    say "knxd ended: this host has no route to the multicast group 224.0.23.12, which knxd joins." \
      "Give it a default route, or: ip route add 224.0.23.12 dev INTERFACE"
  else
    say "knxd ended, its words are above; is UDP port 13671 taken?"
  fi
  exit 1
}

for program in knxd knxtool; do
  command -v "$program" >/dev/null || { say "$program is missing: install the packages knxd and knxd-tools"; exit 1; }
done

sed "s#^path = .*#path = $work/bus.sock#" "$folder/knxd.ini" >"$work/knxd.ini"
knxd "$work/knxd.ini" 2>"$work/log" &
server=$!
for _ in $(seq 100); do
  [ -S "$work/bus.sock" ] && break
  kill -0 "$server" 2>/dev/null || explain
  sleep 0.05
done
# It opens its socket before it joins the group.
sleep 0.2
kill -0 "$server" 2>/dev/null || explain

# `Write from 1.1.204 to 1/0/1: 01`
lamp() {
  trap 'exit 0' TERM
  while read -r what _ _ _ address value; do
    [ "$what $address" = "Write 1/0/1:" ] && knxtool groupswrite "$bus" 1/0/2 "$value" >/dev/null
  done
}
exec {heard}< <(exec knxtool groupsocketlisten "$bus")
users+=("$!")
lamp <&"$heard" &
users+=("$!")
exec {heard}<&-

# 20.9 to 22 degrees Celsius, as DPT 9.001
thermometer() {
  trap 'exit 0' TERM
  exec {pause}<> <(:)  # a pause without a child that would outlive it
  while true; do
    for value in '0c 15' '0c 1f' '0c 29' '0c 33' '0c 3d' '0c 47' '0c 4c' '0c 42' '0c 38' '0c 2e' '0c 24' '0c 1a'; do
      # shellcheck disable=SC2086
      knxtool groupwrite "$bus" 1/2/7 $value >/dev/null
      read -rt 5 -u "$pause" _ || true
    done
  done
}
thermometer &
users+=("$!")
wait "$server" || explain
