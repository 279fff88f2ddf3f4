#!/usr/bin/env python3
"""Measures how the cost of a path grows with the number of instances, beside Mitsuba 3.

    MITSUBA_VARIANT=llvm_ad_rgb benches/forest_cost.py LODESTAR FOLDER [ROUNDS]

It needs a Python with `mitsuba`. FOLDER takes forests of 10^3 to 10^6 trees of 10^4 triangles (benches/forest.py). In each round both programs
render each forest for some seconds, in turns. The table has the medians: seconds of a path relative to those among 10^3 trees.
"""

import json
import os
import pathlib
import statistics
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
COUNTS = [10**3, 10**4, 10**5, 10**6]
TRIANGLES = 10**4
SECONDS = "8"
SIZE = (128, 96)


def lodestar(program, scene, out):
    """Seconds of a path."""
    command = [program, "render", scene, "--time", SECONDS, "--sampler", "bsdf", "--log", "json", "-o", out, "--overwrite"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    end = json.loads(done.stderr.strip().splitlines()[-1])
    return end["seconds"] / end["paths"]


def mitsuba(scene, out):
    command = [sys.executable, HERE / "mitsuba_render.py", scene, *map(str, SIZE), SECONDS, "1", out]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    samples, seconds = map(float, done.stdout.split()[-2:])
    return seconds / (samples * SIZE[0] * SIZE[1])


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__.strip())
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    rounds = int(sys.argv[3]) if len(sys.argv) == 4 else 3
    for count in COUNTS:
        if not (folder / str(count) / "scene.xml").exists():
            subprocess.run([sys.executable, HERE / "forest.py", str(count), str(TRIANGLES), folder / str(count)], check=True)
    found = {(name, count): [] for name in ("Lodestar", "Mitsuba") for count in COUNTS}
    for _ in range(rounds):
        for count in COUNTS:
            scene = folder / str(count) / "scene.xml"
            found["Lodestar", count].append(lodestar(program, scene, folder / "lodestar.exr"))
            found["Mitsuba", count].append(mitsuba(scene, folder / "mitsuba.exr"))
    median = {key: statistics.median(values) for key, values in found.items()}
    variant = os.environ.get("MITSUBA_VARIANT", "llvm_ad_rgb")
    print(f"| instances | Lodestar, us per path | growth | Mitsuba ({variant}), us per path | growth | growth over growth |")
    print("|---|---|---|---|---|---|")
    for count in COUNTS:
        ours, theirs = (median[name, count] for name in ("Lodestar", "Mitsuba"))
        growths = [median[name, count] / median[name, COUNTS[0]] for name in ("Lodestar", "Mitsuba")]
        print(
            f"| {count} | {1e6 * ours:.2f} | {growths[0]:.2f} | {1e6 * theirs:.2f} | {growths[1]:.2f} | {growths[0] / growths[1]:.2f} |"
        )


main()
