#!/usr/bin/env python3
"""Prints values as they come, with a warning where one cannot be trusted: watch.py [PATTERN [COUNT]]"""

import sys

import rubicon


async def main(pattern="*.temperature-*", count="20"):
    async with rubicon.connect() as space:
        left = int(count)
        async for event in space.watch(pattern, minimum="1s"):  # wakes the sensors; passive=True does not
            doubt = "" if event.good else f"  {event.quality} {event.reason}"
            print(f"{event.time:%H:%M:%S}  {event.name:24}  {event}{doubt}", flush=True)
            left -= 1
            if not left:
                break


rubicon.run(main(*sys.argv[1:]))
