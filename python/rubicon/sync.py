"""The same as rubicon, blocking: for scripts, cron, and programs without an event loop.

    with rubicon.sync.connect("http://127.0.0.1:8642") as space:
        print(space.get("living.light-1"))

The loop runs in a thread of its own. A space may be used from several threads, one call at a time in each."""

from __future__ import annotations

import asyncio
import threading
from datetime import datetime
from pathlib import Path
from typing import Any, Callable, Coroutine, Iterator, List, Optional, TypeVar, Union

import rubicon

from ._errors import Error
from ._values import (Device, Devices, Event, Island, LogLine, Message, Outcome, RemoteSet, Sample, Span, Value, Values, Waiting,
                      When)

_Result = TypeVar("_Result")


def connect(url: str = "", token: Optional[str] = None, *, token_file: Union[str, Path, None] = None,
            ca: Union[str, Path, None] = None, timeout: float = 30) -> Space:
    """As rubicon.connect(); the space is open when it returns."""
    return Space(rubicon.connect(url, token, token_file=token_file, ca=ca, timeout=timeout))


def join(space: str = "", **options: Any) -> Space:
    """As rubicon.join(); the space is open when it returns. Judges are called in the thread of its loop."""
    return Space(rubicon.join(space, **options))


class Space:
    """As rubicon.Space; each call returns when it is done. Ctrl-C ends the call, and leaves the space open."""

    def __init__(self, space: rubicon.Space) -> None:
        self._space = space
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="rubicon", daemon=True)
        self._thread.start()
        try:
            self._wait(space.open())
        except BaseException:
            self.close()
            raise

    def _wait(self, call: Coroutine[Any, Any, _Result]) -> _Result:
        if self._loop.is_closed():
            call.close()
            raise Error("invalid", "this space is closed; open another one")
        future = asyncio.run_coroutine_threadsafe(call, self._loop)
        try:
            return future.result()
        except BaseException:
            future.cancel()
            raise

    def close(self) -> None:
        """Ends all watches. Closing twice does nothing."""
        if self._loop.is_closed():
            return
        self._wait(self._space.close())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def __enter__(self) -> Space:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def state(self) -> str:
        return self._space.state

    def islands(self) -> List[Island]:
        return self._wait(self._space.islands())

    def devices(self, *, type: str = "", name: str = "", network: str = "", area: str = "",
                island: Union[int, str] = "") -> Devices:
        return self._wait(self._space.devices(type=type, name=name, network=network, area=area, island=island))

    def device(self, name: str) -> Device:
        return self._wait(self._space.device(name))

    def read(self, pattern: str) -> Values:
        return self._wait(self._space.read(pattern))

    def get(self, name: str) -> Value:
        return self._wait(self._space.get(name))

    def watch(self, pattern: str, *, minimum: Optional[Span] = None, maximum: Span = 0, dead_band: float = 0,
              passive: bool = False) -> Iterator[Event]:
        async def begin() -> rubicon.Watch:
            watch = self._space.watch(pattern, minimum=minimum, maximum=maximum, dead_band=dead_band, passive=passive)
            await watch.start()
            return watch

        return self._events(self._wait(begin()))

    def _events(self, watch: rubicon.Watch) -> Iterator[Event]:
        try:
            while True:
                batch = self._wait(watch.batch())
                if not batch:
                    return
                yield from batch
        finally:
            watch.close()

    def command(self, name: str, value: object, *, ttl: Span = 5, wait: Span = 15, check: bool = False) -> Outcome:
        return self._wait(self._space.command(name, value, ttl=ttl, wait=wait, check=check))

    def set(self, name: str, value: object, *, sequence: Optional[int] = None, media_type: str = "",
            time: Optional[datetime] = None, lifetime: Optional[Span] = None, ttl: Span = 5) -> int:
        return self._wait(self._space.set(name, value, sequence=sequence, media_type=media_type, time=time,
                                          lifetime=lifetime, ttl=ttl))

    def append(self, name: str, text: Union[str, bytes], *, sequence: Optional[int] = None) -> int:
        return self._wait(self._space.append(name, text, sequence=sequence))

    def own(self, key: str, value: object, *, media_type: str = "", lifetime: Span = 0) -> int:
        return self._wait(self._space.own(key, value, media_type=media_type, lifetime=lifetime))

    def erase(self, key: str) -> None:
        self._wait(self._space.erase(key))

    def judge(self, pattern: str, call: Callable[[RemoteSet], Optional[str]], *, appends: bool = False) -> rubicon.Judge:
        async def begin() -> rubicon.Judge:
            return self._space.judge(pattern, call, appends=appends)

        judge = self._wait(begin())

        async def end() -> None:
            judge.close()

        return rubicon.Judge(lambda: self._wait(end()))

    def send(self, to: Union[int, str], type: str, data: Union[str, bytes], *, network: str = "", device: str = "") -> None:
        self._wait(self._space.send(to, type, data, network=network, device=device))

    def messages(self, type: str) -> Iterator[Message]:
        async def begin() -> rubicon.Messages:
            return await self._space.messages(type).__aenter__()

        messages = self._wait(begin())
        try:
            while True:
                yield self._wait(messages.__anext__())
        finally:
            self._wait(messages.__aexit__())

    def history(self, pattern: str, *, since: When = "1h", until: When = 0, every: Span = 0,
                show: str = "mean") -> Any:
        return self._wait(self._space.history(pattern, since=since, until=until, every=every, show=show))

    def samples(self, pattern: str, *, since: When = "1h", until: When = 0, every: Span = 0) -> List[Sample]:
        return self._wait(self._space.samples(pattern, since=since, until=until, every=every))

    def export(self, pattern: str, *, since: When = "1h", until: When = 0, every: Span = 0) -> str:
        return self._wait(self._space.export(pattern, since=since, until=until, every=every))

    def inbox(self) -> List[Waiting]:
        return self._wait(self._space.inbox())

    def approve(self, name: str, *, island: Union[int, str] = "") -> None:
        self._wait(self._space.approve(name, island=island))

    def ignore(self, name: str, *, island: Union[int, str] = "") -> None:
        self._wait(self._space.ignore(name, island=island))

    def settings(self, *, island: Union[int, str] = "") -> str:
        return self._wait(self._space.settings(island=island))

    def log(self, *, island: Union[int, str] = "") -> List[LogLine]:
        return self._wait(self._space.log(island=island))
