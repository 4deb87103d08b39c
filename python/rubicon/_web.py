"""The door over WebSocket and HTTP: docs/api.md."""

from __future__ import annotations

import asyncio
import base64
import json
import time
from typing import Any, Callable, Dict, List, Optional, Set
from urllib.parse import urlencode

import websockets
from websockets.exceptions import WebSocketException

from ._door import Door, Following, error_of
from ._errors import Error
from ._feed import Feed, Stream
from ._http import Server, ask, ask_json, within
from ._values import Island, Json, Message, Outcome

VERSION = "1"  #: of the API
SILENCE = 12.0  #: seconds after which a line is lost; the server speaks every 5 s
RETRY = (0.25, 0.5, 0.75, 2.0, 5.0)  #: seconds before the next attempt
BUSY_PAUSE = 3.0
CANCEL = 1.5  #: seconds after which a cancellation counts as lost; a connection ends within one
PATIENCE = 5.0  #: seconds after a reconnection in which owners send their tuples
MAX_VALUE = 47 * 1024  #: bytes: a message to the server has at most 64 KiB, in base64

_decode = json.JSONDecoder(parse_float=str).decode  # times, which few programs read: a third of the work


class WebDoor(Door):
    def __init__(self, server: Server) -> None:
        self.server = server
        self.role = ""  #: of this caller: view, command, admin
        self.malformed = 0  #: frames that were not understood
        self._socket: Any = None
        self._task: Optional[asyncio.Task[None]] = None
        self._live: asyncio.Event  # made in the loop that opens the door: before Python 3.10 it belongs to one
        self._ids = 0
        self._answers: Dict[int, Callable[[Json], None]] = {}
        self._streams: Dict[Stream, Optional[int]] = {}
        self._numbered: Dict[int, Stream] = {}
        self._listeners: Dict[str, Set[Callable[[Message], None]]] = {}
        self._sending: Set[asyncio.Task[None]] = set()
        self._error: Optional[Error] = None
        self._heard = 0.0
        self._patience: Optional[asyncio.TimerHandle] = None

    # -- the line

    async def open(self) -> None:
        self._live = asyncio.Event()
        await self._check_site()
        self._task = asyncio.get_running_loop().create_task(self._run())
        await self._until_live(self.server.timeout)

    async def _check_site(self) -> None:
        """The server, its version and our token are still those that we can use."""
        site = await ask_json(self.server, "/api/v1")
        if site.get("version") != VERSION:
            text = f"{self.server.url} speaks version {site.get('version')!r} of the API, this package {VERSION}"
            raise Error("unsupported", f"{text}: use the package of the server's release {site.get('release', '')}")
        self.role = str((site.get("caller") or {}).get("role", ""))

    async def close(self) -> None:
        self.state = "closed"
        if self._patience is not None:
            self._patience.cancel()
        while self._task is not None and not self._task.done():
            self._task.cancel()  # lost if it comes together with a connection: asyncio.wait_for() before Python 3.12
            await asyncio.wait({self._task}, timeout=CANCEL)
        self._fail_answers()
        for feed in {stream.feed for stream in self._streams}:
            feed.end()

    async def _until_live(self, patience: float) -> None:
        if not self._live.is_set():
            try:
                await within(patience, self._live.wait())
            except asyncio.TimeoutError:
                raise Error("unreachable", f"{self.server.url}: the line is lost; it is tried again") from None
        if self._error is not None:
            raise self._error

    async def _run(self) -> None:
        attempt = 0
        while self._error is None:
            try:
                if self.state == "lost":
                    await self._check_site()
                async with websockets.connect(  # type: ignore[attr-defined]
                    f"{'wss' if self.server.tls else 'ws'}://{self.server.authority}/api/v1/ws",
                    ssl=self.server.tls, compression=None, max_size=None, max_queue=None, ping_interval=None,
                    open_timeout=self.server.timeout, close_timeout=1,
                ) as self._socket:
                    await self._greet()
                    attempt = 0
                    self._begin()
                    await self._receive()
            except (OSError, WebSocketException, asyncio.TimeoutError):
                pass
            except Error as error:
                self._error = error if error.code in ("refused", "unsupported") else None
            self._lose()
            await asyncio.sleep(RETRY[min(attempt, len(RETRY) - 1)])
            attempt += 1

    async def _greet(self) -> None:
        """Names the token, which a handshake cannot do the same way in all versions of websockets."""
        if not self.server.token:
            return
        self._ids += 1
        await self._socket.send(json.dumps({"id": self._ids, "do": "hello", "token": self.server.token}))
        while True:
            answer = json.loads(await within(self.server.timeout, self._socket.recv()))
            if isinstance(answer, dict) and answer.get("id") == self._ids:
                break
        if not answer.get("ok"):
            raise error_of(answer, "the server refused the token")

    def _begin(self) -> None:
        self.state = "live"
        self._live.set()
        for stream in list(self._streams):
            self._ask_for(stream)
        for kind in self._listeners:
            self._ask({"do": "listen", "type": kind}, lambda answer: None)
        feeds = {stream.feed for stream in self._streams}
        self._patience = asyncio.get_running_loop().call_later(PATIENCE, self._patience_ended, feeds)

    def _patience_ended(self, feeds: Set[Feed]) -> None:
        for feed in feeds:
            feed.patience_ended()

    async def _receive(self) -> None:
        loop = asyncio.get_running_loop()
        self._heard = loop.time()
        watchdog = loop.create_task(self._watch_silence())
        try:
            async for text in self._socket:
                self._heard = loop.time()
                self.take(text)
        finally:
            watchdog.cancel()

    async def _watch_silence(self) -> None:
        loop = asyncio.get_running_loop()
        while loop.time() < self._heard + SILENCE:
            await asyncio.sleep(self._heard + SILENCE - loop.time())
        await self._socket.close()

    def _lose(self) -> None:
        if self.state == "closed":
            return
        self.state = "lost"
        self._live.clear()
        if self._patience is not None:
            self._patience.cancel()
        self._numbered.clear()
        self._fail_answers()
        for stream in self._streams:
            self._streams[stream] = None
        for feed in {stream.feed for stream in self._streams}:
            feed.fail(self._error) if self._error else feed.restart()
        if self._error:
            self._live.set()  # who waits gets the error

    def _fail_answers(self) -> None:
        answers, self._answers = self._answers, {}
        for call in answers.values():
            call({"ok": False, "lost": True, "error": {"code": "unreachable", "text": f"{self.server.url}: line lost"}})

    # -- frames

    def take(self, text: Any) -> None:
        """A frame of the server. One that is not understood is counted, and changes nothing else."""
        try:
            frame = _decode(text)
            if "s" in frame and "id" not in frame:
                stream = self._numbered.get(frame["s"])
                if stream is not None:
                    stream.take(frame)
            elif "id" in frame:
                call = self._answers.get(frame["id"])
                if call is not None:
                    call(frame)
            elif "message" in frame:
                self._deliver(frame["message"])
            elif "lost" in frame and "s" in frame["lost"]:
                stream = self._numbered.get(frame["lost"]["s"])
                if stream is not None:
                    stream.feed.lost += int(frame["lost"].get("events", 0))
        except (ValueError, TypeError, LookupError, AttributeError, RecursionError, OverflowError):
            self.malformed += 1

    def _deliver(self, row: Json) -> None:
        data = base64.b64decode(row["b64"]) if "b64" in row else str(row.get("value", "")).encode()
        message = Message(int(row["from"]), str(row["type"]), data, str(row.get("network", "")), str(row.get("device", "")))
        for call in [*self._listeners.get(message.type, ()), *self._listeners.get("", ())]:
            call(message)

    def _ask(self, fields: Json, call: Callable[[Json], None], follow: bool = False) -> int:
        self._ids += 1
        number = self._ids

        def answered(answer: Json) -> None:
            if not follow or answer.get("final") or answer.get("ok") is False:
                self._answers.pop(number, None)
            call(answer)

        self._answers[number] = answered
        task = asyncio.get_running_loop().create_task(self._send(json.dumps({"id": number, **fields})))
        self._sending.add(task)
        task.add_done_callback(self._sending.discard)
        return number

    async def _send(self, text: str) -> None:
        try:
            await self._socket.send(text)
        except (OSError, WebSocketException):
            pass  # the line is lost: who waits hears of it

    async def _request(self, fields: Json, patience: float = 5.0) -> Json:
        """Its answer. Waits for a line that is lost, for the patience."""
        await self._until_live(patience)
        future: asyncio.Future[Json] = asyncio.get_running_loop().create_future()
        number = self._ask(fields, lambda answer: None if future.done() else future.set_result(answer))
        try:
            answer = await within(self.server.timeout, future)
        except asyncio.TimeoutError:
            raise Error("expired", f"{self.server.url}: no answer within {self.server.timeout:g} s") from None
        finally:
            self._answers.pop(number, None)
        if answer.get("ok") is not True:
            raise error_of(answer, "no answer")
        return answer

    # -- subscriptions

    def subscribe(self, stream: Stream) -> None:
        self._streams[stream] = None
        if self.state == "live":
            self._ask_for(stream)

    def unsubscribe(self, stream: Stream) -> None:
        number = self._streams.pop(stream, None)
        if number is not None:
            self._numbered.pop(number, None)
            if self.state == "live":
                self._ask({"do": "unsubscribe", "subscription": number}, lambda answer: None)

    def _ask_for(self, stream: Stream) -> None:
        flow = stream.flow
        fields: Json = {"do": "subscribe", "pattern": stream.pattern, "passive" if flow.passive else "active": True}
        if flow.minimum is not None:
            fields["min"] = flow.minimum * 1000
        if flow.maximum:
            fields["max"] = flow.maximum * 1000
        if flow.dead_band:
            fields["deadband"] = flow.dead_band
        if stream.full:
            fields["full"] = True
        self._ask(fields, lambda answer: self._subscribed(stream, answer))

    def _subscribed(self, stream: Stream, answer: Json) -> None:
        if answer.get("ok") is True:
            number = int(answer["subscription"])
            if stream not in self._streams:
                self._ask({"do": "unsubscribe", "subscription": number}, lambda _: None)
                return
            self._streams[stream] = number
            self._numbered[number] = stream
        elif stream in self._streams and not answer.get("lost"):
            error = error_of(answer, "not subscribed")
            if error.code != "busy":
                return stream.feed.fail(error)
            asyncio.get_running_loop().call_later(BUSY_PAUSE, self._ask_again, stream)

    def _ask_again(self, stream: Stream) -> None:
        if self.state == "live" and stream in self._streams and self._streams[stream] is None:
            self._ask_for(stream)

    # -- calls

    async def islands(self) -> List[Island]:
        answer = await ask_json(self.server, "/api/v1/islands")
        return [Island.of(row) for row in answer.get("islands", ())]

    async def devices(self, query: Dict[str, str]) -> List[Json]:
        return await self._pages("/api/v1/devices?" + urlencode(query), "devices")

    async def read(self, pattern: str) -> List[Json]:
        return await self._pages("/api/v1/tuples?" + urlencode({"pattern": pattern}), "tuples")

    async def _pages(self, path: Optional[str], member: str) -> List[Json]:
        rows: List[Json] = []
        while path:
            page = await ask_json(self.server, path)
            rows += page.get(member, [])
            path = page.get("next")
        return rows

    async def write(self, key: str, value: bytes, options: Json, wait: float) -> Outcome:
        if len(value) > MAX_VALUE:
            raise Error("out-of-range", f"{key}: {len(value)} bytes; over the web a set has at most {MAX_VALUE}")
        fields = dict(options)
        fields["do"] = "append" if fields.pop("append", False) else "set"
        fields["key"] = key
        if "lifetime" in fields:
            fields["expire"] = time.time() + fields.pop("lifetime")
        fields.update(_carried(value))
        if fields["do"] == "append" or not key.endswith(".command"):
            answer = await self._request(fields)
            return Outcome("applied", request=answer.get("request", 0), sequence=answer.get("sequence", 0))
        return await self._command(fields, wait)

    async def _command(self, fields: Json, wait: float) -> Outcome:
        await self._until_live(min(wait, fields.get("ttl") or 5.0))
        following = Following()
        number = self._ask(fields, following.take, follow=True)
        try:
            return await following.outcome(wait)
        finally:
            self._answers.pop(number, None)

    async def send(self, to: int, kind: str, data: bytes, network: str, device: str) -> None:
        where = {name: text for name, text in (("network", network), ("device", device)) if text}
        await self._request({"do": "send", "to": to, "type": kind, **where, **_carried(data)})

    async def listen(self, kind: str, call: Callable[[Message], None]) -> None:
        calls = self._listeners.setdefault(kind, set())
        calls.add(call)
        if len(calls) == 1:
            await self._request({"do": "listen", "type": kind})

    async def unlisten(self, kind: str, call: Callable[[Message], None]) -> None:
        calls = self._listeners.get(kind, set())
        calls.discard(call)
        if kind in self._listeners and not calls:
            del self._listeners[kind]
            if self.state == "live":
                self._ask({"do": "unlisten", "type": kind}, lambda answer: None)

    async def history(self, path: str, accept: Optional[str] = None) -> Any:
        if accept is None:
            return await ask_json(self.server, path)
        return (await ask(self.server, path, accept)).decode()


def _carried(data: bytes) -> Json:
    """Bytes as a frame has them."""
    try:
        return {"value": data.decode()}
    except UnicodeDecodeError:
        return {"b64": base64.b64encode(data).decode()}
