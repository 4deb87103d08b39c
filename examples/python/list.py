#!/usr/bin/env python3
"""Lists the devices of all islands, and the values of one: list.py [DEVICE]"""

import sys

import rubicon.sync

with rubicon.sync.connect() as space:
    for island in space.islands():
        print(f"{island.id} {island.name}: {island.devices} devices, {island.program} on {island.host}")
    if len(sys.argv) > 1:
        print(space.device(sys.argv[1]))
    else:
        for device in space.devices(type="temperature"):
            print(device)
