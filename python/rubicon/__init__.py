"""Rubicon for Python: read, watch and command the devices of islands (docs/python.md).

    async with rubicon.connect("http://127.0.0.1:8642") as space:
        for device in await space.devices(type="temperature"):
            print(device.name, device.status)
        async for event in space.watch("*.temperature-*", minimum="1s"):
            print(event.name, event.value, event.unit, event.quality)

`rubicon.sync` has the same without an event loop."""

from __future__ import annotations

import asyncio
import os
from pathlib import Path
from typing import Any, Coroutine, Dict, Mapping, Optional, Sequence, TypeVar, Union

from ._errors import Error, Refused
from ._feed import Watch
from ._listening import Judge, Messages
from ._space import Space
from ._values import Device, Event, Island, LogLine, Message, Outcome, RemoteSet, Sample, Value, Waiting

__version__ = "0.1.0"
__all__ = ["connect", "join", "run", "Device", "Error", "Event", "Island", "Judge", "LogLine",
           "Message", "Messages", "Outcome", "Refused",
           "RemoteSet", "Sample", "Space", "Value", "Waiting", "Watch"]

_Result = TypeVar("_Result")


def connect(url: str = "", token: Optional[str] = None, *, token_file: Union[str, Path, None] = None,
            ca: Union[str, Path, None] = None, timeout: float = 30) -> Space:
    """A space over the page of an island, or over `rubicon web` (docs/web.md).

    `url`: else RUBICON_URL, else http://127.0.0.1:8642. `token`: else the first line of `token_file`, else
    RUBICON_TOKEN, else that of RUBICON_TOKEN_FILE, else none. `ca`: a PEM file with your own authority, or the
    certificate itself; else the authorities of the system. `timeout`: seconds for an answer."""
    from ._http import Server
    from ._web import WebDoor

    url = url or os.environ.get("RUBICON_URL") or "http://127.0.0.1:8642"
    return Space(WebDoor(Server.at(url, _token(token, token_file), None if ca is None else str(ca), timeout)))


def join(space: str = "", *, name: str = "python", id: int = 0, folder: str = "", interfaces: Sequence[str] = (),
         broker: Optional[Mapping[str, Any]] = None) -> Space:
    """A space in which this process is a component, without a server. It needs the native module
    (python3-rubicon-native), and acts as the user of this process.

    `space`, `folder`: where the programs of this host meet (docs/host.md); else RUBICON_SPACE and RUBICON_FOLDER.
    `interfaces`: islands of other hosts too, by DDS. `broker`: of other sites, by MQTT (docs/sites.md): `host`, and
    `port`, `space`, `user`, `password`, `tls`, `ca_file`, `certificate_file`, `key_file`, `server_name`, `spare`, `all`,
    `trust`. `id` 0: a random one."""
    from ._component import ComponentDoor

    options: Dict[str, Any] = {"space": space, "name": name, "id": id, "folder": folder,
                               "interfaces": list(interfaces)}
    if broker is not None:
        options["broker"] = dict(broker)
    return Space(ComponentDoor(options))


def _token(token: Optional[str], file: Union[str, Path, None]) -> str:
    if token is None and file is None:
        token, file = os.environ.get("RUBICON_TOKEN"), os.environ.get("RUBICON_TOKEN_FILE")
    if token is None and file:
        try:
            lines = Path(file).read_text().split()
        except (OSError, ValueError) as error:
            raise Error("io", f"token file: {error}") from error
        token = lines[0] if lines else ""
    token = (token or "").strip()
    if not token.isascii() or not token.isprintable():
        raise Error("invalid", "the token has characters that no token has")
    return token


def run(main: Coroutine[Any, Any, _Result]) -> _Result:
    """asyncio.run(), with an error that says what to write where an event loop runs already, as in Jupyter."""
    if asyncio._get_running_loop() is None:
        return asyncio.run(main)
    main.close()
    raise Error("invalid", "an event loop runs already, as in Jupyter: write `await main()` in place of `run(main())`")
