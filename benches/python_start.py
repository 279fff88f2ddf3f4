#!/usr/bin/env python3
"""Measures how long Python takes to import lodestar, and to a first picture of one sample beside the command line.

usage: benches/python_start.py PYTHON LODESTAR SCENE.xml [ROUNDS]

PYTHON is an interpreter that has the wheel, LODESTAR the program. Rounds are interleaved; the table has medians of wall times of
whole processes.
"""

import statistics
import subprocess
import sys
import tempfile
import time


def main() -> None:
    python, program, scene = sys.argv[1:4]
    rounds = int(sys.argv[4]) if len(sys.argv) > 4 else 11
    with tempfile.TemporaryDirectory() as folder:
        output = f"{folder}/a.exr"
        render = f"import lodestar; lodestar.render({scene!r}, spp=1, width=64).save({output!r})"
        commands = {
            "python -c pass": [python, "-c", "pass"],
            "import numpy": [python, "-c", "import numpy"],
            "import lodestar": [python, "-c", "import lodestar"],
            "command line, one sample": [program, "render", scene, "--spp=1", "--width=64", "--quiet", "--overwrite", "-o", output],
            "python, one sample": [python, "-c", render],
        }
        seconds: dict[str, list[float]] = {name: [] for name in commands}
        for at in range(rounds + 1):
            for name, command in commands.items():
                begin = time.perf_counter()
                subprocess.run(command, check=True)
                # The first round warms the caches.
                if at > 0:
                    seconds[name].append(time.perf_counter() - begin)
    for name, measured in seconds.items():
        print(f"{name:<26} {statistics.median(measured):7.3f} s")
    ratios = [a / b for a, b in zip(seconds["python, one sample"], seconds["command line, one sample"])]
    print(f"{'python / command line':<26} {statistics.median(ratios):7.2f}")


main()
