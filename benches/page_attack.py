#!/usr/bin/env python3
"""Attacks the page of a render until it is told to stop. Only for benches/page_under_attack.sh.

    benches/page_attack.py HOST:PORT

Each attack keeps some connections and opens new ones at a bounded rate. On SIGTERM it prints how many connections each attack has
opened. It connects to addresses of this machine only.
"""

import asyncio
import json
import os
import random
import signal
import sys

# Connections that each attack keeps open, and seconds between two new ones.
OPEN, PAUSE = 60, 0.1


def attacks(host):
    """Bytes of each attack, and the seconds between two bytes where they are sent one by one."""
    get = f"GET / HTTP/1.1\r\nHost: {host}\r\n"
    noise = random.Random(7)
    return {
        "silence": (b"", 0),
        "length 10^11": (f"{get}Content-Length: 99999999999\r\n\r\n".encode(), 0),
        "length 2^63-1": (f"{get}Content-Length: {2**63 - 1}\r\n\r\n".encode(), 0),
        "length 2^64-1": (f"{get}Content-Length: {2**64 - 1}\r\n\r\n".encode(), 0),
        "no content": (f"POST /stop HTTP/1.1\r\nHost: {host}\r\nContent-Length: 2000\r\n\r\n".encode(), 0),
        "endless line": (f"{get}X: ".encode() + b"a" * (1 << 20), 0),
        "endless lines": (get.encode() + b"X-Header: 1\r\n" * (1 << 16), 0),
        "events": (f"GET /events HTTP/1.1\r\nHost: {host}\r\n\r\n".encode(), 0),
        "pipelined": (f"GET /page.js HTTP/1.1\r\nHost: {host}\r\n\r\n".encode() * 1000, 0),
        "noise": (noise.randbytes(4096), 0),
        "a byte a second": (f"{get}X-Slow: ".encode() + b"a" * 3600, 1),
    }


async def attack(host, bytes_, pause, counts, name):
    address, port = host.rsplit(":", 1)
    kept = []
    while True:
        try:
            _, writer = await asyncio.open_connection(address, int(port))
            counts[name] += 1
            if pause:
                kept.append((writer, asyncio.create_task(send_slowly(writer, bytes_, pause))))
            else:
                writer.write(bytes_)
                kept.append((writer, None))
        except OSError:
            await asyncio.sleep(0.1)
        if len(kept) > OPEN:
            writer, task = kept.pop(0)
            if task:
                task.cancel()
            writer.transport.abort()
        await asyncio.sleep(PAUSE)


async def send_slowly(writer, bytes_, pause):
    try:
        for byte in bytes_:
            writer.write(bytes([byte]))
            await asyncio.sleep(pause)
    except OSError:
        pass


async def main(host):
    if not host.startswith("127.0.0.1:"):
        sys.exit("only addresses of this machine are attacked")
    counts = {name: 0 for name in attacks(host)}
    end = asyncio.Event()
    asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, end.set)
    tasks = [asyncio.create_task(attack(host, *how, counts, name)) for name, how in attacks(host).items()]
    await end.wait()
    print(json.dumps(counts), flush=True)
    # Nothing is closed in order: the connections end with the process.
    os._exit(0)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    asyncio.run(main(sys.argv[1]))
