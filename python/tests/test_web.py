"""Against a server that misbehaves."""

import asyncio
import json
import unittest
from unittest import mock

import rubicon
from rubicon import _http, _web

from .island import enter_private_network

SITE = {"version": "1", "release": "0.1.0", "caller": {"name": "local", "role": "admin"}}


def answer(body, status="200 OK", **fields):
    body = body if isinstance(body, bytes) else json.dumps(body).encode()
    head = {"Content-Length": len(body), "Connection": "close", **fields}
    lines = "".join(f"{name.replace('_', '-')}: {value}\r\n" for name, value in head.items())
    return f"HTTP/1.1 {status}\r\n{lines}\r\n".encode() + body


class Closing(unittest.IsolatedAsyncioTestCase):
    async def test_a_cancellation_that_was_lost_is_repeated(self):
        """As by asyncio.wait_for() before Python 3.12, where it comes together with a connection."""
        async def loses_one():
            try:
                await asyncio.Event().wait()
            except asyncio.CancelledError:
                await asyncio.Event().wait()

        door = _web.WebDoor(_http.Server.at("http://127.0.0.1:1", None, None, 5))
        door._task = asyncio.get_running_loop().create_task(loses_one())
        await asyncio.sleep(0)
        with mock.patch.object(_web, "CANCEL", 0.01):
            await asyncio.wait_for(door.close(), 10)
        self.assertTrue(door._task.cancelled())


@unittest.skipUnless(enter_private_network(), "this user may not have a private network")
class Answers(unittest.IsolatedAsyncioTestCase):
    async def asked(self, *answers, slice_size=1 << 20):
        """What a question makes of these answers, the last of which is repeated."""
        left = list(answers)

        async def serve(reader, writer):
            self.request = await reader.readuntil(b"\r\n\r\n")
            data = left.pop(0) if len(left) > 1 else left[0]
            for place in range(0, len(data), slice_size):
                writer.write(data[place : place + slice_size])
                await writer.drain()
                await asyncio.sleep(0)
            writer.close()

        async with await asyncio.start_server(serve, "127.0.0.1", 0) as server:
            port = server.sockets[0].getsockname()[1]
            one = _http.Server.at(f"http://127.0.0.1:{port}", "secret", None, 5)
            return await _http.ask_json(one, "/api/v1/islands")

    async def fails(self, code, *answers):
        with self.assertRaises(rubicon.Error) as caught:
            await self.asked(*answers)
        self.assertEqual(caught.exception.code, code, caught.exception)
        return caught.exception

    async def test_in_slices(self):
        for size in (1, 7, 100000):
            self.assertEqual(await self.asked(answer({"islands": []}), slice_size=size), {"islands": []})
        chunked = b'HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n4\r\n{"a"\r\n3\r\n:1}\r\n0\r\n\r\n'
        self.assertEqual(await self.asked(chunked, slice_size=1), {"a": 1})
        self.assertIn(b"Authorization: Bearer secret\r\n", self.request)

    async def test_cut_or_foreign(self):
        whole = answer({"islands": [1, 2, 3]})
        for length in (0, 1, 10, 40, len(whole) - 1):
            await self.fails("unreachable", whole[:length])
        await self.fails("unreachable", b"SSH-2.0-OpenSSH_9.2\r\n")
        await self.fails("invalid", answer(b"<html>"))
        await self.fails("invalid", answer([1]))
        await self.fails("io", answer(b"<html>", "404 Not Found"))

    async def test_errors_have_code_and_text(self):
        error = await self.fails("not-found", answer({"error": {"code": "not-found", "text": "no device x"}}, "404 Not Found"))
        self.assertEqual(error.text, "no device x")

    async def test_a_busy_server_is_asked_again(self):
        busy = answer({"error": {"code": "busy", "text": "more than 30 lists"}}, "429 Too Many Requests")
        with mock.patch.object(_http, "BUSY_PAUSE", 0.0):
            self.assertEqual(await self.asked(busy, busy, answer({"islands": []})), {"islands": []})
            await self.fails("busy", busy)

    async def test_a_cancellation_that_comes_with_the_result_counts(self):
        future = asyncio.get_running_loop().create_future()
        task = asyncio.ensure_future(_http.within(60, future))
        await asyncio.sleep(0)
        future.set_result(1)
        await asyncio.sleep(0)
        task.cancel()
        with self.assertRaises(asyncio.CancelledError):
            await task
        with self.assertRaises(asyncio.TimeoutError):
            await _http.within(0, asyncio.get_running_loop().create_future())

    async def test_endless_answers_are_bounded(self):
        with mock.patch.object(_http, "MAX_BODY", 1000):
            await self.fails("out-of-range", answer(b"x" * 2000))

    async def test_a_newer_version_says_so(self):
        async def serve(reader, writer):
            await reader.readuntil(b"\r\n\r\n")
            writer.write(answer({**SITE, "version": "2", "release": "9.0.0"}))
            writer.close()

        async with await asyncio.start_server(serve, "127.0.0.1", 0) as server:
            with self.assertRaisesRegex(rubicon.Error, "unsupported: .*version '2'.*9.0.0"):
                await rubicon.connect(f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}")


if __name__ == "__main__":
    unittest.main()
