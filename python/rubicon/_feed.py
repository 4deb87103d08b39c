"""What a program watches: subscriptions, made one stream of events, of which one waits for each tuple at most."""

from __future__ import annotations

import asyncio
from collections import deque
from types import TracebackType
from typing import Any, AsyncIterator, Awaitable, Callable, Deque, Dict, Iterable, Iterator, List, NamedTuple, Optional, Set, Type

from ._errors import Error
from ._names import Query
from ._values import Event, Json, Subject, parsed

MAX_EVENTS = 1000  #: events (buttons, scenes), each of which counts, that wait; then the oldest are dropped
MAX_WOKEN = 200  #: distinct patterns that an active watch with `*` within parts wakes


class Flow(NamedTuple):
    """How often values come, in seconds: at most one in `minimum`, the present one again after `maximum` (0 = never);
    changes of numbers by less than `dead_band` do not."""

    minimum: Optional[float] = None
    maximum: float = 0
    dead_band: float = 0
    passive: bool = False


class Stream:
    """One subscription at the server, whose frames (docs/api.md#subscribe) go to its feed."""

    def __init__(self, feed: Feed, pattern: str, flow: Flow, role: str, full: bool = False) -> None:
        self.feed = feed
        self.pattern = pattern
        self.flow = flow
        self.role = role  #: value, status, description
        self.full = full
        self.numbers: Dict[int, Subject] = {}

    def take(self, frame: Json) -> None:
        """Raises TypeError, ValueError, LookupError or AttributeError if the frame is none."""
        for owner in frame.get("absent", ()):
            self.feed.absent(owner, True)
        for owner in frame.get("present", ()):
            self.feed.absent(owner, False)
        for number, name in frame.get("k", {}).items():
            subject = self.feed.subject(name, self.role)
            if subject is not None:
                self.numbers[int(number)] = subject
        if "set" in frame:
            self.feed.take(self.role, self.numbers, frame["set"])
        for number, how in frame.get("gone", ()):
            gone = self.numbers.pop(number, None)
            if gone is not None and self.role == "value":
                self.feed.gone(gone, str(how))
        if "snapshot" in frame:
            self.feed.snapshot(self.role, frame["snapshot"])


class Feed:
    """Begins with `start`, which gets the streams one after the other, and ends with `end`."""

    def __init__(self, owner: str, query: Query, flow: Flow, start: Callable[[Stream], None]) -> None:
        self.queue: Deque[Subject] = deque()  # whose latest value waits, or whose state; and some that do no more
        self.loose: Deque[Event] = deque(maxlen=MAX_EVENTS)  # those that no later one may replace
        self.lost = 0
        self.error: Optional[Error] = None
        self.ended = False
        self.streams: List[Stream] = []
        self._merged = 0  # of events that were read
        self._start = start
        self._owner = owner
        self._query = query
        self._flow = flow
        self._subjects: Dict[str, Subject] = {}
        self._held: Dict[int, Dict[Subject, List[Any]]] = {}
        self._snapshots: Dict[int, Set[str]] = {}
        self._woken: Set[str] = set()
        self._waiter: Optional[asyncio.Future[None]] = None
        self._is_point = query.key.endswith(".value") and query.key.count(".") == 5
        self._missing: Set[str] = set()  # names from before the line was lost that did not come again
        self._by_key = self._is_point and query.wanted is not None and not flow.passive

    @property
    def merged(self) -> int:
        return self._merged + sum(subject.merged for subject in self.queue)

    def begin(self) -> None:
        passive = Flow(passive=True)
        if self._is_point:
            base = f"{self._owner}:{self._query.key[:-len('value')]}"
            self._add(Stream(self, base + "description", passive, "description"))
            self._add(Stream(self, base + "status", passive, "status"))
        if not self._by_key:
            self._add(Stream(self, f"{self._owner}:{self._query.key}", self._flow, "value", not self._is_point))

    def _add(self, stream: Stream) -> None:
        self.streams.append(stream)
        self._start(stream)

    # -- what streams say

    def subject(self, name: str, role: str) -> Optional[Subject]:
        """The tuple of a name, the value where it is the status or the description; None: it is not meant."""
        owner, key = name.split(":", 1)
        if self._is_point:
            key = key[: key.rindex(".") + 1] + "value"
        if not self._query.means(key):
            return None
        subject = self._subjects.get(f"{owner}:{key}")
        if subject is None:
            subject = self._subjects[f"{owner}:{key}"] = Subject(int(owner), key)
        if role == ("description" if self._by_key else "value"):
            self._missing.discard(f"{owner}:{key}")
            if self._by_key:
                self._wake(key)
        return subject

    def _wake(self, key: str) -> None:
        """Subscribes to this value, and to those that differ only where the pattern has `*` for a part."""
        parts = [own if own == "*" else part for own, part in zip(self._query.key.split("."), key.split("."))]
        assert self._query.wanted is not None
        for place, source in enumerate(self._query.wanted.pattern.split(r"\.")):
            if source != "[^.]*":
                parts[place] = key.split(".")[place]
        pattern = f"{self._owner}:{'.'.join(parts)}"
        if pattern in self._woken:
            return
        if len(self._woken) >= MAX_WOKEN:
            text = f"more than {MAX_WOKEN} kinds of points match; give a narrower pattern, or passive=True"
            return self.fail(Error("out-of-range", text))
        self._woken.add(pattern)
        self._add(Stream(self, pattern, self._flow, "value"))

    def take(self, role: str, numbers: Dict[int, Subject], entries: Iterable[List[Any]]) -> None:
        if role == "value":
            self._take_values(numbers, entries)
        else:
            for entry in entries:
                subject = numbers.get(entry[0])
                if subject is not None:
                    self._know(subject, role, parsed(entry[1]))
        self._notify()

    def _take_values(self, numbers: Dict[int, Subject], entries: Iterable[List[Any]]) -> None:
        find = numbers.get
        append = self.queue.append
        for entry in entries:
            subject = find(entry[0])
            if subject is None:
                continue
            if not subject.plain:
                self._first(subject, entry)
                continue
            subject.entry = entry
            if not subject.waits:
                subject.waits = "value"
                append(subject)
            else:
                subject.merged += subject.waits != "state"
                subject.waits = "value"

    def _first(self, subject: Subject, entry: List[Any]) -> None:
        """The first value of a line, of a tuple that is not in the usual course, or of one whose values all count."""
        if len(entry) > 4:
            subject.media = str(entry[4].get("m") or subject.media)
        if self._is_point and not self._snapshots.get(subject.owner, set()) >= {"status", "description"}:
            self._held.setdefault(subject.owner, {})[subject] = entry
            return
        how = "again" if subject.before is not None and subject.before[1:4] == entry[1:4] else "value"
        subject.entry, subject.before = entry, None
        if self._is_point and entry[1] == "":
            return  # nothing was reported yet, or an event is over
        if subject.about.get("report") == "event":
            return self._append_loose(_event(subject, how))
        subject.merged += subject.waits not in ("", "state")
        self._append(subject, "value" if subject.waits else how)
        subject.plain = bool(subject.about)  # others may change their media type

    def _append(self, subject: Subject, how: str) -> None:
        if not subject.waits:
            self.queue.append(subject)
        subject.waits = how

    def _append_loose(self, event: Event) -> None:
        self.lost += len(self.loose) == MAX_EVENTS
        self.loose.append(event)

    def _know(self, subject: Subject, role: str, content: Json) -> None:
        if role == "description":
            subject.about = content
            return
        before, subject.status = subject.status, content
        if before and (before.get("quality"), before.get("reason")) != (content.get("quality"), content.get("reason")):
            self._state(subject)

    def _state(self, subject: Subject) -> None:
        if subject.entry and not subject.waits and (subject.plain or not self._is_point):
            self._append(subject, "state")

    def gone(self, subject: Subject, how: str) -> None:
        if self._subjects.pop(f"{subject.owner}:{subject.key}", None) is None:
            return
        if subject.waits:
            self._append_loose(_event(subject, subject.waits))
            subject.waits = ""
        if subject.entry:
            subject.status = {"quality": "unknown", "reason": how}
            self._append_loose(_event(subject, "gone"))
        subject.entry = []
        self._held.get(subject.owner, {}).pop(subject, None)
        if len(self.queue) > 2 * len(self._subjects) + MAX_EVENTS:  # most wait no more
            waiting = [one for one in self.queue if one.waits]
            self.queue.clear()
            self.queue.extend(waiting)
        self._notify()

    def snapshot(self, role: str, owner: int) -> None:
        seen = self._snapshots.setdefault(owner, set())
        seen.add(role)
        if role == ("description" if self._by_key else "value"):
            self._lose(lambda subject: subject.owner == owner)
        if seen >= {"status", "description"}:
            for subject, entry in self._held.pop(owner, {}).items():
                self._first(subject, entry)
        self._notify()

    def patience_ended(self) -> None:
        """Some seconds after a reconnection: owners that have not sent their tuples by then are gone."""
        self._lose(lambda subject: subject.owner not in self._snapshots)

    def _lose(self, which: Callable[[Subject], bool]) -> None:
        for name in list(self._missing):
            subject = self._subjects.get(name)
            if subject is None or which(subject):
                self._missing.discard(name)
                if subject is not None:
                    self.gone(subject, "lost")

    def absent(self, owner: int, absent: bool) -> None:
        for subject in self._subjects.values():
            if subject.owner == owner and subject.absent != absent:
                subject.absent = absent
                self._state(subject)
        self._notify()

    # -- what the door says

    def restart(self) -> None:
        """The line was lost: numbers no longer count, and all values come again."""
        self._snapshots.clear()
        self._held.clear()
        for name, subject in self._subjects.items():
            if subject.entry:
                subject.before = subject.entry
                self._missing.add(name)
            subject.plain = False
        for stream in self.streams:
            stream.numbers.clear()

    def fail(self, error: Error) -> None:
        self.error = self.error or error
        self._notify()

    def end(self) -> None:
        self.ended = True
        self._notify()

    # -- what the program asks

    def waiting(self) -> Iterator[Event]:
        """What waits, each as it is when it is asked for."""
        queue, loose = self.queue, self.loose
        while True:
            while loose:
                yield loose.popleft()
            if not queue:
                return
            subject = queue.popleft()
            if not subject.waits:
                continue
            event = Event()  # as _event(), without a call: this is what a watch spends its time with
            event._subject = subject
            event._status = subject.status
            event._entry = subject.entry
            event._how = subject.waits
            event.merged = merged = subject.merged
            subject.waits = ""
            if merged:
                self._merged += merged
                subject.merged = 0
            yield event

    async def wait(self) -> bool:
        """Until an event waits; False: the watch ended. Raises what made it fail."""
        while not (self.queue or self.loose):
            if self.error is not None:
                raise self.error
            if self.ended:
                return False
            self._waiter = asyncio.get_running_loop().create_future()
            await self._waiter
        return True

    def _notify(self) -> None:
        waiter = self._waiter
        if waiter is not None and not waiter.done() and (self.queue or self.loose or self.ended or self.error):
            waiter.set_result(None)


def _event(subject: Subject, how: str) -> Event:
    event: Event = Event()
    event._subject = subject
    event._status = subject.status
    event._entry = subject.entry
    event._how = how
    event.merged = subject.merged
    return event


class Watch:
    """The events of `space.watch()`, for `async for`. It ends its subscription when the program drops it.

    Of each tuple at most one event waits: a later value takes its place, and `event.merged` counts. Events of buttons
    and scenes are all kept, the latest 1,000 of them. `merged` and `lost` are the sums of this watch."""

    def __init__(self, begin: Callable[[], Awaitable[Feed]], end: Callable[[Feed], None]) -> None:
        self._begin = begin
        self._end = end
        self._feed: Optional[Feed] = None

    @property
    def merged(self) -> int:
        return self._feed.merged if self._feed else 0

    @property
    def lost(self) -> int:
        return self._feed.lost if self._feed else 0

    async def start(self) -> Feed:
        """Subscribes. `async for` and `async with` do it too. Raises Error if the name fits nothing or several."""
        if self._feed is None:
            self._feed = await self._begin()
        return self._feed

    async def __aiter__(self) -> AsyncIterator[Event]:
        feed = await self.start()
        while await feed.wait():
            for event in feed.waiting():
                yield event

    async def batch(self) -> List[Event]:
        """All events that wait, at least one; an empty list when the watch ended."""
        feed = await self.start()
        while await feed.wait():
            events = list(feed.waiting())
            if events:
                return events
        return []

    def close(self) -> None:
        """Ends the subscription, and with it the demand for what was watched."""
        if self._feed is not None and not self._feed.ended:
            self._end(self._feed)

    async def __aenter__(self) -> Watch:
        await self.start()
        return self

    async def __aexit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                        trace: Optional[TracebackType]) -> None:
        self.close()

    def __del__(self) -> None:
        self.close()
