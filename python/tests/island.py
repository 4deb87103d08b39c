"""Real islands on loopback of a private network."""

import asyncio
import ctypes
import fcntl
import os
import shutil
import signal
import socket
import struct
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import rubicon

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = Path(rubicon.__file__).parents[1]
PYTHONPATH = os.pathsep.join([str(PACKAGE), *os.environ.get("PYTHONPATH", "").split(os.pathsep)]).rstrip(os.pathsep)
PROGRAMS = Path(os.environ.get("RUBICON_PROGRAMS", ROOT / "build/dev/bin"))

ROOMS = """
island: {id: 6541, name: home}
networks:
  dummy-rooms:
    type: dummy
    devices: {bedroom: {name: Bedroom, area: Upstairs}}
    simulate:
      living:
        name: Living room
        sensors: {light-1: {wave: sine, low: 40, high: 320, period: 20s}, button-1: {wave: steps, values: [press], period: 1h}}
        actuators: {lamp-1: {behaviour: obey, delay: 20ms}, boiler-1: {behaviour: ignore}}
        properties: {rate: 50}
      bedroom:
        sensors:
          temperature-bed: {wave: sine, low: 18, high: 21, period: 20s}
          contact-1: {wave: steps, values: [open], period: 1h}
        actuators: {lamp-1: {behaviour: obey, delay: 20ms}}
        properties: {rate: 50}
  dummy-new: {type: dummy, simulate: {guest: {}, stranger: {}}}
discovery: {rules: [{network: dummy-new, new-devices: ask}]}
"""

_entered = None


def enter_private_network():
    """Once for the process, before it has threads. False: this user may not."""
    global _entered
    if _entered is None:
        libc = ctypes.CDLL(None, use_errno=True)
        new_net, new_user = 0x40000000, 0x10000000
        flags = new_net if os.geteuid() == 0 else new_net | new_user
        _entered = libc.unshare(flags) == 0 and _raise_loopback()
    return _entered


def _raise_loopback():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        up_and_running = struct.pack("16sH14x", b"lo", 0x41)
        fcntl.ioctl(one, 0x8914, up_and_running)  # SIOCSIFFLAGS
    return True


def wait_for_port(process, port):
    """Until a program listens on this port of loopback; False: it ended, or 30 s have passed."""
    for _ in range(600):
        if process.poll() is not None:
            break
        with socket.socket() as one:
            if one.connect_ex(("127.0.0.1", port)) == 0:
                return True
        time.sleep(0.05)
    return False


class Island:
    """rubicon-proxy with a page on port 8642. `options` are --set."""

    def __init__(self, *options, text=ROOMS, web="{listen: '127.0.0.1:8642'}", folder=None):
        self.folder = Path(folder or tempfile.mkdtemp(prefix="rubicon-python-"))
        self.space_folder = self.folder / "meet"
        self.space_folder.mkdir(mode=0o700, exist_ok=True)
        (self.folder / "island.yaml").write_text(text)
        self._options = [f"web={web}", *options]
        self._process = None
        self.start()

    @property
    def environment(self):
        return {**os.environ, "RUBICON_FOLDER": str(self.space_folder), "RUBICON_TRUST": "no"}

    def start(self):
        command = [str(PROGRAMS / "rubicon-proxy"), "run", str(self.folder / "island.yaml")]
        for option in self._options:
            command += ["--set", option]
        self._log = open(self.folder / "log", "ab")
        self._process = subprocess.Popen(command, cwd=self.folder, env=self.environment, stdin=subprocess.DEVNULL,
                                         stdout=subprocess.DEVNULL, stderr=self._log)
        if not wait_for_port(self._process, 8642):
            self.stop()
            raise AssertionError((self.folder / "log").read_text())

    def stop(self):
        self._process.terminate()
        self._process.wait()
        self._log.close()

    def pause(self, stopped):
        self._process.send_signal(signal.SIGSTOP if stopped else signal.SIGCONT)

    def end(self):
        if self._process.poll() is None:
            self.pause(False)
            self.stop()
        shutil.rmtree(self.folder)

    def rubicon(self, *words, **options):
        return subprocess.run([str(PROGRAMS / "rubicon"), *words], env=self.environment, cwd=self.folder, check=True,
                              capture_output=True, text=True, **options).stdout


def open_space(**options):
    return rubicon.connect("http://127.0.0.1:8642", **options)


async def first(watch, wanted=lambda event: True):
    """The first event that is wanted; None when the watch ends. What does not come fails the test."""

    async def found():
        async for event in watch:
            if wanted(event):
                return event

    return await asyncio.wait_for(found(), 60)


def tokens_folder():
    """A folder with a file of tokens, and each token in a file with the name of its role."""
    folder = Path(tempfile.mkdtemp(prefix="rubicon-python-"))
    for role in ("view", "command"):
        command = [str(PROGRAMS / "rubicon"), "token", role, "--role", role, "--file", "web.tokens"]
        output = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout
        (folder / role).write_text(output.split()[-1] + "\n")
    return folder


def needs_island(case):
    """A class of tests that is left out where no island can run."""
    if not (PROGRAMS / "rubicon-proxy").exists():
        return unittest.skip(f"no rubicon-proxy in {PROGRAMS}")(case)
    if not enter_private_network():
        return unittest.skip("this user may not have a private network")(case)
    return case
