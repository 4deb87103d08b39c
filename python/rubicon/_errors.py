"""What fails: a code for programs, and a text for people."""

from __future__ import annotations

from typing import TYPE_CHECKING, Sequence

if TYPE_CHECKING:
    from ._values import Outcome


class Error(Exception):
    """A call failed.

    `code` is one of docs/errors.md: invalid, not-found, out-of-range, unsupported, refused, busy, expired, duplicate,
    unreachable, io. `text` says what failed and what was expected. `candidates` are names that may have been meant.
    """

    def __init__(self, code: str, text: str, candidates: Sequence[str] = ()) -> None:
        super().__init__(code, text, tuple(candidates))
        self.code = code
        self.text = text
        self.candidates = tuple(candidates)

    def __str__(self) -> str:
        return f"{self.code}: {self.text}"


class Refused(Error):
    """A command with `check=True` that did not end well. `outcome` says how it ended."""

    def __init__(self, outcome: Outcome, key: str) -> None:
        text = f"{key}: {outcome.state}" + (f", {outcome.reason}" if outcome.reason else "")
        super().__init__(outcome.code or "refused", text)
        self.outcome = outcome
