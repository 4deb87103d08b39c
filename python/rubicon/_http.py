"""One question over HTTP, as a coroutine. The standard library parses the answer."""

from __future__ import annotations

import asyncio
import http.client
import io
import json
import ssl
from typing import Any, Awaitable, Dict, Mapping, NamedTuple, Optional, TypeVar
from urllib.parse import urlsplit

from ._door import error_of
from ._errors import Error

BUSY_PAUSE = 1.0  #: seconds before a busy server is asked again
_Result = TypeVar("_Result")
MAX_BODY = 256 * 1024 * 1024  #: bytes of an answer


class Server(NamedTuple):
    """Where a server is, and how it is spoken to."""

    host: str
    port: int
    tls: Optional[ssl.SSLContext]
    token: str
    timeout: float  #: seconds for an answer

    @classmethod
    def at(cls, url: str, token: str, ca: Optional[str], timeout: float) -> Server:
        """Raises Error: invalid for what is no address; refused where a token would be sent in clear to another host."""
        parts = urlsplit(url if "//" in url else f"http://{url}")
        if parts.scheme not in ("http", "https") or not parts.hostname or parts.path not in ("", "/"):
            raise Error("invalid", f"{url!r}: expected an address such as http://127.0.0.1:8642 or https://hall.lan:8642")
        try:
            port = parts.port or (443 if parts.scheme == "https" else 80)
        except ValueError:
            raise Error("invalid", f"{url!r}: its port is not a number up to 65535") from None
        if parts.scheme == "http":
            if token and parts.hostname not in ("127.0.0.1", "::1", "localhost"):
                raise Error("refused", f"{url}: a token goes to another host over https only")
            return cls(parts.hostname, port, None, token, timeout)
        try:
            tls = ssl.create_default_context(cafile=ca)
        except (OSError, ssl.SSLError) as error:
            raise Error("io", f"{ca}: {error}") from error
        return cls(parts.hostname, port, tls, token, timeout)

    @property
    def authority(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    @property
    def url(self) -> str:
        return f"{'https' if self.tls else 'http'}://{self.authority}"


class _Received:
    """What http.client takes for a socket."""

    def __init__(self, data: bytes) -> None:
        self._data = data

    def makefile(self, *_: Any) -> io.BytesIO:
        return io.BytesIO(self._data)


async def within(seconds: float, what: Awaitable[_Result]) -> _Result:
    """As asyncio.wait_for(), which before Python 3.12 loses a cancellation that comes together with the result."""
    task = asyncio.ensure_future(what)
    try:
        await asyncio.wait({task}, timeout=seconds)
        if task.done():
            return task.result()
    finally:
        task.cancel()
    raise asyncio.TimeoutError


async def ask(server: Server, path: str, accept: str = "application/json") -> bytes:
    """The body of the answer. A server that is busy is asked again, twice. Raises Error."""
    for attempt in range(3):
        try:
            return await within(server.timeout, _ask(server, path, accept))
        except asyncio.TimeoutError:
            raise Error("expired", f"{server.url}: no answer within {server.timeout:g} s") from None
        except Error as error:
            if error.code != "busy" or attempt == 2:
                raise
            await asyncio.sleep(BUSY_PAUSE * (1 + attempt))
    raise AssertionError


async def ask_json(server: Server, path: str) -> Dict[str, Any]:
    try:
        value = json.loads(await ask(server, path))
    except ValueError:
        value = None
    if not isinstance(value, dict):
        raise Error("invalid", f"{server.url}{path}: the answer is no JSON; is it a server of Rubicon?")
    return value


async def _ask(server: Server, path: str, accept: str) -> bytes:
    head = f"GET {path} HTTP/1.1\r\nHost: {server.authority}\r\nAccept: {accept}\r\nConnection: close\r\n"
    if server.token:
        head += f"Authorization: Bearer {server.token}\r\n"
    try:
        reader, writer = await asyncio.open_connection(server.host, server.port, ssl=server.tls, limit=1 << 20)
    except ssl.SSLCertVerificationError as error:
        text = f"{server.url}: its certificate is not accepted: {error.verify_message}"
        raise Error("refused", f"{text}; `ca=` names the file of your own authority") from error
    except OSError as error:
        raise Error("unreachable", f"{server.url}: {error.strerror or error}") from error
    try:
        writer.write((head + "\r\n").encode())
        received = bytearray()
        while True:
            block = await reader.read(1 << 18)
            if not block:
                break
            received += block
            if len(received) > MAX_BODY:
                raise Error("out-of-range", f"{server.url}{path}: the answer is longer than {MAX_BODY >> 20} MiB")
    except (OSError, ssl.SSLError) as error:
        raise Error("unreachable", f"{server.url}: {error}") from error
    finally:
        writer.close()
    return _body(server, path, bytes(received))


def _body(server: Server, path: str, received: bytes) -> bytes:
    response = http.client.HTTPResponse(_Received(received))  # type: ignore[arg-type]
    try:
        response.begin()
        body = response.read()
    except (http.client.HTTPException, ValueError, OSError) as error:
        raise Error("unreachable", f"{server.url}: the answer was cut or is no HTTP ({type(error).__name__})") from error
    if response.status < 400:
        return body
    raise error_of(_json_or_empty(body), f"{server.url}{path}: status {response.status} {response.reason}")


def _json_or_empty(body: bytes) -> Mapping[str, Any]:
    try:
        value = json.loads(body)
    except ValueError:
        value = {}
    return value if isinstance(value, dict) else {}
