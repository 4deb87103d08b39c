#!/usr/bin/env python3
"""Commands a device and shows what became of it, for cron: command.py NAME VALUE. Exit code 1: it did not happen."""

import sys

import rubicon.sync

try:
    with rubicon.sync.connect() as space:
        outcome = space.command(sys.argv[1], sys.argv[2], ttl="5s", wait="15s")
except rubicon.Error as error:
    sys.exit(str(error))
print(outcome.state, outcome.reason)
sys.exit(0 if outcome.good else 1)
