"""The tuple space as a program sees it, over either door."""

from __future__ import annotations

import asyncio
import dataclasses
import time as clock
from datetime import datetime
from types import TracebackType
from typing import Any, Callable, Dict, Generator, Iterable, List, Optional, Sequence, Tuple, Type, Union
from urllib.parse import urlencode

from . import _history
from ._door import Door
from ._errors import Error, Refused
from ._feed import Feed, Flow, Watch
from ._listening import Judge, Messages
from ._names import (KINDS, Query, ambiguous, devices_called, has_wildcard, is_like_name, not_found, points_called, query_of,
                     split_owner, whole)
from ._values import (Device, Devices, Island, Json, LogLine, Outcome, RemoteSet, Sample, Span, Subject, Value, Values, Waiting,
                      When, moment, parsed, seconds_of, text_of, utc)


class Space:
    """Islands, devices, values and commands. Made by `rubicon.connect()` and `rubicon.join()`:

        async with rubicon.connect("http://127.0.0.1:8642") as space: ...
        space = await rubicon.connect("http://127.0.0.1:8642")      # ends with: await space.close()

    Names are those of the command line: `living.lamp-1`, `dummy-rooms.living.lamp-1`, whole keys, each with an owner
    or the name of an island in front (`home:living.lamp-1`). Patterns have `*` for a part, `*` and `?` within one, and
    a last `**` for the rest. Spans are seconds, a timedelta, or a text such as `5s`, `7d`.

    A space belongs to the event loop in which it was opened. Every call raises Error, with a code of docs/errors.md."""

    def __init__(self, door: Door) -> None:
        self._door = door
        self._loop: Optional[asyncio.AbstractEventLoop] = None

    @property
    def state(self) -> str:
        """connecting, live, lost (it is tried again) or closed."""
        return self._door.state

    async def open(self) -> Space:
        if self._loop is None:
            self._loop = asyncio.get_running_loop()
            try:
                await self._door.open()
            except BaseException:
                await self._door.close()
                raise
        return self

    async def close(self) -> None:
        """Ends all watches. Closing twice does nothing."""
        if self._door.state != "closed":
            await self._door.close()

    def __await__(self) -> Generator[Any, None, Space]:
        return self.open().__await__()

    async def __aenter__(self) -> Space:
        return await self.open()

    async def __aexit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                        trace: Optional[TracebackType]) -> None:
        await self.close()

    def __enter__(self) -> None:
        raise Error("invalid", "write `async with`, or `with rubicon.sync.connect(...)` where there is no event loop")

    def __exit__(self, *_: object) -> None: ...

    def _check(self) -> None:
        if self._door.state == "closed":
            raise Error("invalid", "this space is closed; open another one")
        if self._loop is None:
            raise Error("invalid", "this space is not open: write `async with rubicon.connect(...) as space`")
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:
            raise Error("invalid", "no event loop runs here; rubicon.sync.connect() needs none") from None
        if loop is not self._loop:
            raise Error("invalid", "this space belongs to another event loop, of another thread or an earlier "
                        "asyncio.run(): use it there, or open one for each loop")

    # -- who and what is there

    async def islands(self) -> List[Island]:
        """The islands that are present, by id."""
        self._check()
        return await self._door.islands()

    async def devices(self, *, type: str = "", name: str = "", network: str = "", area: str = "",
                      island: Union[int, str] = "") -> Devices:
        """The devices that match all of these, with `*` and `?` as in shells. `type` is that of the device or of a
        point that it has; `name` is its display name, its part of the key, or its address."""
        self._check()
        query = {"type": type, "name": name, "network": network, "area": area}
        if island:
            query["island"] = await self._owner(str(island))
        rows = await self._door.devices({key: value for key, value in query.items() if value})
        return Devices(Device.of(row) for row in rows)

    async def device(self, name: str) -> Device:
        """One device with its points: by display name, `living`, `dummy-rooms.living` or `proxy.dummy-rooms.living`."""
        self._check()
        found = await self._devices_named(name)
        if not found:
            known = await self.devices()
            names = {one.id for one in known} | {one.name for one in known}
            raise not_found("device", name, names)
        if len(found) > 1:
            raise ambiguous("device", name, [f"{one.island}:{one.network}.{one.id}" for one in found])
        device = found[0]
        points = await self.read(f"{device.island}:{device.key}.*.*.value")
        order = {kind: place for place, kind in enumerate(KINDS)}
        points.sort(key=lambda value: order.get(value.key.split(".")[3], 3))
        return dataclasses.replace(device, points=tuple(points))

    async def _devices_named(self, name: str) -> List[Device]:
        return devices_called(await self.devices(), await self._island_names(), name)

    async def _island_names(self) -> Dict[int, str]:
        return {one.id: one.name for one in await self._door.islands()}

    async def _owner(self, name: str) -> str:
        """The id of an island's id or name, or of another component's id."""
        if name.isdigit() or not name:
            return name
        islands = await self._door.islands()
        found = [one for one in islands if one.name == name]
        if not found:
            raise not_found("island", name, [one.name for one in islands])
        if len(found) > 1:
            raise ambiguous("island", name, [str(one.id) for one in found])
        return str(found[0].id)

    # -- values

    async def read(self, pattern: str) -> Values:
        """The present values that match, in natural order of island and key. Wakes no sensor."""
        self._check()
        owner, query = await self._query(pattern)
        parts = query.key.split(".")
        if len(parts) != 6 or parts[5] != "value":
            rows = await self._door.read(f"{owner}:{query.key}")
            return Values(_value(row) for row in rows if query.means(row["key"]))
        rows = await self._door.read(f"{owner}:{'.'.join(parts[:5])}.*")
        return Values(_points(rows, query))

    async def get(self, name: str) -> Value:
        """One tuple; of a point its value with unit and quality. Wakes no sensor."""
        self._check()
        owner, key = await self._tuple(name, "value")
        found = await self.read(f"{owner}:{key}")
        if not found:
            raise Error("not-found", f"no tuple {owner}:{key}")
        return found[0]

    def watch(self, pattern: str, *, minimum: Optional[Span] = None, maximum: Span = 0, dead_band: float = 0,
              passive: bool = False) -> Watch:
        """Present values that match, then each change of one: an async iterator of Event.

        Without `passive` it wakes the sensors that match, and lets them sample each `minimum`. At most one value comes
        in `minimum` (0.05 s if not given), the present one again after `maximum` (0 = never). Changes of numbers by
        less than `dead_band` do not come. After a lost line it goes on by itself."""
        self._check()
        pace = None if minimum is None else seconds_of(minimum, "minimum")
        flow = Flow(pace, seconds_of(maximum, "maximum"), dead_band, passive)
        return Watch(lambda: self._begin(pattern, flow), self._end)

    async def _begin(self, pattern: str, flow: Flow) -> Feed:
        self._check()
        owner, query = await self._query(pattern)
        feed = Feed(owner, query, flow, self._door.subscribe)
        feed.begin()
        return feed

    def _end(self, feed: Feed) -> None:
        """Also from the garbage collector, in any thread."""
        feed.ended = True
        if self._loop is not None and not self._loop.is_closed() and self._door.state != "closed":
            self._loop.call_soon_threadsafe(self._unsubscribe, feed)

    def _unsubscribe(self, feed: Feed) -> None:
        for stream in feed.streams:
            self._door.unsubscribe(stream)
        feed.end()

    async def _query(self, pattern: str) -> Tuple[str, Query]:
        """Owner, or `*`, and what a pattern or a name means."""
        try:
            owner, key = split_owner(pattern)
            if has_wildcard(key):
                return await self._owner(owner) or "*", query_of(key)
        except Error as error:
            if has_wildcard(pattern):
                owner, key = self._only(pattern, await self._called(pattern, "value", error=error))
                return owner, query_of(key)
        owner, key = await self._tuple(pattern, "value")
        return owner, Query(key, None)

    async def _tuple(self, name: str, leaf: str) -> Tuple[str, str]:
        """Owner and key of a name: a point with this leaf, or a tuple with exactly this key."""
        try:
            owner, key = split_owner(name)
            if owner and not owner.isdigit():
                owner = await self._owner(owner)
        except Error as error:
            return self._only(name, await self._called(name, leaf, error=error))
        known = whole(owner, key, leaf)
        if known:
            return known  # its owner says whether there is one
        parts = key.split(".")
        if len(parts) == 5 and parts[3] in KINDS:
            parts.append(leaf)
        if len(parts) in (2, 3):
            found = await self._points_named(owner, parts, leaf)
            if found:
                return self._only(name, found)
        key = ".".join(parts)
        if owner and parts[0] == "proxy":
            return owner, key
        found = [(str(row["owner"]), str(row["key"])) for row in await self._door.read(f"{owner or '*'}:{key}")]
        return self._only(name, found or await self._called(name, leaf, parts))

    async def _called(self, name: str, leaf: str, parts: Sequence[str] = (),
                      error: Optional[Error] = None) -> List[Tuple[str, str]]:
        """The tuples of the points that people call so. Raises where there are none: `error` says what else is wrong."""
        found = points_called(await self.devices(), await self._island_names(), name, leaf == "command")
        if found:
            return [(owner, f"{key}.{leaf}") for owner, key in found]
        if error is not None and (error.code == "not-found" or not is_like_name(name)):
            raise error
        raise not_found("tuple", name, await self._known_names(parts, leaf))

    async def _points_named(self, owner: str, parts: List[str], leaf: str) -> List[Tuple[str, str]]:
        *network, device, point = parts
        query = {"name": device, "network": network[0] if network else "", "island": owner}
        rows = await self._door.devices({key: value for key, value in query.items() if value})
        found = []
        for one in (Device.of(row) for row in rows):
            for kind, points in zip(KINDS, (one.sensors, one.actuators, one.properties)):
                if point in points and (leaf != "command" or kind != "sensor"):
                    found.append((str(one.island), f"{one.key}.{kind}.{point}.{leaf}"))
        return found

    @staticmethod
    def _only(name: str, found: List[Tuple[str, str]]) -> Tuple[str, str]:
        if len(found) > 1:
            raise ambiguous("tuple", name, [f"{owner}:{key}" for owner, key in found])
        return found[0]

    async def _known_names(self, parts: Sequence[str], leaf: str) -> List[str]:
        """Names of the same form as the one that was given."""
        names = []
        for one in await self.devices():
            fronts = {2: [one.id, one.name], 3: [f"{one.network}.{one.id}"], 0: [one.name]}.get(len(parts))
            for kind, points in zip(KINDS, (one.sensors, one.actuators, one.properties)):
                if leaf == "command" and kind == "sensor":
                    continue
                for point in points:
                    names += [f"{front}.{point}" for front in fronts if front] if fronts else [f"{one.key}.{kind}.{point}.{leaf}"]
        return names

    # -- commands and tuples

    async def command(self, name: str, value: object, *, ttl: Span = 5, wait: Span = 15, check: bool = False) -> Outcome:
        """Commands an actuator or a property, and waits for the outcome, at most `wait`. A command that was not
        delivered within `ttl` is never executed. With `check`, an outcome that is not good raises Refused."""
        self._check()
        owner, key = await self._tuple(name, "command")
        options = {"ttl": seconds_of(ttl, "ttl")}
        outcome = await self._door.write(f"{owner}:{key}", _bytes(value), options, seconds_of(wait, "wait"))
        if check and not outcome.good:
            raise Refused(outcome, key)
        return outcome

    async def set(self, name: str, value: object, *, sequence: Optional[int] = None, media_type: str = "",
                  time: Optional[datetime] = None, lifetime: Optional[Span] = None, ttl: Span = 5) -> int:
        """Sets a tuple of another component, and returns its new sequence number (0 = not told). With `sequence`, only
        if the tuple has this one (0 = only if there is none); else Error refused. `time` is when it was measured."""
        options: Json = {"ttl": seconds_of(ttl, "ttl")}
        if sequence is not None:
            options["sequence"] = sequence
        media_type = media_type or _media(value)
        if media_type != "text/plain":
            options["media"] = media_type
        if time is not None:
            options["user"] = time.timestamp()
        if lifetime is not None:
            options["lifetime"] = seconds_of(lifetime, "lifetime")
        return await self._write(name, value, options)

    async def append(self, name: str, text: Union[str, bytes], *, sequence: Optional[int] = None) -> int:
        """Appends to a tuple, if its owner permits that; returns its new sequence number."""
        options: Json = {"append": True}
        if sequence is not None:
            options["sequence"] = sequence
        return await self._write(name, text, options)

    async def _write(self, name: str, value: object, options: Json) -> int:
        self._check()
        owner, key = await self._tuple(name, "command")
        outcome = await self._door.write(f"{owner}:{key}", _bytes(value), options, 15)
        if not outcome.good:
            raise Error(outcome.code or "refused", f"{key}: {outcome.reason or outcome.state}")
        return outcome.sequence

    # -- own tuples, of a component (rubicon.join)

    async def own(self, key: str, value: object, *, media_type: str = "", lifetime: Span = 0) -> int:
        """Creates or changes a tuple of this component, and returns its sequence number. `lifetime` 0 = it stays."""
        self._check()
        return self._door.own(key, _bytes(value), media_type or _media(value), seconds_of(lifetime, "lifetime"))

    async def erase(self, key: str) -> None:
        """Deletes a tuple of this component."""
        self._check()
        self._door.erase(key)

    def judge(self, pattern: str, call: Callable[[RemoteSet], Optional[str]], *, appends: bool = False) -> Judge:
        """Lets `call` decide about sets of own tuples by others, until the result is closed: None accepts, a text
        refuses and says why. Without a judge such sets are refused. Of several the narrowest pattern decides."""
        self._check()
        return Judge(self._door.judge(pattern, appends, lambda row: call(RemoteSet.of(row))))

    # -- messages

    async def send(self, to: Union[int, str], type: str, data: Union[str, bytes], *, network: str = "",
                   device: str = "") -> None:
        """Sends a message to a component, a network of an island, or a device there; returns when it was accepted."""
        self._check()
        await self._door.send(int(await self._owner(str(to))), type, _bytes(data), network, device)

    def messages(self, type: str) -> Messages:
        """The messages of a type to this program's component from now on: an async iterator of Message."""
        self._check()
        return Messages(self._door, type)

    # -- the past

    async def history(self, pattern: str, *, since: When = "1h", until: When = 0, every: Span = 0,
                      show: str = "mean") -> Any:
        """Past values as a pandas.DataFrame: a column for each key, a row each `every`, the index in UTC. NaN: nothing
        was known. Words are their numbers, with the words in `attrs["words"]`. Units are in `attrs["units"]`.

        `show`: what of the values of a row: mean (by time; the last of words), first, last, minimum, maximum, count.
        `every` is a width of docs/history.md; 0 = the finest that gives at most 1,000 rows. Where pandas is not
        installed: a list of Sample."""
        if show not in _history.SHOWN:
            raise Error("invalid", f"show is {show!r}; expected {', '.join(_history.SHOWN)}")
        now, span, answers = await self._past(pattern, since, until, every)
        try:
            import pandas  # noqa: F401
        except ImportError:
            return _history.samples(answers)
        return await asyncio.get_running_loop().run_in_executor(None, _history.frame, answers, span, now, show)

    async def samples(self, pattern: str, *, since: When = "1h", until: When = 0, every: Span = 0) -> List[Sample]:
        """As history(), as rows without pandas: time, key, the last value, and first, minimum, maximum, mean and n (how many) of
        those within `every`. A value None begins a gap."""
        return _history.samples((await self._past(pattern, since, until, every))[2])

    async def export(self, pattern: str, *, since: When = "1h", until: When = 0, every: Span = 0) -> str:
        """As history(), as CSV: a line for each bucket that has values, with the columns of the API."""
        span, keys = await self._asked(pattern, since, until, every)
        texts: List[str] = [await self._door.history(path, "text/csv") for path in span.paths(keys)]
        return texts[0] + "".join(text.partition("\n")[2] for text in texts[1:])

    async def _past(self, pattern: str, since: When, until: When, every: Span) -> Tuple[float, _history.Range, List[Json]]:
        span, keys = await self._asked(pattern, since, until, every)
        return clock.time(), span, [await self._door.history(path) for path in span.paths(keys)]

    async def _asked(self, pattern: str, since: When, until: When, every: Span) -> Tuple[_history.Range, List[str]]:
        self._check()
        now = clock.time()
        span = _history.Range.of(moment(since, now, "since"), moment(until, now, "until"), seconds_of(every, "every"))
        owner, query = await self._query(pattern)
        path: Optional[str] = "/api/v1/history/series?" + urlencode({"pattern": f"{owner}:{query.key}"})
        keys: List[str] = []
        while path:
            page = await self._door.history(path)
            keys += [row["key"] for row in page["series"] if query.means(row["key"].split(":", 1)[1])]
            path = page.get("next")
        if not keys:
            raise Error("not-found", f"the history has nothing of {pattern!r}")
        return span, keys

    # -- the island itself

    async def inbox(self) -> List[Waiting]:
        """Devices that wait for a decision, and those that are ignored."""
        self._check()
        rows = []
        for row in await self._door.read("*:*.inbox.*.*"):
            rows.append({**parsed(row["value"]), "island": row["owner"], "state": "waiting"})
        for row in await self._door.read("*:*.inbox.ignored"):
            for one in parsed(row["value"]).get("devices", ()):
                rows.append({**one, "island": row["owner"], "state": "ignored"})
        return [Waiting.of(row) for row in rows]

    async def approve(self, name: str, *, island: Union[int, str] = "") -> None:
        """Admits a device of the inbox: `wsn-1.7`, also an ignored one, or a pattern of those that wait."""
        await self._decide("approve", name, island)

    async def ignore(self, name: str, *, island: Union[int, str] = "") -> None:
        """Ignores a device of the inbox, or one that is listed."""
        await self._decide("ignore", name, island)

    async def _decide(self, decision: str, name: str, island: Union[int, str]) -> None:
        one = await self._island(island)
        await self.set(f"{one.id}:{one.prefix}.inbox", f"{decision} {name}")

    async def _island(self, island: Union[int, str]) -> Island:
        islands = await self.islands()
        owner = await self._owner(str(island))
        found = [one for one in islands if not owner or str(one.id) == owner]
        if not found:
            raise not_found("island", str(island), [str(one.id) for one in islands])
        if len(found) > 1:
            raise ambiguous("island", "island=", [str(one.id) for one in found])
        return found[0]

    async def settings(self, *, island: Union[int, str] = "") -> str:
        """The configuration in force, as YAML without secrets."""
        one = await self._island(island)
        return (await self.get(f"{one.id}:{one.prefix}.settings.value")).text or ""

    async def log(self, *, island: Union[int, str] = "") -> List[LogLine]:
        """The last 100 lines of the island's log."""
        one = await self._island(island)
        async with self.watch(f"{one.id}:{one.prefix}.log.lines") as watch:
            async for event in watch:
                rows = event.value if isinstance(event.value, list) else []
                return [LogLine(row["number"], utc(row["time"]), row["level"], row["subject"], row["text"]) for row in rows]
        return []


def _media(value: object) -> str:
    is_text = isinstance(value, (str, bytes, bool, int, float, datetime))
    return "text/plain" if is_text else "application/json"


def _bytes(value: object) -> bytes:
    text = text_of(value)
    return text if isinstance(text, bytes) else text.encode()


def _value(row: Json, about: Optional[Json] = None, status: Optional[Json] = None) -> Value:
    subject = Subject(row["owner"], row["key"], row.get("media", ""), about, status or {})
    return Value(subject, [0, row.get("value"), row.get("sequence", 0), row.get("user") or row.get("write") or 0])


def _points(rows: Iterable[Json], query: Query) -> Iterable[Value]:
    found: Dict[Tuple[int, str], Json] = {}
    for row in rows:
        base, _, leaf = row["key"].rpartition(".")
        found.setdefault((row["owner"], base), {})[leaf] = row
    for (_, base), leaves in found.items():
        if "value" in leaves and query.means(f"{base}.value"):
            about, status = (parsed(leaves.get(leaf, {}).get("value")) for leaf in ("description", "status"))
            yield _value(leaves["value"], about, status)
