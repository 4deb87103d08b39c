#!/usr/bin/env bash
# Starts the daemon on examples/salad.yaml again and again and counts the devices its first answer lists, half of the times
# with SALAD's simulator beside it: bench/salad_starts.sh [STARTS [BUILD]]
# The original showed 55, 55, 44, 47, 16, 55 and 55 of 55 in 7 starts.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/../scripts/common.sh"

starts=${1:-100}
programs=$root/build/${2:-install}/bin
flat=$root/examples/salad.yaml
wanted=55

# A network of one's own, if one may have it: the ports of the flat meet nobody.
if [ -z "${RUBICON_ALONE:-}" ] && unshare --net true 2>/dev/null; then
  exec env RUBICON_ALONE=1 unshare --net "$0" "$@"
fi
[ -z "${RUBICON_ALONE:-}" ] || ip link set lo up

simulator=
trap '[ -z "$simulator" ] || kill "$simulator"' EXIT
good=0
for ((i = 1; i <= starts; ++i)); do
  if [ "$i" -eq $((starts / 2 + 1)) ]; then
    "$programs/salad-simulator" "$flat" --log-level off >/dev/null &
    simulator=$!
  fi
  shown=$(printf 'devices\nquit\n' | "$programs/rubicon-proxy" run "$flat" --set tuples.engine=memory --shell --log-level off | grep -c '"device":"proxy.salad\.') || true
  if [ "$shown" -eq "$wanted" ]; then good=$((good + 1)); else echo "start $i shows $shown of $wanted"; fi
done
echo "$good of $starts starts show all $wanted devices in their first answer"
[ "$good" -eq "$starts" ]
