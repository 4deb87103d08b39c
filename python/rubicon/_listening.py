"""What others send to this component, and what they want to set."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import Callable, Deque

from ._door import Door
from ._values import Message

MAX_MESSAGES = 1000  #: that wait to be read; then the oldest are dropped


class Messages:
    """An async iterator of Message. At most 1,000 wait; `lost` counts those that were dropped."""

    def __init__(self, door: Door, kind: str) -> None:
        self.lost = 0
        self._door = door
        self._kind = kind
        self._queue: Deque[Message] = deque()
        self._more = asyncio.Event()
        self._listens = False

    def _take(self, message: Message) -> None:
        if len(self._queue) >= MAX_MESSAGES:
            self._queue.popleft()
            self.lost += 1
        self._queue.append(message)
        self._more.set()

    async def __aenter__(self) -> Messages:
        if not self._listens:
            self._listens = True
            await self._door.listen(self._kind, self._take)
        return self

    async def __aexit__(self, *_: object) -> None:
        self._listens = False
        await self._door.unlisten(self._kind, self._take)

    def __aiter__(self) -> Messages:
        return self

    async def __anext__(self) -> Message:
        await self.__aenter__()
        while not self._queue:
            self._more.clear()
            await self._more.wait()
        return self._queue.popleft()


class Judge:
    """Ends with close(), or at the end of `with`."""

    def __init__(self, end: Callable[[], None]) -> None:
        self.close = end

    def __enter__(self) -> Judge:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
