#!/usr/bin/env python3
"""Measures how soon a page's camera shows where it has been dragged.

    benches/moving_view.py BINARY SCENE WIDTH HEIGHT [MOVES] [VIEW OPTIONS...]

It starts `lodestar view`, lets the camera rest for a moment, and drags it as the page does: the next move is sent when the picture of the
last one is there. It prints the time from a move that interrupts the camera at rest to its picture, the pictures in a second while dragging
with their sizes, and the time from the last move to the first picture of full size. It needs nothing but Python's standard library.
"""

import http.client
import json
import math
import statistics
import subprocess
import sys
import time


def page(binary, scene, width, height, options):
    command = [binary, "view", scene, "--width", width, "--height", height, *options]
    program = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    for line in program.stderr:
        if "http://" in line:
            host, token = line.split("http://")[1].strip().split("/#")
            return program, host, token
    sys.exit(f"{' '.join(command)} has ended")


class Client:
    def __init__(self, host, token):
        self.host, self.token = host, token
        self.connection = http.client.HTTPConnection(host)

    def ask(self, method, path):
        self.connection.request(method, path, headers={"X-Lodestar-Token": self.token, "Content-Length": "0"})
        answer = self.connection.getresponse()
        return answer.status, answer.headers, answer.read()

    def state(self):
        events = http.client.HTTPConnection(self.host)
        events.request("GET", "/events", headers={"X-Lodestar-Token": self.token})
        line = events.getresponse().readline()
        events.close()
        return json.loads(line.decode().removeprefix("data: "))

    def move(self, pose, is_moving):
        words = {name: ",".join(map(str, value)) if isinstance(value, list) else value for name, value in pose.items()}
        query = "&".join(f"{name}={value}" for name, value in words.items())
        begin = time.perf_counter()
        status, headers, content = self.ask("POST", f"/move?{query}&moving={int(is_moving)}&name=radiance")
        seconds = time.perf_counter() - begin
        if status != 200:
            sys.exit(f"a move was answered with {status}: {content.decode()}")
        frame = json.loads(headers["X-Frame"])
        return seconds, (frame["width"], frame["height"])


def turned(pose, angle):
    """The camera turned about its own vertical."""
    x, y, z = pose["forward"]
    c, s = math.cos(angle), math.sin(angle)
    return {**pose, "forward": [c * x + s * z, y, c * z - s * x]}


def main():
    binary, scene, width, height, *rest = sys.argv[1:]
    moves = int(rest[0]) if rest else 60
    program, host, token = page(binary, scene, width, height, rest[1:])
    try:
        client = Client(host, token)
        while (state := client.state())["phase"] != "resting" or state["samples"] < 2:
            time.sleep(0.1)
        pose = state["view"]["pose"]
        firsts = []
        for at in range(6):
            time.sleep(1.5)
            seconds, size = client.move(turned(pose, 0.002 * (at + 1)), True)
            firsts.append(seconds)
        begin, sizes, each = time.perf_counter(), [], []
        for at in range(moves):
            seconds, size = client.move(turned(pose, 0.012 + 0.002 * at), True)
            sizes.append(size)
            each.append(seconds)
        rate = moves / (time.perf_counter() - begin)
        begin = time.perf_counter()
        client.move(turned(pose, 0.012 + 0.002 * moves), False)
        while (state := client.state())["phase"] != "resting" or state["samples"] < 1:
            time.sleep(0.01)
        whole = time.perf_counter() - begin
        print(f"first picture after a move from rest: median {statistics.median(firsts):.3f} s, longest {max(firsts):.3f} s")
        print(f"while dragging: {rate:.1f} pictures a second, each median {statistics.median(each):.3f} s, longest {max(each):.3f} s, "
              f"of {statistics.mode(sizes)[0]} x {statistics.mode(sizes)[1]} pixels")
        print(f"first picture of {width} x {height} pixels after the last move: {whole:.2f} s")
    finally:
        program.terminate()
        program.wait()


if __name__ == "__main__":
    main()
