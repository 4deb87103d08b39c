#!/usr/bin/env python3
"""post_message.py ISLAND TYPE TEXT: an application message in the form of docs/gateway.cddl, as a line for the shell."""
import struct
import sys


def head(major, count):
    if count < 24:
        return bytes([major << 5 | count])
    low, form = (24, ">BB") if count < 1 << 8 else (25, ">BH") if count < 1 << 16 else (26, ">BI")
    return struct.pack(form, major << 5 | low, count)


def cbor(item):
    if isinstance(item, int):
        return head(0, item)
    if isinstance(item, bytes):
        return head(2, len(item)) + item
    if isinstance(item, str):
        return head(3, len(item.encode())) + item.encode()
    return head(5, len(item)) + b"".join(cbor(key) + cbor(item[key]) for key in sorted(item))


island, tag, text = sys.argv[1:]
print("post", cbor({"v": 1, "origin": 0, "number": 0, "hops": 0, "from": {"island": 0}, "to": {"island": int(island)},
                    "kind": "opaque", "body": {"type": tag, "bytes": text.encode()}}).hex())
