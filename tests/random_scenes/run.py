#!/usr/bin/env python3
"""Renders random scenes with Lodestar and with Mitsuba 3 (pip install mitsuba numpy), and compares the means of blocks.

usage: tests/random_scenes/run.py BINARY [--seed S] [--first N] [--count N] [--jobs N] [--samples N] [--keep DIR] [--no-shrink] [--twin]

Scene N of seed S is the same in every run. `--samples` is the number per pixel of the first round (default: 256). Each scene is rendered with options that its number chooses. A scene that differs is shrunk
and kept in DIR (default: target/random_scenes) with its files. Scenes of cases in which Mitsuba is known to be wrong (known.py,
docs/differences.md) are counted apart, and so are scenes that crash Mitsuba. `--twin` multiplies Lodestar's light by 1.05, which must be found in every scene. The exit code is 1 where another scene differs, or where only one of the two renders it."""

import argparse
import collections
import concurrent.futures
import concurrent.futures.process
import multiprocessing
import pathlib
import shutil
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import generate
import known

# Options by the number of a scene. Without emitter sampling, lights without a size would be lost.
OPTIONS = [[], [], ["--sampler", "bsdf"], ["--sampler", "rejection"], ["--execution", "wavefront"], ["--nee", "off"], ["--sampler", "quadtree"]]


def options_of(root, number):
    options = OPTIONS[number % len(OPTIONS)]
    has_delta = any(emitter.get("type") in ("point", "spot", "directional", "projector") for emitter in root.iter("emitter"))
    return [] if has_delta and "--nee" in options else options


def judge(work):
    """Row of one scene: its number, outcome, cases and words."""
    import compare
    import shrink

    binary, seed, number, samples, keep, shrinks, factor = work
    with tempfile.TemporaryDirectory(prefix="random-scene-") as folder:
        root = generate.Generator(seed * 1_000_003 + number, folder).scene()
        options, cases = options_of(root, number), known.cases(root)
        path = generate.write(root, folder)
        try:
            verdict = compare.compare(binary, path, options, samples=samples, factor=factor)
        except compare.Refused as refused:
            _keep(folder, keep / f"{seed}-{number}-refused")
            return number, "refused", cases, str(refused)
        words = f"z {verdict.z:.1f}, ratio {verdict.ratio:.4f}, options {' '.join(options) or 'none'}"
        if not verdict.differs:
            return number, "agrees", cases, words
        if cases:
            return number, "known", cases, words
        if shrinks:

            def stays(smaller):
                try:
                    return compare.compare(binary, generate.write(smaller, folder, "smaller.xml"), options, 11, samples, 2, factor).differs
                except compare.Refused:
                    return False

            root = shrink.shrink(root, stays)
            generate.write(root, folder, "smallest.xml")
        _keep(folder, keep / f"{seed}-{number}")
        return number, "differs", cases, words


def judge_apart(work):
    """`judge` in a process of its own, because Mitsuba may end by a fault of memory."""
    with concurrent.futures.ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
        try:
            return process.submit(judge, work).result()
        except concurrent.futures.process.BrokenProcessPool:
            return work[2], "crashed", [], "Mitsuba ended by a signal"


def _keep(folder, target):
    shutil.rmtree(target, ignore_errors=True)
    shutil.copytree(folder, target)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binary")
    for name, default in (("seed", 1), ("first", 0), ("count", 100), ("jobs", 1), ("samples", 256)):
        parser.add_argument(f"--{name}", type=int, default=default)
    parser.add_argument("--keep", type=pathlib.Path, default=pathlib.Path("target/random_scenes"))
    parser.add_argument("--no-shrink", action="store_true")
    parser.add_argument("--twin", action="store_true")
    given = parser.parse_args()
    shrinks, factor = not (given.no_shrink or given.twin), 1.05 if given.twin else 1.0
    work = [(given.binary, given.seed, n, given.samples, given.keep, shrinks, factor) for n in range(given.first, given.first + given.count)]
    counts, causes = collections.Counter(), collections.Counter()
    with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        for number, outcome, cases, words in pool.map(judge_apart, work):
            counts[outcome] += 1
            causes.update(cases if outcome == "known" else [])
            if outcome != "agrees":
                print(f"seed {given.seed} scene {number}: {outcome} {words}{' ' + ', '.join(cases) if cases else ''}", flush=True)
    print(f"seed {given.seed}: " + ", ".join(f"{counts[outcome]} {outcome}" for outcome in ("agrees", "known", "differs", "refused", "crashed")))
    for case, count in causes.most_common():
        print(f"  {count} {case}: {getattr(known, case).__doc__}")
    if given.twin:
        return 1 if counts["agrees"] or counts["refused"] else 0
    # Mitsuba crashes now and then. Where most scenes crash, nothing was compared.
    return 1 if counts["differs"] or counts["refused"] or counts["crashed"] > counts["agrees"] + counts["known"] else 0


if __name__ == "__main__":
    sys.exit(main())
