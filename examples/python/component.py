#!/usr/bin/env python3
"""A component of its own, without a server: its tuple tells the warmest room, and others may set its limit.
It needs the native module (Debian: python3-rubicon-native): component.py [COUNT]"""

import sys

import rubicon


async def main(count="0"):
    async with rubicon.join(name="warmest") as space:
        await space.own("warmest.limit", 25.0)

        def may_set(asked):  # returns why not; None accepts
            return None if float(asked.value) < 40 else "the limit is below 40 °C"

        rooms = {}
        left = int(count)
        with space.judge("warmest.limit", may_set):
            async for event in space.watch("*.temperature-*", minimum="1s"):
                rooms[event.name] = event.value
                name = max(rooms, key=rooms.get)
                await space.own("warmest.room", f"{name} {rooms[name]:.1f}")
                print("warmest:", name, rooms[name], flush=True)
                left -= 1
                if not left:
                    break


rubicon.run(main(*sys.argv[1:]))
