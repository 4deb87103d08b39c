#!/usr/bin/env python3
"""Several clients of a serial-forwarder server at once, written from wsn.md section 4 alone.

Usage: forwarder_client.py HOST PORT SILENCE

SILENCE is the number of seconds after which the server gives up on a client that does not greet. What this program and
the sink behind the server agree on besides (AM types nobody else uses):

    70 <id>            a client is there
    71 <n>             the sink shall send n beacons
    72 <id> <u16>      a numbered packet
    73 <u32 number> <counter>*6    a beacon: clients that are there, then what the server counted

Exit code 0 = all was as the document says; otherwise the last line of standard error says what was not.
"""

import socket
import struct
import sys

HELLO = b"\x55\x20"
PATIENCE = 30
COUNTERS = ("here", "slow", "silent", "strangers", "config", "bad")


class Wrong(Exception):
    pass


def expect(holds, text):
    if not holds:
        raise Wrong(text)


def packet(kind, payload):
    """Dispatch 00, then destination, source, length, group, type."""
    return struct.pack(">BHHBBB", 0, 1, 0, len(payload) & 0xFF, 0, kind) + payload


def framed(data):
    return bytes([len(data)]) + data


class Client:
    def __init__(self, address, receive_buffer=None):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        if receive_buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.socket.settimeout(PATIENCE)
        self.socket.connect(address)
        self.buffer = b""
        self.ended = False
        self.number = None  # of the last beacon

    def fill(self):
        """False at the end of the connection."""
        try:
            more = self.socket.recv(65536)
        except ConnectionResetError:
            more = b""
        self.buffer += more
        self.ended = self.ended or not more
        return bool(more)

    def take(self, size):
        while len(self.buffer) < size:
            expect(self.fill(), "the server disconnected")
        taken, self.buffer = self.buffer[:size], self.buffer[size:]
        return taken

    def hear_hello(self):
        expect(self.take(2) == HELLO, "the server's greeting is not 55 20")

    def greet(self, version=0x20):
        self.socket.sendall(bytes([0x55]))
        self.socket.sendall(bytes([version]))

    def say(self, data):
        self.socket.sendall(framed(data))

    def beacon(self):
        length = self.take(1)[0]
        expect(length > 0, "a packet of length 0 from the server")
        data = self.take(length)
        expect(data[7] == 0x73, "a packet that no beacon is: " + data.hex())
        number, *counters = struct.unpack(">I6B", data[8:18])
        expect(self.number in (None, number - 1), f"beacon {number} behind {self.number}")
        self.number = number
        return dict(zip(COUNTERS, counters))

    def ask(self, count):
        """So many beacons; what the last one says."""
        self.say(packet(0x71, bytes([count])))
        for _ in range(count):
            answer = self.beacon()
        return answer

    def follow(self, number):
        while self.number is None or self.number < number:
            self.beacon()

    def hear_end(self, what):
        while self.fill():
            pass
        expect(self.ended, what)


def strangers(address):
    for greeting in (b"\x55\x1f", b"\x54\x20", b"GET / HTTP/1.1\r\n\r\n"):
        client = Client(address)
        client.hear_hello()
        client.socket.sendall(greeting)
        client.hear_end("not disconnected after " + greeting.hex())
        expect(client.buffer == b"", "packets for one who did not greet")


def sender_of_zero(address):
    client = Client(address)
    client.hear_hello()
    client.greet()
    client.say(packet(0x72, b"\x09" + struct.pack(">H", 0)))
    client.socket.sendall(b"\x00")
    client.hear_end("not disconnected after a length of 0")


def refused_packets(client):
    before = client.ask(1)
    client.say(bytes.fromhex("00 0001 0000 03 00 25 0a 7d7e".replace(" ", "")))
    client.say(packet(0x72, bytes(115)))
    client.say(b"\x00\x00\x01")
    after = client.ask(1)
    expect(after["config"] == before["config"] + 1, "a Config packet was not refused")
    expect(after["bad"] == before["bad"] + 2, "packets too long and too short were not dropped")


def numbered_packets(client, name, count):
    stream = b"".join(framed(packet(0x72, bytes([name]) + struct.pack(">H", n) + bytes(n % 100))) for n in range(count))
    size = 1
    while stream:
        client.socket.sendall(stream[:size])
        stream = stream[size:]
        size = size * 2 % 1021 + 1


def flood_until_slow_is_dropped(one, two):
    for _ in range(2000):
        answer = one.ask(200)
        two.follow(one.number)
        if answer["slow"] == 1:
            return
    raise Wrong("a client that never reads is still there")


def drained(slow):
    """All that the server handed over before it gave up, in order, cut off anywhere."""
    slow.hear_hello()
    try:
        while True:
            slow.beacon()
    except Wrong as why:
        expect(str(why) == "the server disconnected", str(why))


def main():
    address = (sys.argv[1], int(sys.argv[2]))
    silent = Client(address)
    strangers(address)
    one, two, slow = Client(address), Client(address), Client(address, receive_buffer=4096)
    one.hear_hello()
    two.hear_hello()
    one.greet()
    two.greet(0x21)
    slow.greet()
    for name, client in ((1, one), (2, two), (3, slow)):
        client.say(packet(0x70, bytes([name])))
    while one.ask(1)["here"] < 3:
        pass
    sender_of_zero(address)
    refused_packets(one)
    numbered_packets(one, 1, 600)
    numbered_packets(two, 2, 600)
    flood_until_slow_is_dropped(one, two)
    drained(slow)
    silent.socket.settimeout(float(sys.argv[3]) + PATIENCE)
    silent.hear_end("a silent client is still there")
    expect(silent.buffer == HELLO, "packets for one who did not greet")
    expect(one.ask(1) == {"here": 3, "slow": 1, "silent": 1, "strangers": 4, "config": 1, "bad": 2}, "counters")
    two.follow(one.number)


if __name__ == "__main__":
    try:
        main()
    except (Wrong, OSError) as why:
        sys.exit(f"forwarder_client.py: {why!r}")
