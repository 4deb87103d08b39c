#!/usr/bin/env python3
"""sink_client.py HOST PORT ISLAND MOTE OTHER: a program beside the island that uses the same sink (wsn.md 4, 5, 7).

It connects to the serial forwarder, tells MOTE to report its light every 250 ms, again until MOTE acknowledges that (the
radio may lose a command), and ends well when MOTE reported often enough, and a report of OTHER, which another program
asked for, was seen too. It prints how many commands it sent.
"""
import socket
import struct
import sys
import time

REPORTS = 6
SEQUENCE = 0x4D21


def exactly(stream, count):
    taken = b""
    while len(taken) < count:
        more = stream.recv(count - len(taken))
        if not more:
            sys.exit("the forwarder hung up")
        taken += more
    return taken


def periodic_command(island, mote):
    record = struct.pack(">BHH", 1, 1, 256)
    message = struct.pack(">HHHHBHBBB", island, mote, island, 0xFFFD, 1, SEQUENCE, 2 + len(record), 3, 5) + record
    return struct.pack(">BHHBBB", 0, 1, 0, len(message), 0, 0x1C) + message


def main():
    host, port = sys.argv[1], int(sys.argv[2])
    island, mote, other = map(int, sys.argv[3:])
    stream = socket.create_connection((host, port), 15)
    stream.settimeout(60)
    stream.sendall(b"\x55\x20")
    if exactly(stream, 2) != b"\x55\x20":
        sys.exit("no serial forwarder")
    command = periodic_command(island, mote)
    acknowledged, reports, others, commands, repeat = False, 0, 0, 0, 0
    while not (acknowledged and reports >= REPORTS and others > 0):
        if not acknowledged and time.monotonic() >= repeat:
            stream.sendall(bytes([len(command)]) + command)
            commands, repeat = commands + 1, time.monotonic() + 5
        packet = exactly(stream, exactly(stream, 1)[0])
        if packet[7] != 0x1C:
            continue
        *_, source, _, _, _, transport, _, kind, value = struct.unpack_from(">HHHHBHBBBBH", packet, 8)
        acknowledged |= (source, transport, kind, value) == (mote, 9, 0x17, SEQUENCE)
        reports += (source, transport, kind) == (mote, 3, 0x22)
        others += (source, transport, kind) == (other, 3, 0x22)
    print(commands)


main()
