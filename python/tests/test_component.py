"""How the native component is asked, without it."""

import asyncio
import sys
import types
import unittest
from unittest import mock

from rubicon import _component


class Owner:
    """A component that is answered while it waits, if anybody is quick."""

    def __init__(self, options):
        self.calls, self.waits, self.quick = [], 0, True

    def poll(self):
        pass

    def wait(self, patience):
        self.waits += 1
        if self.quick:
            self.answer()

    def read(self, pattern, patience, call):
        self.calls.append(call)

    def answer(self):
        for call in self.calls:
            call([])
        self.calls.clear()


class Requests(unittest.IsolatedAsyncioTestCase):
    def setUp(self):
        native = types.ModuleType("rubicon._native")
        native.Component = Owner
        with mock.patch.dict(sys.modules, {"rubicon._native": native}), \
                mock.patch("rubicon._native", native, create=True):
            self.door = _component.ComponentDoor({})
        self.owner = self.door._component = Owner({})

    async def asyncSetUp(self):
        self.turns = 0
        self.other = asyncio.ensure_future(self.count())
        await asyncio.sleep(0)

    async def asyncTearDown(self):
        self.other.cancel()

    async def count(self):
        while True:
            self.turns += 1
            await asyncio.sleep(0)

    async def test_a_quick_answer_needs_no_turn(self):
        self.door._turn = asyncio.get_running_loop().time() + 1000
        self.turns = 0
        for _ in range(100):
            await self.door.read("a.b")
        self.assertEqual((self.owner.waits, self.turns), (100, 0))

    async def test_others_run_between_requests_in_a_row(self):
        self.turns = 0
        with mock.patch.object(_component, "LONGEST_TURN", 0.0):
            for _ in range(100):
                await self.door.read("a.b")
        self.assertGreaterEqual(self.turns, 99)

    async def test_a_slow_owner_and_several_requests_at_once_stop_nobody(self):
        self.owner.quick = False
        asked = [asyncio.ensure_future(self.door.read("a.b")) for _ in range(5)]
        await asyncio.sleep(0)
        self.assertEqual((self.owner.waits, len(self.owner.calls)), (1, 5))
        self.owner.answer()
        self.assertEqual(await asyncio.gather(*asked), [[]] * 5)


if __name__ == "__main__":
    unittest.main()
