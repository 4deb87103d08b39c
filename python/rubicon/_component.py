"""The door in the process itself: a component of the tuple space, by the native module."""

from __future__ import annotations

import asyncio
import logging
import re
from fnmatch import fnmatchcase
from typing import Any, Callable, Dict, List, Optional, Set, Tuple

from ._door import NONE, Door, Following, outcome_of
from ._errors import Error
from ._feed import Stream
from ._values import Island, Json, Message, Outcome, parsed

PATIENCE = 3.0  #: seconds for components that do not answer


class ComponentDoor(Door):
    def __init__(self, options: Json) -> None:
        try:
            from . import _native
        except ImportError as error:
            text = "rubicon.join() needs the native module (Debian: python3-rubicon-native)"
            raise Error("unsupported", f"{text}: {error}; rubicon.connect() needs none") from error
        self._made: Callable[[Json], Any] = _native.Component
        self._options = {**options, "warn": logging.getLogger("rubicon").warning}
        self._component: Any = None
        self._streams: Dict[Stream, int] = {}
        self._listeners: Dict[Callable[[Message], None], int] = {}
        self._asked: Set[asyncio.Future[Any]] = set()
        self._loop: asyncio.AbstractEventLoop  #: which opened it

    async def open(self) -> None:
        self._component = self._made(self._options)
        self._loop = asyncio.get_running_loop()
        self._loop.add_reader(self._component.descriptor(), self._component.poll)
        self.state = "live"
        await self.read("*:*.island")  # then it is known who is there

    async def close(self) -> None:
        self.state = "closed"
        if self._component is not None:
            self._loop.remove_reader(self._component.descriptor())
            self._component.close()
        for future in self._asked:
            if not future.done():
                future.set_exception(Error("invalid", "this space was closed"))
        for feed in {stream.feed for stream in self._streams}:
            feed.end()

    def _wake(self) -> None:
        """What a call posted is done in the next turn, not at the next sign of another component."""
        self._loop.call_soon(self._component.poll)

    async def _answer(self, ask: Callable[..., None], *arguments: object) -> Any:
        """What a call of the component is answered, which is asked in this turn: one of asyncio takes longer."""
        future = self._loop.create_future()
        self._asked.add(future)
        try:
            ask(*arguments, lambda answer: None if future.done() else future.set_result(answer))
            self._component.poll()
            return await future
        finally:
            self._asked.discard(future)

    async def islands(self) -> List[Island]:
        return [Island.of(row) for row in self._component.islands()]

    async def devices(self, query: Dict[str, str]) -> List[Json]:
        owner = query.get("island", "*")
        known = await self.read(f"{owner}:*.*.*.description")
        states = {(row["owner"], row["key"]): parsed(row["value"]) for pattern in ("*.*.*.status", "*.*.status")
                  for row in await self.read(f"{owner}:{pattern}")}
        rows = [_device(row, parsed(row["value"]), states) for row in known]
        return sorted((row for row in rows if row["network"] and _matches(row, query)), key=_natural)

    async def read(self, pattern: str) -> List[Json]:
        return sorted(await self._answer(self._component.read, pattern, PATIENCE), key=_natural)

    def subscribe(self, stream: Stream) -> None:
        flow = {**stream.flow._asdict(), "minimum": stream.flow.minimum or 0.0}
        self._streams[stream] = self._component.subscribe(stream.pattern, flow, stream.full, stream.take)
        self._wake()

    def unsubscribe(self, stream: Stream) -> None:
        self._component.end(self._streams.pop(stream, 0))

    async def write(self, key: str, value: bytes, options: Json, wait: float) -> Outcome:
        owner, key = key.split(":", 1)
        if "append" in options or not key.endswith(".command"):
            return outcome_of(NONE, await self._answer(self._component.write, int(owner), key, value, options))
        following = Following()
        self._component.write(int(owner), key, value, options, following.take)
        self._component.poll()
        return await following.outcome(wait)

    async def send(self, to: int, kind: str, data: bytes, network: str, device: str) -> None:
        error = await self._answer(self._component.send, to, kind, data, network, device)
        if error:
            raise Error("unreachable", error)

    async def listen(self, kind: str, call: Callable[[Message], None]) -> None:
        def deliver(row: Json) -> None:
            call(Message(row["from"], row["type"], row["value"], row["network"], row["device"]))

        self._listeners[call] = self._component.listen(kind, deliver)

    async def unlisten(self, kind: str, call: Callable[[Message], None]) -> None:
        self._component.end(self._listeners.pop(call, 0))

    def own(self, key: str, value: bytes, media_type: str, lifetime: float) -> int:
        sequence: int = self._component.own(key, value, media_type, lifetime)
        self._wake()
        return sequence

    def erase(self, key: str) -> None:
        self._component.erase(key)
        self._wake()

    def judge(self, pattern: str, appends: bool, call: Callable[[Json], Optional[str]]) -> Callable[[], None]:
        number = self._component.judge(pattern, appends, call)

        def end() -> None:
            self._component.end(number)

        return end


def _device(row: Json, about: Json, states: Dict[Tuple[int, str], Json]) -> Json:
    owner, (prefix, network, device, _) = row["owner"], row["key"].split(".")
    state = states.get((owner, f"{prefix}.{network}.{device}.status"), {})
    line = states.get((owner, f"{prefix}.{network}.status"), {})
    return {**about, "island": owner, "key": f"{prefix}.{network}.{device}", "id": device,
            "network": network if "network" in about else "", "status": state.get("status", "unknown"),
            "reason": state.get("reason", ""), "since": state.get("since", 0), "line": line.get("line", ""),
            "line_reason": line.get("reason", "")}


def _matches(row: Json, query: Dict[str, str]) -> bool:
    points = [*row.get("sensors", ()), *row.get("actuators", ()), *row.get("properties", ())]
    has = {"type": [row.get("type", ""), *(point.split("-")[0] for point in points)], "network": [row["network"]],
           "name": [row.get("name", ""), row["id"], row.get("address", "")], "area": [row.get("area", "")]}
    return all(any(fnmatchcase(text, query[name]) for text in texts) for name, texts in has.items() if name in query)


def _natural(row: Json) -> Tuple[int, List[Tuple[int, str]]]:
    """By island, then by key with numbers as numbers."""
    parts = re.findall(r"\d+|\D+", row["key"])
    return int(row.get("owner") or row["island"]), [(int(part), "") if part.isdigit() else (-1, part) for part in parts]
