"""Servers that restart, hang, want tokens or TLS; the blocking form; Ctrl-C."""

import asyncio
import gc
import inspect
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

from .island import PYTHONPATH, Island, first, needs_island, open_space, tokens_folder


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
        async with open_space(timeout=5) as space:
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
