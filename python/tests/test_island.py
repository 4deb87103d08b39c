"""Against the real server, over WebSocket and HTTP."""

import asyncio
import importlib.util
import os
import subprocess
import sys
import unittest
from unittest import mock

import rubicon

from .island import PYTHONPATH, Island, first, needs_island, open_space

LIGHT = "proxy.dummy-rooms.living.sensor.light-1.value"


class Calls:
    """What both doors do alike."""

    @classmethod
    def setUpClass(cls):
        cls.island = Island("history={file: home.history}")

    @classmethod
    def tearDownClass(cls):
        cls.island.end()

    async def asyncSetUp(self):
        self.space = await self.open_space()

    async def asyncTearDown(self):
        await self.space.close()

    async def fails(self, code, call):
        with self.assertRaises(rubicon.Error) as caught:
            await call
        self.assertEqual(caught.exception.code, code, caught.exception)
        return caught.exception

    async def test_islands_and_devices(self):
        (island,) = await self.space.islands()
        self.assertEqual((island.id, island.name, island.networks["dummy-rooms"]), (6541, "home", 2))
        self.assertEqual([one.id for one in await self.space.devices(type="temperature")], ["bedroom"])
        self.assertEqual([one.name for one in await self.space.devices(area="Up*", island="home")], ["Bedroom"])
        self.assertEqual(await self.space.devices(name="nobody"), [])

    async def test_a_device_with_its_points(self):
        for name in ("living", "Living room", "dummy-rooms.living", "home:living", "proxy.dummy-rooms.living"):
            with self.subTest(name):
                device = await self.space.device(name)
                self.assertEqual(device.key, "proxy.dummy-rooms.living")
                self.assertEqual(device["light-1"].unit, "lx")
        error = await self.fails("not-found", self.space.device("livng"))
        self.assertIn("living", error.candidates)

    async def test_names_that_fit_nothing_or_several_give_candidates(self):
        error = await self.fails("not-found", self.space.get("living.light-2"))
        self.assertEqual(error.candidates[0], "living.light-1")
        error = await self.fails("not-found", self.space.command("living.lamp-7", "on"))
        self.assertEqual(error.candidates[0], "living.lamp-1")
        await self.fails("not-found", self.space.command("living.light-1", "on"))
        error = await self.fails("not-found", self.space.get("hom:living.light-1"))
        self.assertEqual(error.candidates, ("home",))
        await self.fails("not-found", first(self.space.watch("nobody.light-1")))
        await self.fails("not-found", self.space.get("two words"))
        await self.fails("invalid", self.space.get("two..dots"))
        error = await self.fails("not-found", self.space.get("Living rom.light-1"))
        self.assertEqual(error.candidates[0], "Living room.light-1")

    async def test_names_that_people_give(self):
        for name in ("Living room.light-1", "living ROOM.light", "home:Living room.light-1", "living.light"):
            with self.subTest(name):
                self.assertEqual((await self.space.get(name)).key, LIGHT)
        self.assertEqual((await self.space.command("Living room.lamp", "on")).state, "confirmed")
        self.assertEqual(len(await self.space.read("Living room.l*")), 2)
        self.assertEqual((await self.space.device("UPSTAIRS")).id, "bedroom")
        await self.fails("not-found", self.space.command("Living room.light", "on"))

    async def test_a_watch_wakes_sensors_and_ends_when_it_is_left(self):
        event = await first(self.space.watch("living.light-1"), lambda event: event.good)
        self.assertTrue(40 <= event.value <= 320)
        self.assertEqual((event.unit, event.type, event.key, event.owner), ("lx", "light", LIGHT, 6541))
        self.assertIsNotNone(event.heard)
        await asyncio.sleep(0.1)
        self.assertEqual(self.space._door._streams, {}, "the demand ended")

    async def test_a_pattern_within_a_part_wakes_only_what_matches(self):
        event = await first(self.space.watch("proxy.*.*.sensor.temperature-*.value"), lambda event: event.good)
        self.assertEqual(event.name, "bedroom.temperature-bed")
        self.assertFalse((await self.space.get("bedroom.contact-1")).good)

    async def test_a_passive_watch_wakes_nothing(self):
        async with self.space.watch("bedroom.*", passive=True) as watch:
            with self.assertRaises(asyncio.TimeoutError):
                await asyncio.wait_for(first(watch, lambda event: "contact" in event.key), 0.5)

    async def test_commands_and_their_outcomes(self):
        for value, shown in (("on", True), (False, False), (True, True)):
            outcome = await self.space.command("living.lamp-1", value)
            self.assertEqual((outcome.state, outcome.good), ("confirmed", True), outcome)
            self.assertIs((await self.space.get("living.lamp-1")).value, shown)
        outcome = await self.space.command("living.lamp-1", "purple")
        self.assertEqual(outcome.state, "refused")
        self.assertIn(outcome.code, ("refused", "invalid"))
        with self.assertRaises(rubicon.Refused) as caught:
            await self.space.command("living.lamp-1", "purple", check=True)
        self.assertIn("purple", str(caught.exception))
        outcome = await self.space.command("living.boiler-1", "on", wait="3s")
        self.assertIn(outcome.state, ("queued", "sent"))
        self.assertEqual((await self.space.command("living.rate", 60)).state, "confirmed")
        await self.fails("not-found", self.space.command("lamp-1", "on"))

    async def test_ambiguous_names(self):
        error = await self.fails("invalid", self.space.command("*.lamp-1", "on"))
        self.assertEqual(error.candidates, ("6541:proxy.dummy-rooms.bedroom.actuator.lamp-1.command",
                                            "6541:proxy.dummy-rooms.living.actuator.lamp-1.command"))

    async def test_tuples_of_the_island(self):
        self.assertEqual((await self.space.get("proxy.island")).value, {"id": 6541, "name": "home"})
        keys = [one.key for one in await self.space.read("proxy.dummy-rooms.*.status")]
        self.assertEqual(keys, ["proxy.dummy-rooms.bedroom.status", "proxy.dummy-rooms.living.status"])
        self.assertEqual((await first(self.space.watch("proxy.island"))).value["id"], 6541)
        self.assertIn("dummy-rooms", await self.space.settings())
        lines = await self.space.log()
        self.assertTrue(any("is up" in line.text for line in lines), lines)

    async def test_sets_appends_and_messages_that_the_island_refuses(self):
        await self.fails("refused", self.space.set(f"6541:{LIGHT}", 5))
        await self.fails("refused", self.space.append("6541:proxy.island", "x"))
        await self.fails("unreachable", self.space.send("home", "chat", "hello"))
        await self.fails("not-found", self.space.set("70001:a.b", "c"))

    async def test_the_inbox(self):
        self.assertEqual([(one.key, one.state) for one in await self.space.inbox()],
                         [("dummy-new.guest", "waiting"), ("dummy-new.stranger", "waiting")])
        await self.space.approve("dummy-new.guest")
        await self.space.ignore("dummy-new.stranger")
        for _ in range(100):
            inbox = await self.space.inbox()
            if [(one.key, one.state) for one in inbox] == [("dummy-new.stranger", "ignored")]:
                break
            await asyncio.sleep(0.05)
        else:
            self.fail(inbox)
        await self.fails("not-found", self.space.approve("dummy-new.nobody"))

    async def test_a_watch_that_is_not_read_is_bounded(self):
        async with self.space.watch("living.light-1") as watch:
            await first(watch, lambda event: event.good)
            while watch.merged < 5:
                await asyncio.sleep(0.05)
            batch = await watch.batch()
            self.assertEqual(len(batch), 1)
            self.assertGreaterEqual(batch[0].merged, 4)
        await asyncio.sleep(0.1)
        self.assertEqual(self.space._door._streams, {}, "though the watch is not dropped yet")

@needs_island
class OverTheWeb(Calls, unittest.IsolatedAsyncioTestCase):
    def open_space(self):
        return open_space()

    async def test_the_history(self):
        await first(self.space.watch("living.light-1"), lambda event: event.good)
        for _ in range(100):
            try:
                rows = await self.space.samples("proxy.*.*.sensor.light-*.value", since="1min", every="1s")
                if rows:
                    break
            except rubicon.Error as error:
                self.assertEqual(error.code, "not-found")
            await asyncio.sleep(0.1)
        self.assertEqual(rows[0].key, f"6541:{LIGHT}")
        text = await self.space.export("living.light-1", since="1min", every="1s")
        self.assertRegex(text, rf"^time,key,.*\n\d+(\.\d+)?,6541:{LIGHT},")
        await self.fails("not-found", self.space.history("proxy.nothing.*.sensor.*.value"))
        try:
            import pandas
        except ImportError:
            self.skipTest("pandas is not installed")
        table = await self.space.history("living.light-1", since="1min", every="1s")
        self.assertIsInstance(table, pandas.DataFrame)
        self.assertEqual(table.attrs["units"], {LIGHT: "lx"})
        self.assertTrue(table[LIGHT].notna().any())

    async def test_calls_that_are_cancelled_leave_nothing(self):
        for call in (self.space.command("living.boiler-1", "on"), first(self.space.watch("living.lamp-1", passive=True)),
                     self.space.history("living.light-1", since="1min")):
            task = asyncio.ensure_future(call)
            await asyncio.sleep(0.02)
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)
        await asyncio.sleep(0.2)
        self.assertEqual(self.space._door._answers, {})
        self.assertEqual(self.space._door._streams, {})

    async def test_another_loop_is_an_error(self):
        def elsewhere():
            with self.assertRaisesRegex(rubicon.Error, "belongs to another event loop"):
                asyncio.run(self.space.islands())

        await asyncio.get_running_loop().run_in_executor(None, elsewhere)

    async def test_a_loop_that_was_closed(self):
        """A program that ran asyncio.run() twice; what it left open is dropped without a word."""
        code = ("import asyncio, gc, rubicon\nspace = rubicon.connect()\nwatch = None\n"
                "async def begin():\n    global watch\n    await space\n    watch = space.watch('living.*')\n"
                "    await watch.start()\nasyncio.run(begin())\n"
                "try:\n    asyncio.run(space.islands())\nexcept rubicon.Error as error:\n    print(error)\n"
                "watch = None\ngc.collect()\n")
        done = subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": PYTHONPATH},
                              capture_output=True, text=True, timeout=60)
        self.assertIn("belongs to another event loop", done.stdout)
        self.assertEqual(done.stderr, "")

    async def test_a_space_that_is_closed_says_so(self):
        watching = asyncio.ensure_future(first(self.space.watch("nothing.*", passive=True)))
        watching.cancel()
        space = await open_space()
        task = asyncio.ensure_future(first(space.watch("nothing.*", passive=True)))
        await asyncio.sleep(0.1)
        await space.close()
        self.assertIsNone(await task, "the watch ends")
        await self.fails("invalid", space.islands())
        await space.close()
        with self.assertRaisesRegex(rubicon.Error, "is not open"):
            await open_space().islands()
        with self.assertRaisesRegex(rubicon.Error, "async with"):
            with open_space():
                pass

    async def test_run_inside_a_loop_says_what_to_write(self):
        async def main():
            pass

        with self.assertRaisesRegex(rubicon.Error, "await main()"):
            rubicon.run(main())


    async def test_a_value_that_no_frame_can_carry(self):
        await self.fails("out-of-range", self.space.set("6541:proxy.x", "y" * 100_000))

    async def test_own_tuples_need_a_component(self):
        await self.fails("unsupported", self.space.own("a.b", 1))


@needs_island
@unittest.skipUnless(importlib.util.find_spec("rubicon._native"), "the native module is not built")
class AsAComponent(Calls, unittest.IsolatedAsyncioTestCase):
    def open_space(self):
        return rubicon.join(name="robot", folder=str(self.island.space_folder))

    async def test_there_is_no_history(self):
        await self.fails("unsupported", self.space.history("living.light-1"))

    async def test_own_tuples_are_seen_by_others(self):
        async with rubicon.join(folder=str(self.island.space_folder)) as other:
            self.assertEqual(await self.space.own("robot.place", "kitchen"), 1)
            self.assertEqual((await other.get("robot.place")).text, "kitchen")
            async with other.watch("robot.**") as watch:
                self.assertEqual((await first(watch)).value, "kitchen")
                self.assertEqual(await self.space.own("robot.place", {"x": 1}), 2)
                self.assertEqual((await first(watch)).value, {"x": 1})
                await self.space.erase("robot.place")
                self.assertEqual((await first(watch)).kind, "gone")
            with self.assertRaises(rubicon.Error) as caught:
                await self.space.own("two words", 1)
            self.assertEqual(caught.exception.code, "invalid")

    async def test_a_judge_decides_about_the_sets_of_others(self):
        async with rubicon.join(folder=str(self.island.space_folder)) as other:
            await self.space.own("robot.speed", 1)
            owner = self.space._door._component.id
            await self.refused(other, owner, "read-only")
            asked = []

            def judge(one):
                asked.append(one)
                return None if float(one.value) < 2 else "too fast"

            with self.space.judge("robot.speed", judge):
                self.assertEqual(await other.set(f"{owner}:robot.speed", 1.5), 2)
                await self.refused(other, owner, "too fast")
            self.assertEqual((asked[0].key, asked[0].sender), ("robot.speed", other._door._component.id))
            with self.space.judge("robot.speed", lambda one: 1 / 0), mock.patch("sys.unraisablehook") as raised:
                await self.refused(other, owner, "failed")
            raised.assert_called_once()

    async def refused(self, other, owner, why):
        with self.assertRaises(rubicon.Error) as caught:
            await other.set(f"{owner}:robot.speed", 5)
        self.assertEqual(caught.exception.code, "refused")
        self.assertIn(why, caught.exception.text)

    async def test_messages(self):
        async with rubicon.join(folder=str(self.island.space_folder)) as other:
            async with self.space.messages("chat") as messages:
                await other.send(self.space._door._component.id, "chat", b"h\xffllo")
                message = await messages.__anext__()
                self.assertEqual((message.data, message.sender), (b"h\xffllo", other._door._component.id))

    async def test_an_island_that_leaves_and_comes_back(self):
        async with self.space.watch("living.rate", passive=True) as watch:
            await first(watch)
            self.island.stop()
            self.assertEqual((await first(watch)).quality, "network-down")
            self.island.start()
            self.assertTrue((await first(watch, lambda event: event.good)).value)

    async def test_a_space_that_is_closed_ends_the_calls_that_wait(self):
        space = await rubicon.join(folder=str(self.island.space_folder))
        self.island.pause(True)
        try:
            waiting = asyncio.ensure_future(space.set("6541:proxy.inbox", "approve x", ttl=60))
            await asyncio.sleep(0.05)
            await space.close()
            await self.fails("invalid", asyncio.wait_for(waiting, 30))
        finally:
            self.island.pause(False)

    async def test_options_that_are_unsound(self):
        with self.assertRaises(rubicon.Error) as caught:
            await rubicon.join(id=5)
        self.assertEqual(caught.exception.code, "invalid", caught.exception)

    async def test_what_a_call_raises_does_not_stop_the_others(self):
        errors = []
        asyncio.get_running_loop().set_exception_handler(lambda loop, context: errors.append(context))
        component = self.space._door._component
        for _ in range(2):
            component.read("6541:proxy.island", 1.0, lambda rows: 1 / 0)
        self.assertEqual((await self.space.get("6541:proxy.island")).value["id"], 6541)
        await asyncio.sleep(0.1)
        self.assertEqual(len(errors), 2)


if __name__ == "__main__":
    unittest.main()
