"""Names of tuples as people write them: docs/cli.md#names-of-tuples."""

from __future__ import annotations

import difflib
import re
from functools import lru_cache
from typing import TYPE_CHECKING, Iterable, List, Mapping, NamedTuple, Optional, Pattern, Tuple, TypeVar

from ._errors import Error

if TYPE_CHECKING:
    from ._values import Device

KINDS = ("sensor", "actuator", "property")
MAX_ISLAND = 65532  #: other components have higher ids
_PART = re.compile(r"[A-Za-z0-9_?*-]+")


@lru_cache(1000)
def split_owner(name: str) -> Tuple[str, str]:
    """`6541:proxy.x` -> ("6541", "proxy.x"); ("", name) where it names none. `*` counts as none."""
    owner, colon, rest = name.rpartition(":")
    if colon and not owner or not rest or not all(map(_PART.fullmatch, rest.split("."))):
        raise Error("invalid", f"name {name!r}: expected OWNER:KEY, a key, or DEVICE.POINT such as living.lamp-1")
    return ("" if owner == "*" else owner), rest


@lru_cache(1000)
def whole(owner: str, key: str, leaf: str) -> Optional[Tuple[str, str]]:
    """Owner and key of a tuple, where they name one whole; a point gets the leaf. None: it has to be looked up."""
    parts = key.split(".")
    if not owner or len(parts) in (2, 3) and int(owner) <= MAX_ISLAND:
        return None
    return owner, f"{key}.{leaf}" if len(parts) == 5 and parts[3] in KINDS else key


def has_wildcard(name: str) -> bool:
    return "*" in name or "?" in name


class Query(NamedTuple):
    """A pattern that servers know, and which of the keys that match it are meant."""

    key: str
    wanted: Optional[Pattern[str]]  #: None: all

    def means(self, key: str) -> bool:
        return self.wanted is None or bool(self.wanted.fullmatch(key))


def query_of(key: str, leaf: str = "value") -> Query:
    """Of a key with `*`, `**`, and `*` and `?` within parts. Short names (`living.*`, `dummy-rooms.*.light-1`) and
    points (`proxy.*.*.sensor.light-1`) get the leaf."""
    parts = key.split(".")
    if parts[-1] != "**":
        if len(parts) in (2, 3) and parts[0] != "proxy":
            parts = ["*"] * (4 - len(parts)) + parts[:-1] + ["*", parts[-1], leaf]
        elif len(parts) == 5 and (parts[3] in KINDS or has_wildcard(parts[3])):
            parts.append(leaf)
    asked = [part if part in ("*", "**") or not has_wildcard(part) else "*" for part in parts]
    if asked == parts:
        return Query(".".join(parts), None)
    return Query(".".join(asked), re.compile(r"\.".join(_expression(part) for part in parts)))


def _expression(part: str) -> str:
    if part == "**":
        return ".*"
    return "".join("[^.]*" if char == "*" else "[^.]" if char == "?" else re.escape(char) for char in part)


T = TypeVar("T")
Islands = Mapping[int, str]  #: names by id


def take_islands(islands: Islands, text: str) -> Tuple[Optional[List[int]], str]:
    """The islands that stand in front of a name, None = any, and the rest. A colon behind anything else is a part of the
    name."""
    front, colon, rest = text.partition(":")
    if colon and front == "*":
        return None, rest
    if colon and front.isdigit():
        return [int(front)], rest
    for found in ([number for number, name in islands.items() if name == front],
                  [number for number, name in islands.items() if name.casefold() == front.casefold()]):
        if colon and front and found:
            return found, rest
    return None, text


def _rank_of_device(word: str, device: Device) -> Optional[int]:
    """By its key, by what people call it, the same without case, by its area."""
    keys = (device.id, f"{device.network}.{device.id}", device.key)
    names = tuple(filter(None, (device.name, device.address)))
    small = word.casefold()
    fits = (word in keys, word in names, small in map(str.casefold, keys + names), word and word == device.area,
            word and small == device.area.casefold())
    return next((rank for rank, fit in enumerate(fits) if fit), None)


def _rank_of_point(word: str, kind: str, point: str) -> Optional[int]:
    """By its id, without case, by its type, by the name in its id. The id of a property is none of its own."""
    small, (kind_of, dash, name) = word.casefold(), point.partition("-")
    own = dash and kind != "property"
    fits = (word == point, small == point.casefold(), own and small == kind_of.casefold(),
            own and small == name.casefold() and not name.isdigit())
    return next((rank for rank, fit in enumerate(fits) if fit), None)


def _best(ranked: Iterable[Tuple[Optional[int], T]]) -> List[T]:
    known = [(rank, one) for rank, one in ranked if rank is not None]
    best = min((rank for rank, _ in known), default=None)
    return [one for rank, one in known if rank == best]


def devices_called(devices: Iterable[Device], islands: Islands, text: str) -> List[Device]:
    """The devices that people may call so."""
    among, word = take_islands(islands, text)
    return _best((_rank_of_device(word, one), one) for one in devices if among is None or one.island in among)


def points_called(devices: Iterable[Device], islands: Islands, text: str, settable: bool) -> List[Tuple[str, str]]:
    """Island and key of the points that `[ISLAND:]DEVICE.POINT` may mean; with `*` or `?` in POINT the kind is `*`."""
    among, rest = take_islands(islands, text)
    word, _, point = rest.rpartition(".")
    ranked: List[Tuple[Optional[int], List[Tuple[str, str]]]] = []
    for device in devices:
        if word and point and (among is None or device.island in among):
            found = _points_in(device, point, settable)
            ranked.append((_rank_of_device(word, device) if found else None, found))
    return [one for found in _best(ranked) for one in found]


def _points_in(device: Device, point: str, settable: bool) -> List[Tuple[str, str]]:
    places = [(kind, one) for kind, ids in zip(KINDS, (device.sensors, device.actuators, device.properties))
              for one in ids if not settable or kind != "sensor"]
    if has_wildcard(point):
        fit = re.compile(_expression(point)).fullmatch
        return [(str(device.island), f"{device.key}.*.{point}")] if any(fit(one) for _, one in places) else []
    best = _best((_rank_of_point(point, kind, one), (kind, one)) for kind, one in places)
    return [(str(device.island), f"{device.key}.{kind}.{one}") for kind, one in best]


def is_like_name(text: str) -> bool:
    """Whether a text that is no key may be a name."""
    return bool(text.strip(".") == text and text and ".." not in text and text.isprintable())


def not_found(what: str, name: str, known: Iterable[str]) -> Error:
    """What to raise where nothing has that name, with the nearest names."""
    near = difflib.get_close_matches(name, list(known), 3, 0.5)
    return Error("not-found", f"no {what} {name!r}" + (f"; did you mean {_or(near)}?" if near else ""), near)


def ambiguous(what: str, name: str, found: Iterable[str]) -> Error:
    """What to raise where several have that name."""
    candidates = sorted(found)
    more = f" and {len(candidates) - 8} more" if len(candidates) > 8 else ""
    return Error("invalid", f"{name!r} names several {what}s: {', '.join(candidates[:8])}{more}", candidates)


def _or(names: Iterable[str]) -> str:
    *first, last = names
    return f"{', '.join(first)} or {last}" if first else last
