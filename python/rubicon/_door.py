"""What a space needs of the way it reaches islands. Both doors have it: over the web, and in the process itself."""

from __future__ import annotations

import asyncio
from abc import ABC, abstractmethod
from typing import Any, Callable, Dict, List, Mapping, Optional

from ._errors import Error
from ._feed import Stream
from ._values import Island, Json, Message, Outcome, utc

FINAL = {"confirmed", "assumed", "applied", "refused", "failed", "timed-out", "expired", "superseded", "no-such-owner"}
NONE = Outcome("unknown", "the owner did not answer")


class Door(ABC):
    """Keys are `OWNER:KEY`, times and spans seconds. Every method that fails raises Error."""

    state = "connecting"  #: connecting, live, lost, closed

    @abstractmethod
    async def open(self) -> None: ...

    @abstractmethod
    async def close(self) -> None: ...

    @abstractmethod
    async def islands(self) -> List[Island]: ...

    @abstractmethod
    async def devices(self, query: Dict[str, str]) -> List[Json]:
        """As `rubicon devices --json`."""

    @abstractmethod
    async def read(self, pattern: str) -> List[Json]:
        """The present tuples: {owner, key, value, media, sequence, write, user}."""

    @abstractmethod
    def subscribe(self, stream: Stream) -> None:
        """Frames go to the stream, also after a reconnection, until `unsubscribe`."""

    @abstractmethod
    def unsubscribe(self, stream: Stream) -> None: ...

    @abstractmethod
    async def write(self, key: str, value: bytes, options: Json, wait: float) -> Outcome:
        """Sets, or appends with options["append"]; options are those of the API's `set`. Follows a command until its
        final state, at most `wait`."""

    @abstractmethod
    async def send(self, to: int, kind: str, data: bytes, network: str, device: str) -> None: ...

    @abstractmethod
    async def listen(self, kind: str, call: Callable[[Message], None]) -> None: ...

    @abstractmethod
    async def unlisten(self, kind: str, call: Callable[[Message], None]) -> None: ...

    async def history(self, path: str, accept: Optional[str] = None) -> Any:
        raise Error("unsupported", "a component has no history: ask the island's page for it, with rubicon.connect()")

    def own(self, key: str, value: bytes, media_type: str, lifetime: float) -> int:
        raise Error("unsupported", "own tuples need a component: rubicon.join()")

    def erase(self, key: str) -> None:
        raise Error("unsupported", "own tuples need a component: rubicon.join()")

    def judge(self, pattern: str, appends: bool, call: Callable[[Json], Optional[str]]) -> Callable[[], None]:
        """Until the result is called."""
        raise Error("unsupported", "own tuples need a component: rubicon.join()")


class Following:
    """Takes the answers to a set or a command, the last of which is final."""

    def __init__(self) -> None:
        self._outcome = NONE
        self._end: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    def take(self, answer: Json) -> None:
        self._outcome = outcome_of(self._outcome, answer)
        if self._outcome.state in FINAL or self._outcome.code == "unreachable":
            self._stop()

    def _stop(self) -> None:
        if not self._end.done():
            self._end.set_result(None)

    async def outcome(self, wait: float) -> Outcome:
        """How it stands at the final answer, or after `wait` seconds."""
        timer = asyncio.get_running_loop().call_later(wait, self._stop)
        try:
            await self._end
        finally:
            timer.cancel()
        return self._outcome


def outcome_of(before: Outcome, answer: Json) -> Outcome:
    request = answer.get("request", before.request)
    if answer.get("lost"):
        return Outcome("unknown", "the line to the server was lost", request, before.sequence, "unreachable")
    if answer.get("ok") is False:
        error = error_of(answer, "refused")
        unnamed = {"expired": "timed-out", "not-found": "no-such-owner"}.get(error.code, "refused")  # by older islands
        state = str(answer.get("verdict", unnamed))
        return Outcome(state, error.text, request, code=error.code)
    if "state" not in answer:
        return Outcome("queued", "", request, answer.get("sequence", 0))
    state = str(answer["state"])
    return Outcome(state, str(answer.get("reason", "")), request, answer.get("sequence", before.sequence),
                   "refused" if state == "refused" else "", utc(answer["until"]) if "until" in answer else None)


def error_of(answer: Mapping[str, Any], otherwise: str) -> Error:
    """The error of an answer: {"error": {"code", "text"}}."""
    error = answer.get("error")
    if not isinstance(error, dict):
        return Error("io", otherwise)
    return Error(str(error.get("code", "io")), str(error.get("text", otherwise)))
