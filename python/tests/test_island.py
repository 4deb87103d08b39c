"""Against the real server, over WebSocket and HTTP."""

import asyncio
import gc
import importlib.util
import os
import signal
import ssl
import subprocess
import sys
import threading
import time
import tracemalloc
import unittest
from unittest import mock

import rubicon
import rubicon.sync
from rubicon import _web

from .island import PROGRAMS, PYTHONPATH, Island, needs_island

LIGHT = "proxy.dummy-rooms.living.sensor.light-1.value"


def open_space(**options):
    return rubicon.connect("http://127.0.0.1:8642", **options)


async def first(watch, wanted=lambda event: True):
    """The first event that is wanted; None when the watch ends. What does not come fails the test."""

    async def found():
        async for event in watch:
            if wanted(event):
                return event

    return await asyncio.wait_for(found(), 60)


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
        await self.fails("invalid", self.space.get("two words"))

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
        outcome = await self.space.command("living.boiler-1", "on", wait="200ms")
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
        return rubicon.join(name="robot", folder=str(self.island.space_folder), trust="no")

    async def test_there_is_no_history(self):
        await self.fails("unsupported", self.space.history("living.light-1"))

    async def test_own_tuples_are_seen_by_others(self):
        async with rubicon.join(folder=str(self.island.space_folder), trust="no") as other:
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
        async with rubicon.join(folder=str(self.island.space_folder), trust="no") as other:
            await self.space.own("robot.speed", 1)
            owner = self.space._door._component.id
            await self.refused(other, owner, "read-only")
            wishes = []

            def judge(wish):
                wishes.append(wish)
                return None if float(wish.value) < 2 else "too fast"

            with self.space.judge("robot.speed", judge):
                self.assertEqual(await other.set(f"{owner}:robot.speed", 1.5), 2)
                await self.refused(other, owner, "too fast")
            self.assertEqual((wishes[0].key, wishes[0].sender), ("robot.speed", other._door._component.id))
            with self.space.judge("robot.speed", lambda wish: 1 / 0), mock.patch("sys.unraisablehook") as raised:
                await self.refused(other, owner, "failed")
            raised.assert_called_once()

    async def refused(self, other, owner, why):
        with self.assertRaises(rubicon.Error) as caught:
            await other.set(f"{owner}:robot.speed", 5)
        self.assertEqual(caught.exception.code, "refused")
        self.assertIn(why, caught.exception.text)

    async def test_messages(self):
        async with rubicon.join(folder=str(self.island.space_folder), trust="no") as other:
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


@needs_island
class AServerThatRestarts(unittest.IsolatedAsyncioTestCase):
    def setUp(self):
        self.island = Island()
        self.addCleanup(self.island.end)

    async def test_watches_go_on(self):
        async with open_space() as space, space.watch("living.rate", passive=True) as watch:
            self.assertEqual((await first(watch)).value, 50)
            self.island.stop()
            while space.state == "live":
                await asyncio.sleep(0.05)
            self.assertEqual(space.state, "lost")
            with self.assertRaises(rubicon.Error) as caught:
                await space.islands()
            self.assertEqual(caught.exception.code, "unreachable")
            self.island.start()
            event = await first(watch)
            self.assertEqual((event.value, event.kind), (50, "value"))
            self.assertEqual(space.state, "live")
            self.assertEqual((await space.command("living.lamp-1", "on")).state, "confirmed")

    async def test_a_line_without_a_sign_of_life_is_lost(self):
        with mock.patch.object(_web, "SILENCE", 0.3):
            async with open_space() as space:
                self.island.pause(True)
                while space.state == "live":
                    await asyncio.sleep(0.05)
                self.island.pause(False)
                while space.state != "live":
                    await asyncio.sleep(0.05)

    async def test_a_server_that_hangs_ends_the_call_not_the_program(self):
        async with open_space(timeout=0.5) as space:
            self.island.pause(True)
            with self.assertRaises(rubicon.Error) as caught:
                await space.islands()
            self.assertEqual(caught.exception.code, "expired")
            self.island.pause(False)

    async def test_an_hour_of_reconnections_keeps_no_memory(self):
        async with open_space() as space, space.watch("proxy.**", passive=True) as watch:
            await first(watch)
            door = space._door
            sizes = []
            with mock.patch.object(_web, "RETRY", (0.0,)):
                tracemalloc.start()
                for turn in range(40):
                    await door._socket.close()
                    while space.state == "live":
                        await asyncio.sleep(0)
                    while space.state != "live":
                        await asyncio.sleep(0.005)
                    while watch._feed._missing:
                        await asyncio.sleep(0.005)
                    batch = await watch.batch()
                    self.assertTrue(turn == 0 or all(event.again for event in batch if event.key == "proxy.island"))
                    if turn in (10, 39):
                        gc.collect()
                        sizes.append(tracemalloc.get_traced_memory()[0])
                tracemalloc.stop()
            self.assertLess(sizes[1], sizes[0] * 1.2 + 20_000)


@needs_island
class Tokens(unittest.IsolatedAsyncioTestCase):
    @classmethod
    def setUpClass(cls):
        cls.island = Island(web="{listen: '127.0.0.1:8642', tokens: {file: web.tokens}}", folder=tokens_folder())
        cls.tokens = {role: (cls.island.folder / role).read_text().strip() for role in ("view", "command")}

    @classmethod
    def tearDownClass(cls):
        cls.island.end()

    async def test_the_role_decides(self):
        async with open_space(token=self.tokens["view"]) as space:
            self.assertEqual(len(await space.islands()), 1)
            self.assertIsNotNone(await first(space.watch("living.rate")))
            outcome = await space.command("living.lamp-1", "on")
            self.assertEqual((outcome.state, outcome.code), ("refused", "refused"), outcome)
        async with open_space(token_file=self.island.folder / "command") as space:
            self.assertTrue((await space.command("living.lamp-1", "on")).good)
            with self.assertRaises(rubicon.Error) as caught:
                await space.approve("dummy-new.guest")
            self.assertEqual(caught.exception.code, "refused")

    async def test_of_the_environment(self):
        for members in ({"RUBICON_TOKEN": self.tokens["view"]}, {"RUBICON_TOKEN_FILE": str(self.island.folder / "view")}):
            with mock.patch.dict(os.environ, members):
                async with rubicon.connect() as space:
                    self.assertEqual(space._door.role, "view")

    async def test_a_missing_or_wrong_token_is_refused(self):
        for token in (None, "", "0" * 32, "with blank"):
            with self.subTest(token), self.assertRaises(rubicon.Error) as caught:
                await open_space(token=token)
            self.assertEqual(caught.exception.code, "refused", caught.exception)
        with self.assertRaisesRegex(rubicon.Error, "token file"):
            open_space(token_file="/nowhere/token")
        with self.assertRaisesRegex(rubicon.Error, "characters"):
            open_space(token="a\r\nb")

    async def test_a_token_never_goes_to_another_host_in_clear(self):
        with self.assertRaisesRegex(rubicon.Error, "https only"):
            rubicon.connect("http://hall.lan:8642", token="secret")

    async def test_a_token_that_is_taken_away_ends_watches(self):
        file = self.island.folder / "web.tokens"
        text = file.read_text()
        space = await open_space(token=self.tokens["view"])
        try:
            async with space.watch("living.rate") as watch:
                await first(watch)
                file.write_text("".join(line for line in text.splitlines(True) if not line.startswith("view:")))
                os.kill(self.island._process.pid, signal.SIGHUP)
                with self.assertRaises(rubicon.Error) as caught:
                    await first(watch, lambda event: False)
                self.assertEqual(caught.exception.code, "refused")
                with self.assertRaises(rubicon.Error):
                    await space.command("6541:proxy.dummy-rooms.living.actuator.lamp-1.command", "on")
        finally:
            await space.close()
            file.write_text(text)
            os.kill(self.island._process.pid, signal.SIGHUP)


def tokens_folder():
    import tempfile
    from pathlib import Path

    folder = Path(tempfile.mkdtemp(prefix="rubicon-python-"))
    for role in ("view", "command"):
        command = [str(PROGRAMS / "rubicon"), "token", role, "--role", role, "--file", "web.tokens"]
        output = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout
        (folder / role).write_text(output.split()[-1] + "\n")
    return folder


@needs_island
class Tls(unittest.IsolatedAsyncioTestCase):
    @classmethod
    def setUpClass(cls):
        folder = tokens_folder()
        make = "req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 3 -subj /CN={0} -addext subjectAltName={1}"
        for name, alternative in (("web", "DNS:localhost"), ("other", "DNS:localhost")):
            subprocess.run(["openssl", *make.format("localhost", alternative).split(), "-keyout", f"{name}.key", "-out",
                            f"{name}.pem"], cwd=folder, check=True, capture_output=True)  # fmt: skip
        web = "{listen: '127.0.0.1:8642', tls: {certificate: web.pem, key: web.key}, tokens: {file: web.tokens}}"
        cls.island = Island(web=web, folder=folder)

    @classmethod
    def tearDownClass(cls):
        cls.island.end()

    def connect(self, host, ca):
        return rubicon.connect(f"https://{host}:8642", token_file=self.island.folder / "command", ca=ca)

    async def test_with_an_authority_of_its_own(self):
        async with self.connect("localhost", self.island.folder / "web.pem") as space:
            self.assertTrue((await space.command("living.lamp-1", "on")).good)
            self.assertIsNotNone(await first(space.watch("living.rate")))

    async def test_certificates_that_are_not_accepted(self):
        for host, ca in (("localhost", None), ("127.0.0.1", self.island.folder / "web.pem"),
                         ("localhost", self.island.folder / "other.pem")):
            with self.subTest(f"{host} {ca}"), self.assertRaises(rubicon.Error) as caught:
                await self.connect(host, ca)
            self.assertEqual(caught.exception.code, "refused")
            self.assertIn("certificate", str(caught.exception))
            self.assertIsInstance(caught.exception.__cause__, ssl.SSLError)
        with self.assertRaisesRegex(rubicon.Error, "io: "):
            self.connect("localhost", "/nowhere.pem")

    async def test_without_tls_the_server_says_so(self):
        with self.assertRaises(rubicon.Error):
            await open_space()


@needs_island
class Blocking(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.island = Island()

    @classmethod
    def tearDownClass(cls):
        cls.island.end()

    def test_the_same_names(self):
        import inspect

        for name, call in inspect.getmembers(rubicon.Space, inspect.isfunction):
            if name.startswith("_") or name == "open":
                continue
            other = getattr(rubicon.sync.Space, name)
            self.assertEqual(list(inspect.signature(call).parameters), list(inspect.signature(other).parameters), name)

    def test_calls(self):
        with rubicon.sync.connect("http://127.0.0.1:8642") as space:
            self.assertEqual(space.islands()[0].name, "home")
            self.assertEqual(len(space.devices(network="dummy-rooms")), 2)
            self.assertTrue(space.command("living.lamp-1", "on").good)
            self.assertIs(space.get("living.lamp-1").value, True)
            for event in space.watch("living.light-1"):
                if event.good:
                    break
            with self.assertRaises(rubicon.Error):
                space.get("living.nothing")
            self.assertEqual(space.state, "live")
        with self.assertRaisesRegex(rubicon.Error, "is closed"):
            space.islands()
        space.close()

    def test_from_two_threads(self):
        with rubicon.sync.connect("http://127.0.0.1:8642") as space:
            found = []
            threads = [threading.Thread(target=lambda: found.append(space.get("living.rate").value)) for _ in range(4)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            self.assertEqual(found, [found[0]] * 4)

    def test_nobody_there(self):
        with self.assertRaises(rubicon.Error) as caught:
            rubicon.sync.connect("http://127.0.0.1:9")
        self.assertEqual(caught.exception.code, "unreachable")
        for url in ("ftp://x", "http://", "http://a:b", "http://127.0.0.1:99999", "http://a/b"):
            with self.subTest(url), self.assertRaises(rubicon.Error) as caught:
                rubicon.connect(url)
            self.assertEqual(caught.exception.code, "invalid")

    def test_ctrl_c_ends_every_call(self):
        calls = ("next(space.watch('nothing.*', passive=True))", "[one for one in space.messages('chat')]",
                 "space.command('living.boiler-1', 'on', wait=60)", "[one for one in space.watch('living.*')]")
        for call in calls:
            with self.subTest(call):
                self.interrupted(f"import rubicon.sync\nwith rubicon.sync.connect('http://127.0.0.1:8642') as space:\n"
                                 f"    print('ready', flush=True)\n    {call}\n")
        self.interrupted("import rubicon\nasync def main():\n  async with rubicon.connect() as space:\n"
                         "    print('ready', flush=True)\n    async for event in space.watch('living.*'): pass\n"
                         "rubicon.run(main())\n")  # fmt: skip

    def interrupted(self, program):
        process = subprocess.Popen([sys.executable, "-W", "error", "-c", program], stdout=subprocess.PIPE, text=True,
                                   stderr=subprocess.PIPE, env={**os.environ, "PYTHONPATH": PYTHONPATH})  # fmt: skip
        self.assertEqual(process.stdout.readline(), "ready\n", process.poll())
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=30)
        self.assertTrue(errors.rstrip().endswith("KeyboardInterrupt"), errors)
        self.assertEqual(errors.count("Traceback"), 1 + errors.count("During handling"), errors)


if __name__ == "__main__":
    unittest.main()
