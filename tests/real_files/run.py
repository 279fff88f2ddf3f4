#!/usr/bin/env python3
"""Renders real Mitsuba, pbrt-v4 and glTF files that nobody of this project wrote, and says what became of each.

    tests/real_files/run.py LODESTAR [--only TEXT] [--mitsuba] [--jobs N]

LODESTAR_REAL_FILES names the folder of the files; without it, nothing is done. No file of others is in this project: list.tsv
names repositories, commits and paths. A file lies at OWNER+REPOSITORY/PATH below the folder. Files that the list does not name are
tried, too.

Each file is rendered at one sample per pixel, 48 x 48 pixels. The outcomes:
  rendered   the picture was written
  refused    one sentence says why; where it is about a plugin, it names plugin, file and line
  absent     files that the scene names are not in the folder, and nothing else is at fault
  fragment   the file is no whole scene: it lacks <scene> or every <shape>, WorldBegin or every Shape, or a model has no triangles
  wrong      with --mitsuba: the picture differs from Mitsuba's; or the listed outcome is another
  crashed    any other end, or none within two minutes
A table of the outcomes by format, and of the reasons for refusals, ends the output. The exit status is 1 where a file is wrong or
crashed.

With --mitsuba (pip install mitsuba numpy), each rendered file that Mitsuba loads is rendered by both, twelve times with different
seeds. The means of 4 x 4 blocks must agree: |z| < 5 for each block and color channel, or else with 24 other seeds."""
import argparse
import collections
import concurrent.futures
import doctest
import os
import pathlib
import re
import subprocess
import sys
import tempfile

FOLDER = pathlib.Path(__file__).parent
SIZE, BLOCKS, SEEDS, SAMPLES, LIMIT, SECONDS = 48, 4, 12, 32, 5.0, 120
# Outcomes that the goal leaves out: what these words name is refused on purpose.
OUT_OF_SCOPE = re.compile(r"<medium|<volume|MakeNamedMedium|polari|fourier|measured|transient|fluor|stokes|fmcw|tof|hair|sdfgrid|yan16|layered", re.I)
ABSENT = re.compile(r"does not exist|git-lfs|cannot be read: No such file", re.I)
# Models of points, of lines, of animations alone.
EMPTY = "has neither triangles nor a camera"
# Formats by the endings of names, and the marks that a whole text has.
FORMATS = {
    ".xml": ("Mitsuba", ["<scene", "<shape"]),
    ".pbrt": ("pbrt", ["WorldBegin", "Shape"]),
    ".gltf": ("glTF", []),
    ".glb": ("glTF", []),
}
OUTCOMES = ["rendered", "refused", "absent", "fragment", "wrong", "crashed"]
# Last line of a message that does not list all faults.
MORE = re.compile(r"and \d+ more")
WHERE = re.compile(r"^.*?[^\s:]:\d+: ")


def expected():
    """Listed outcomes by path below the folder."""
    lines = (FOLDER / "list.tsv").read_text(encoding="utf8").splitlines()
    rows = [line.split("\t") for line in lines if line and not line.startswith("#")]
    return {f"{repository.replace('/', '+')}/{path}": outcome for repository, _commit, path, outcome in rows}


def render(binary, path, out, *more):
    command = [binary, "render", path, "--width", str(SIZE), "--height", str(SIZE), "-q", "-o", out, *more]
    return subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=SECONDS)


def outcome(binary, path):
    name, marks = FORMATS[path.suffix.lower()]
    text = path.read_text(encoding="utf8", errors="replace") if marks else ""
    if any(mark not in text for mark in marks):
        return "fragment", ""
    with tempfile.TemporaryDirectory() as folder:
        try:
            done = render(binary, path, f"{folder}/a.exr", "--spp", "1")
        except subprocess.TimeoutExpired:
            return "crashed", f"no end within {SECONDS} s"
    return end_of(done.returncode, done.stderr, has_lines=name != "glTF")


def end_of(status, stderr, has_lines=True):
    """Outcome by the exit status and what the program said, and the message. Files of bytes have no lines.

    >>> end_of(1, "error: a.xml:3: the mesh file `a.obj` does not exist")[0]
    'absent'
    >>> missing = "  a.xml:3: the mesh file `a.obj` does not exist"
    >>> end_of(1, f"error: the scene has 2 faults:\\n{missing}\\n{missing}")[0]
    'absent'
    >>> end_of(1, f"error: the scene has 2 faults:\\n{missing}\\n  a.xml:7: bsdf plugin `x` is not supported")[0]
    'refused'
    >>> end_of(1, f"error: the scene has 2 faults:\\n{missing}\\n  something is not supported")[0]
    'crashed'
    >>> end_of(1, f"error: the scene has 73 faults:\\n{missing}\\n  and 72 more")[0]
    'absent'
    >>> end_of(101, "thread 'main' panicked")[0]
    'crashed'
    >>> end_of(1, "error: a.glb: its scene has neither triangles nor a camera; points", has_lines=False)[0]
    'fragment'
    >>> end_of(1, "error: a.glb: it requires the extension ACME, which is not supported", has_lines=False)[0]
    'refused'
    """
    lines = stderr.strip().splitlines()
    # Where a scene has several faults, a line for each follows the one that counts them.
    start = next((index for index in reversed(range(len(lines))) if "error:" in lines[index]), max(len(lines) - 1, 0))
    message = " ".join(line.strip() for line in lines[start:])
    if status == 0:
        return "rendered", ""
    if status != 1 or "panicked" in stderr:
        return "crashed", f"exit status {status}: {message}"
    faults = [line.strip() for line in lines[start + 1 :]] if len(lines) > start + 1 else [message.partition("error: ")[2]]
    others = [fault for fault in faults if not ABSENT.search(fault) and not MORE.fullmatch(fault)]
    # A file that lacks a mesh, and is refused for another reason too, would be refused with the mesh as well.
    if not others:
        return "absent", message
    if EMPTY in message:
        return "fragment", message
    unplaced = [fault for fault in others if has_lines and not WHERE.search(fault)]
    if unplaced:
        return "crashed", f"the message names no line: {unplaced[0]}"
    return "refused", message


def reason_of(message):
    """Kind of a refusal: its first fault without places, names and numbers.

    >>> reason_of("error: the scene has 2 faults: a/b.xml:3: bsdf plugin `hair` is not supported; use one of `x` c.xml:4: d")
    'bsdf plugin `hair` is not supported'
    >>> reason_of("error: a.pbrt:7: more than 1000 shapes")
    'more than # shapes'
    """
    message = re.sub(r"^.*?error: (the scene has \d+ faults: )?", "", message)
    message = re.sub(r"^\S+?\.(xml|pbrt|gltf|glb)(:\d+)?: ", "", message)
    return re.sub(r"\d+", "#", message.split(";")[0])[:90]


def print_table(tally, reasons):
    """Prints the outcomes by format, and the commonest refusals."""
    print(f"\n{'':10}" + "".join(f"{kind:>10}" for kind in OUTCOMES))
    for name in sorted({name for name, _ in tally}):
        print(f"{name:10}" + "".join(f"{tally[name, kind]:>10}" for kind in OUTCOMES))
    for (name, reason), count in reasons.most_common(30):
        print(f"{count:5}  {name}: {reason}")


def block_means(picture):
    import numpy as np

    blocks = np.asarray(picture, dtype=np.float64)[..., :3].reshape(BLOCKS, SIZE // BLOCKS, BLOCKS, SIZE // BLOCKS, 3)
    return blocks.mean(axis=(1, 3))


def mitsuba_means(path, seeds):
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    scene = mi.load_file(str(path))
    sensor = scene.sensors()[0]
    # Through the sensor, which must learn of the new aspect.
    parameters = mi.traverse(sensor)
    parameters["film.size"] = [SIZE, SIZE]
    parameters["film.crop_size"] = [SIZE, SIZE]
    parameters["film.crop_offset"] = [0, 0]
    parameters.update()
    return [block_means(mi.render(scene, spp=SAMPLES, seed=seed)) for seed in seeds]


def our_means(binary, path, seeds):
    import mitsuba as mi

    # Mitsuba's path has no greatest depth by itself.
    text = path.read_text(encoding="utf8", errors="replace")
    more = [] if re.search(r"max_?depth|type=\"(direct|prb)", text, re.I) else ["--max-depth", "64"]
    means = []
    with tempfile.TemporaryDirectory() as folder:
        for seed in seeds:
            out = f"{folder}/{seed}.exr"
            render(binary, path, out, "--spp", str(SAMPLES), "--seed", str(seed), *more).check_returncode()
            root = dict(mi.Bitmap(out).split())["<root>"]
            means.append(block_means(root))
    return means


def compare(binary, path):
    """Returns whether Mitsuba and Lodestar agree (None where Mitsuba does not load the file), and a sentence. A difference
    counts where other seeds find it again, because there are many blocks and few seeds."""
    for seeds in (range(SEEDS), range(SEEDS, 3 * SEEDS)):
        try:
            theirs = mitsuba_means(path, seeds)
        except Exception as error:  # Mitsuba raises many kinds.
            return None, "Mitsuba: " + " ".join(str(error).split())[-160:]
        try:
            ours = our_means(binary, path, seeds)
        except subprocess.TimeoutExpired:
            return None, f"Lodestar: {SAMPLES} samples took more than {SECONDS} s, so nothing is compared"
        agrees, message = judge(ours, theirs)
        if agrees:
            break
    return agrees, message


def judge(ours, theirs):
    import numpy as np

    ours, theirs = np.array(ours), np.array(theirs)
    difference = ours.mean(axis=0) - theirs.mean(axis=0)
    # Rounding of single precision bounds the error from below.
    floor = 1e-4 * np.abs(theirs.mean(axis=0)) + 1e-9
    error = np.sqrt(ours.var(axis=0, ddof=1) / len(ours) + theirs.var(axis=0, ddof=1) / len(theirs) + floor**2)
    z = np.abs(difference / error).max()
    ratio = ours.mean() / max(theirs.mean(), 1e-30)
    return bool(z < LIMIT), f"largest |z| {z:.2f}, mean {ratio:.5f} of Mitsuba's"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lodestar")
    parser.add_argument("--only", default="", help="tries files whose path contains this text")
    parser.add_argument("--mitsuba", action="store_true", help="compares with Mitsuba's pictures")
    parser.add_argument("--jobs", type=int, default=1)
    arguments = parser.parse_args()
    if doctest.testmod().failed:
        return 1
    folder = os.environ.get("LODESTAR_REAL_FILES")
    if not folder:
        print("skipped: LODESTAR_REAL_FILES names no folder of files")
        return 0
    paths = [path for path in sorted(pathlib.Path(folder).rglob("*.*")) if path.suffix.lower() in FORMATS]
    paths = [path for path in paths if arguments.only in str(path)]
    listed, tally, in_scope, reasons = expected(), collections.Counter(), collections.Counter(), collections.Counter()
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        results = pool.map(lambda path: outcome(arguments.lodestar, path), paths)
        for path, (kind, message) in zip(paths, results):
            name = str(path.relative_to(folder))
            wanted = listed.get(name, kind)
            if wanted != kind and not (kind == "refused" and wanted in message):
                kind, message = "wrong", f"{kind}, but `{wanted}` is listed. {message}"
            elif kind == "rendered" and arguments.mitsuba and path.suffix == ".xml":
                agrees, message = compare(arguments.lodestar, path)
                kind = "wrong" if agrees is False else kind
            of_format = FORMATS[path.suffix.lower()][0]
            tally[of_format, kind] += 1
            if kind == "refused":
                reasons[of_format, reason_of(message)] += 1
            if kind not in ("fragment", "absent") and of_format != "glTF" and not OUT_OF_SCOPE.search(path.read_text(errors="replace")):
                in_scope[kind] += 1
            print(f"{kind:9} {name}  {message}".rstrip(), flush=True)
    print_table(tally, reasons)
    share = in_scope["rendered"] / max(sum(in_scope.values()), 1)
    print(f"of the texts with assets and without media, polarization or measured data: {dict(in_scope)}, {share:.3f} rendered")
    return 1 if any(kind in ("wrong", "crashed") for _, kind in tally) else 0


if __name__ == "__main__":
    sys.exit(main())
