"""Names of tuples as people write them: docs/cli.md#names-of-tuples."""

from __future__ import annotations

import difflib
import re
from typing import Iterable, NamedTuple, Optional, Pattern, Tuple

from ._errors import Error

KINDS = ("sensor", "actuator", "property")
_PART = re.compile(r"[A-Za-z0-9_?*-]+")


def split_owner(name: str) -> Tuple[str, str]:
    """`6541:proxy.x` -> ("6541", "proxy.x"); ("", name) where it names none. `*` counts as none."""
    owner, colon, rest = name.rpartition(":")
    if colon and not owner or not rest or not all(map(_PART.fullmatch, rest.split("."))):
        raise Error("invalid", f"name {name!r}: expected OWNER:KEY, a key, or DEVICE.POINT such as living.lamp-1")
    return ("" if owner == "*" else owner), rest


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
    whole = [part if part in ("*", "**") or not has_wildcard(part) else "*" for part in parts]
    if whole == parts:
        return Query(".".join(parts), None)
    return Query(".".join(whole), re.compile(r"\.".join(_expression(part) for part in parts)))


def _expression(part: str) -> str:
    if part == "**":
        return ".*"
    return "".join("[^.]*" if char == "*" else "[^.]" if char == "?" else re.escape(char) for char in part)


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
