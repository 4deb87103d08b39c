"""What an island says, as values of Python. Times are datetimes in UTC, None = never or not known."""

from __future__ import annotations

import html
import json
import re
from dataclasses import dataclass, field, fields
from datetime import datetime, timedelta, timezone
from typing import Any, Dict, List, NamedTuple, Optional, Tuple, Union

from ._errors import Error

Json = Dict[str, Any]
Span = Union[str, int, float, timedelta]
When = Union[Span, datetime]  #: a span is before now

_EPOCH = datetime(1970, 1, 1, tzinfo=timezone.utc)
_UNITS = {"1": "", "Cel": "°C", "[degF]": "°F", "[ppm]": "ppm", "[ppb]": "ppb", "deg": "°", "dB[mW]": "dBm",
          "W.h": "Wh", "kW.h": "kWh", "MW.h": "MWh", "V.A": "VA", "Ohm": "Ω", "/min": "1/min"}
_SECONDS = {"ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0, "w": 604800.0}
_TRUE = {"on", "true", "1", "yes"}
_FALSE = {"off", "false", "0", "no"}


def utc(seconds: object) -> Optional[datetime]:
    """Seconds since 1970, or their text, as a datetime; None for 0 and for what is no time."""
    try:
        number = float(seconds) if isinstance(seconds, (int, float, str)) else 0.0
        return _EPOCH + timedelta(seconds=number) if number else None
    except (OverflowError, ValueError):
        return None


def seconds_of(span: Span, what: str) -> float:
    """A span in seconds: a number, a timedelta, or a text such as `250ms`, `5min`, `7d`."""
    if isinstance(span, timedelta):
        return span.total_seconds()
    if isinstance(span, (int, float)) and not isinstance(span, bool) and span >= 0:
        return float(span)
    match = re.fullmatch(r"(\d+(?:\.\d+)?) ?(ms|s|min|h|d|w)", span) if isinstance(span, str) else None
    if not match:
        raise Error("invalid", f"{what} is {span!r}; expected a span such as 250ms, 5s, 5min, 2h, 7d")
    return float(match[1]) * _SECONDS[match[2]]


def moment(when: When, now: float, what: str) -> float:
    """Seconds since 1970 of a datetime, or of a span before now. A datetime without a zone is local time."""
    return when.timestamp() if isinstance(when, datetime) else now - seconds_of(when, what)


def text_of(value: object) -> Union[str, bytes]:
    """What a value is written as in a tuple."""
    if isinstance(value, (str, bytes)):
        return value
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, datetime):
        return value.astimezone(timezone.utc).isoformat()
    return json.dumps(value)


def parsed(text: object) -> Json:
    """The JSON object of a text; an empty one if it is none."""
    try:
        value = json.loads(text) if isinstance(text, str) else {}
    except ValueError:
        value = {}
    return value if isinstance(value, dict) else {}


def unit_text(code: str) -> str:
    """A UCUM code as people write it."""
    return _UNITS.get(code, code)


class Subject:
    """A tuple and what is known of it beside its value. Shared by all values of it."""

    __slots__ = ("owner", "key", "media", "about", "status", "entry", "before", "plain", "absent", "waits", "merged")

    def __init__(self, owner: int, key: str, media: str = "", about: Optional[Json] = None, status: Json = {}) -> None:
        self.owner = owner
        self.key = key
        self.media = media
        self.about: Json = about or {}
        self.status = status
        self.entry: List[Any] = []
        self.before: Optional[List[Any]] = None
        self.plain = False
        self.absent = False
        self.waits = ""  # to be read by a program: Event.kind, or again
        self.merged = 0


class Value:
    """A tuple as it was at one moment. Of a point (`...value`) it has unit and quality as well."""

    __slots__ = ("_subject", "_status", "_entry")

    def __init__(self, subject: Subject, entry: List[Any]) -> None:
        self._subject = subject
        self._status = subject.status
        self._entry = entry

    @property
    def owner(self) -> int:
        """Id of the component that has the tuple."""
        return self._subject.owner

    @property
    def key(self) -> str:
        """`proxy.wsn-1.7.sensor.light-1.value`"""
        return self._subject.key

    @property
    def name(self) -> str:
        """`7.light-1` of a point, as calls take it; else the key."""
        parts = self.key.split(".")
        return f"{parts[2]}.{parts[4]}" if len(parts) == 6 else self.key

    @property
    def text(self) -> Optional[str]:
        """The value as it came; None if it is no text, or longer than 16 KiB in a watch."""
        text = self._entry[1] if len(self._entry) > 1 else None
        return text if isinstance(text, str) else None

    @property
    def value(self) -> Any:
        """float, int, bool or str by the type of the point, a datetime where its text is a time; of JSON what it
        means. None: nothing was reported yet, or `text` is None."""
        return _decoded(self.text, self._subject)

    @property
    def sequence(self) -> int:
        """Grows with each set of the tuple."""
        number = self._entry[2] if len(self._entry) > 2 else 0
        return number if isinstance(number, int) else 0

    @property
    def time(self) -> Optional[datetime]:
        """When it was measured, else when it was written."""
        return utc(self._entry[3]) if len(self._entry) > 3 else None

    @property
    def media_type(self) -> str:
        return self._subject.media or "text/plain"

    @property
    def type(self) -> str:
        """Of the point: `temperature`."""
        return str(self._subject.about.get("type", ""))

    @property
    def unit(self) -> str:
        """As people write it: °C, lx, %. Empty = none."""
        return unit_text(str(self._subject.about.get("unit", "")))

    @property
    def words(self) -> List[str]:
        """The words that an enumeration or a boolean may have, from 0 on."""
        words = self._subject.about.get("words")
        return [str(word) for word in words] if isinstance(words, list) else []

    @property
    def quality(self) -> str:
        """good, assumed, stored, stale, unknown, bad, device-offline or network-down (docs/tuple-keys.md). Empty: the
        tuple is no point."""
        return "network-down" if self._subject.absent else str(self._status.get("quality", ""))

    @property
    def good(self) -> bool:
        return self.quality == "good"

    @property
    def reason(self) -> str:
        """Why the quality is not good."""
        return "its island left" if self._subject.absent else str(self._status.get("reason", ""))

    @property
    def heard(self) -> Optional[datetime]:
        """When the last good value came; it may have been equal to the one before."""
        return utc(self._status.get("heard"))

    @property
    def changed(self) -> Optional[datetime]:
        """When the value last differed from the one before."""
        return utc(self._status.get("changed"))

    def __str__(self) -> str:
        value = self.value
        return f"{value if isinstance(value, (int, float)) else self.text or '-'} {self.unit}".rstrip()

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.owner}:{self.key} {self} {self.quality}>".replace(" >", ">")

    def _repr_html_(self) -> str:
        return _table([self])


class Event(Value):
    """A value that a watch delivers."""

    __slots__ = ("_how", "merged")

    __init__ = object.__init__  # type: ignore[assignment]  # a feed fills it, in half the time
    _how: str
    #: So many values of this tuple were replaced by this one, because the program did not read them in time.
    merged: int

    @property
    def kind(self) -> str:
        """value: it was set, also to an equal value. state: its quality or the reason changed, not the value. gone: the
        tuple was deleted, expired, or its owner did not return (`reason`)."""
        return "value" if self._how == "again" else self._how

    @property
    def again(self) -> bool:
        """The value was delivered before: it came once more because the line to the server was lost."""
        return self._how == "again"


def _decoded(text: Optional[str], subject: Subject) -> Any:
    if not text:
        return None
    about = subject.about
    data_type = about.get("data_type")
    try:
        if data_type == "real":
            return float(text)
        if data_type == "integer":
            return int(text)
        if data_type == "boolean":
            words = about.get("words") or ["off", "on"]
            return bool(words.index(text)) if text in words else _boolean(text)
        if subject.media == "application/json" or data_type == "json":
            return json.loads(text)
        if about.get("type") == "dateTime":
            return datetime.fromisoformat(text)
    except (ValueError, AttributeError, TypeError):
        pass
    return text


def _boolean(text: str) -> Union[bool, str]:
    return True if text in _TRUE else False if text in _FALSE else text


@dataclass(frozen=True)
class Island:
    """An island that is present."""

    id: int
    name: str
    host: str = ""
    program: str = ""
    version: str = ""
    prefix: str = "proxy"  #: first part of its keys
    networks: Dict[str, int] = field(default_factory=dict)  #: number of devices by network
    devices: int = 0
    since: Optional[datetime] = None

    @classmethod
    def of(cls, row: Json) -> Island:
        return cls(**_members(cls, row))


@dataclass(frozen=True)
class Device:
    """A device as its island lists it. `str(device)` and a cell of a notebook show it as a table."""

    island: int
    key: str  #: `proxy.wsn-1.7`
    network: str
    id: str
    name: str = ""
    area: str = ""
    model: str = ""
    type: str = ""
    address: str = ""
    status: str = "unknown"  #: unknown, reachable or unreachable
    reason: str = ""
    since: Optional[datetime] = None
    line: str = ""  #: of its network: up, down, connecting, refused, ended
    line_reason: str = ""
    sensors: Tuple[str, ...] = ()
    actuators: Tuple[str, ...] = ()
    properties: Tuple[str, ...] = ()
    points: Tuple[Value, ...] = field(default=(), repr=False, compare=False)  #: of `device()` only

    @classmethod
    def of(cls, row: Json) -> Device:
        return cls(**_members(cls, row))

    def __getitem__(self, point: str) -> Value:
        """The point with this id: `device["light-1"]`. Raises KeyError."""
        for value in self.points:
            if value.key.split(".")[4] == point:
                return value
        raise KeyError(f"{point}; expected one of {', '.join(value.key.split('.')[4] for value in self.points)}")

    def __str__(self) -> str:
        rows = [f"{self.key}  {self.name}  {self.status}" + (f"  {self.reason}" if self.reason else "")]
        rows += [f"  {value.key.split('.')[4]:24} {value!s:>16}  {value.quality}" for value in self.points]
        return "\n".join(rows)

    def _repr_html_(self) -> str:
        title = f"<b>{html.escape(self.name or self.id)}</b> {html.escape(self.key)}, {html.escape(self.status)}"
        return f"{title} {html.escape(self.reason)}" + (_table(self.points) if self.points else "")


class Devices(List[Device]):
    """A list of devices that a notebook shows as a table."""

    def _repr_html_(self) -> str:
        names = ("island", "key", "name", "area", "type", "status", "reason")
        return _rows(names, [[str(getattr(device, name)) for name in names] for device in self])


class Values(List[Value]):
    """A list of values that a notebook shows as a table."""

    def _repr_html_(self) -> str:
        return _table(self)


class Outcome(NamedTuple):
    """How a command ended (docs/life-of-a-command.md)."""

    #: confirmed, assumed, applied; refused, failed, timed-out, expired, superseded, no-such-owner; queued, sent: `wait`
    #: was over; unknown: the line to the server was lost.
    state: str
    reason: str = ""
    request: int = 0
    sequence: int = 0  #: of the tuple after the set
    code: str = ""  #: of a refusal, as in Error.code
    until: Optional[datetime] = None  #: latest end of a state that is not final

    @property
    def good(self) -> bool:
        return self.state in ("confirmed", "assumed", "applied")


@dataclass(frozen=True)
class Message:
    """What another component, or a device, sent to this one."""

    sender: int  #: id of the component or island
    type: str
    data: bytes
    network: str = ""
    device: str = ""  #: in the notation of its network; empty = the component itself


@dataclass(frozen=True)
class RemoteSet:
    """What another component wants to set of a tuple of this one."""

    sender: int
    key: str
    data: bytes
    media_type: str = "text/plain"
    append: bool = False  #: to the present value
    asker: str = ""  #: who asked for it, as `sender` says: `user:ann`, `token:tablet`; empty = its own

    @property
    def value(self) -> str:
        """The data as text; bytes that are none are replaced."""
        return self.data.decode(errors="replace")

    @classmethod
    def of(cls, row: Json) -> RemoteSet:
        return cls(row["from"], row["key"], row["value"], row["media"], row["append"], row["asker"])


@dataclass(frozen=True)
class Waiting:
    """A device in the inbox of an island."""

    island: int
    key: str  #: as approve() and ignore() take it
    state: str  #: waiting or ignored
    name: str = ""
    network: str = ""
    address: str = ""
    type: str = ""
    model: str = ""
    why: str = ""
    since: Optional[datetime] = None

    @classmethod
    def of(cls, row: Json) -> Waiting:
        return cls(**_members(cls, row))


@dataclass(frozen=True)
class LogLine:
    number: int
    time: Optional[datetime]
    level: str  #: debug, info, warning, error
    subject: str
    text: str


class Sample(NamedTuple):
    """A bucket of a history that has values (docs/history.md#answers)."""

    time: datetime  #: when the bucket begins
    key: str
    value: Union[float, str, None]  #: the last one; None: a gap begins
    first: Union[float, str, None] = None
    minimum: Union[float, str, None] = None
    maximum: Union[float, str, None] = None
    mean: Optional[float] = None  #: by time; None of texts
    n: int = 0  #: how many came


def _members(cls: Any, row: Json) -> Json:
    """Of a JSON object those that a class has; lists as tuples, `since` as a datetime."""
    names = [one.name for one in fields(cls)]
    members = {name: tuple(value) if isinstance(value, list) else value for name, value in row.items() if name in names}
    if "since" in members:
        members["since"] = utc(members["since"])
    return members


def _table(values: Any) -> str:
    rows = [[value.name, str(value), value.quality, value.reason, f"{value.time:%Y-%m-%d %H:%M:%S}" if value.time else ""]
            for value in values]
    return _rows(("name", "value", "quality", "reason", "time (UTC)"), rows)


def _rows(names: Any, rows: List[List[str]]) -> str:
    head = "".join(f"<th>{name}</th>" for name in names)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>"
