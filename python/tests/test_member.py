"""A component where somebody decides what it may do: rights on a host, and a broker."""

import asyncio
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import rubicon

from .island import PACKAGE, Island, first, needs_island, tokens_folder, wait_for_port

NATIVE = importlib.util.find_spec("rubicon._native")

RIGHTS = "rights=[{who: 'user:1', may: [read, demand], keys: ['proxy.**']}, " \
         "{who: 'user:1', may: set, keys: ['proxy.*.bedroom.**']}]"
WEB = "{listen: '127.0.0.1:8642', tokens: {file: web.tokens}}"

ASKS = """
import asyncio, rubicon
async def main():
    async with rubicon.join() as space:
        print([one.name for one in await space.islands()])
        async for event in space.watch("living.light-1"):
            if event.good:
                print(event.unit)
                break
        for lamp in ("bedroom.lamp-1", "living.lamp-1"):
            print((await space.command(lamp, "on")).state)
        try:
            await space.approve("dummy-new.guest")
        except rubicon.Error as error:
            print(error.code)
rubicon.run(main())
"""


@needs_island
@unittest.skipUnless(NATIVE, "the native module is not built")
@unittest.skipUnless(os.geteuid() == 0, "only root can be somebody else")
class WithRights(unittest.TestCase):
    def test_the_user_of_the_process_decides(self):
        folder = tokens_folder()
        meet = folder / "meet"
        folder.chmod(0o755)
        for name, mode in (("", 0o750), ("islands", 0o2750), ("people", 0o3770)):  # a folder of several users (docs/host.md)
            (meet / name).mkdir(exist_ok=True)
            os.chown(meet / name, 0, 1)
            (meet / name).chmod(mode)
        island = Island(RIGHTS, folder=folder, web=WEB)
        self.addCleanup(island.end)
        copy = folder / "package"  # that everybody may read
        shutil.copytree(PACKAGE / "rubicon", copy / "rubicon")
        subprocess.run(["chmod", "-R", "a+rX", str(copy)], check=True)
        done = subprocess.run([sys.executable, "-W", "error", "-c", ASKS], user=1, group=1, extra_groups=[], cwd="/",
                              env={"RUBICON_FOLDER": str(meet), "PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"},
                              capture_output=True, text=True, timeout=60)  # fmt: skip
        self.assertEqual(done.stdout.split("\n")[:-1], ["['home']", "lx", "confirmed", "refused", "refused"], done.stderr)


@needs_island
@unittest.skipUnless(NATIVE, "the native module is not built")
@unittest.skipUnless(shutil.which("mosquitto", path=os.environ["PATH"] + ":/usr/sbin"), "there is no mosquitto")
class OverABroker(unittest.IsolatedAsyncioTestCase):
    def setUp(self):
        folder = Path(tempfile.mkdtemp(prefix="rubicon-python-"))
        (folder / "mosquitto.conf").write_text("listener 1883 127.0.0.1\nallow_anonymous true\npersistence false\n")
        program = shutil.which("mosquitto", path=os.environ["PATH"] + ":/usr/sbin")
        broker = subprocess.Popen([program, "-c", "mosquitto.conf"], cwd=folder, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL)
        self.addCleanup(broker.wait)
        self.addCleanup(broker.terminate)
        self.assertTrue(wait_for_port(broker, 1883))
        self.island = Island("tuples={mqtt: {broker: 127.0.0.1, trust_broker: yes}}", folder=folder)
        self.addCleanup(self.island.end)

    async def test_an_island_of_another_site(self):
        elsewhere = self.island.folder / "elsewhere"
        elsewhere.mkdir(mode=0o700)
        broker = {"host": "127.0.0.1", "trust": True, "all": True}
        async with rubicon.join(folder=str(elsewhere), broker=broker) as space:
            while not await space.islands():
                await asyncio.sleep(0.1)
            event = await first(space.watch("living.light-1"), lambda event: event.good)
            self.assertEqual(event.unit, "lx")
            self.assertEqual((await space.command("living.lamp-1", "on")).state, "confirmed")


if __name__ == "__main__":
    unittest.main()
