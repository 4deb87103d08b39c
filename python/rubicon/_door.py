"""What a space needs of the way it reaches islands. Both doors have it: over the web, and in the process itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, Callable, Dict, List, Optional

from ._feed import Stream
from ._values import Island, Json, Message, Outcome


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
        """The present tuples: {owner, key, value, mimetype, seq, write, user}."""

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
        from ._errors import Error

        raise Error("unsupported", "a component has no history: ask the island's page for it, with rubicon.connect()")
